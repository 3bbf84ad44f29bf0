import logging
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from echoplan.cli.terminal import Progressing, busy, put, report_files, show, tracked
from echoplan.model import Recording, Table
from helpers import scenes


@pytest.fixture
def recording() -> Recording:
    sweeps = tuple(scenes.sweep_of(np.ones(360), index=index) for index in range(3))
    return Recording(name="take", rig=scenes.rig(), sweeps=sweeps)


def test_a_source_that_shows_a_bar_is_the_same_source(recording: Recording) -> None:
    progressing = Progressing(recording, "reading")
    assert (progressing.name, progressing.rig, len(progressing)) == ("take", recording.rig, 3)
    assert list(progressing) == list(recording)
    assert [sweep.index for sweep in progressing] == [0, 1, 2]


def test_sweeps_are_passed_on_one_by_one_and_not_hoarded() -> None:
    passed: list[int] = []

    def numbers() -> Iterator[int]:
        for number in range(3):
            passed.append(number)
            yield number

    items = tracked(numbers(), total=3, task="counting")
    assert next(items) == 0
    assert passed == [0]
    assert list(items) == [1, 2]


def test_a_pipe_is_shown_no_bar(recording: Recording, capsys: pytest.CaptureFixture[str]) -> None:
    assert len(list(Progressing(recording, "reading"))) == 3
    assert capsys.readouterr() == ("", "")


def test_on_a_narrow_terminal_columns_come_below_each_other_and_nothing_is_cut(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("echoplan.cli.terminal._PIPE_WIDTH", 30)
    rows = (("joint", "100 / 100", "0.123456", "1.5"), ("mdp-fuzzy", "99 / 98", "12.5", "2.25"))
    columns = ("method", "walls (%)", "distance deviation (mm)", "angle (°)")
    show(Table(title="All", columns=columns, rows=rows))
    lines = [line.split() for line in capsys.readouterr().out.splitlines() if line.strip()]
    assert lines[0] == ["All"]
    assert [line[0] for line in lines].count("mdp-fuzzy") == 2
    words = " ".join(word for line in lines for word in line)
    assert all(cell in words for row in rows for cell in (*row, "deviation", "angle"))
    assert "…" not in words


def test_a_pipe_gets_wide_plain_lines(capsys: pytest.CaptureFixture[str]) -> None:
    line = "word " * 39
    put(line.strip())
    assert capsys.readouterr().out == line.strip() + "\n"


def test_a_table_has_its_names_to_the_left_and_its_numbers_to_the_right(capsys: pytest.CaptureFixture[str]) -> None:
    rows = (("mean", "5.2"), ("greatest", "12.8"))
    show(Table(title="Walls", columns=("wall", "off (mm)"), rows=rows))
    title, head, *lines = (line.rstrip() for line in capsys.readouterr().out.splitlines())
    assert title == "Walls"
    assert head.split() == ["wall", "off", "(mm)"]
    assert [line.split() for line in lines[:2]] == [["mean", "5.2"], ["greatest", "12.8"]]
    assert len(lines[0]) == len(lines[1]) == len(head)
    assert lines[0].startswith("mean ")


@pytest.mark.parametrize(("folder", "beginning"), [("out", "Written to out"), (".", "Written")])
def test_files_are_reported_with_their_folder_unless_it_is_the_current_one(
    folder: str, beginning: str, capsys: pytest.CaptureFixture[str]
) -> None:
    report_files(Path(folder), ["map.json", "map.svg"])
    assert capsys.readouterr().out == f"{beginning}: map.json, map.svg\n"


def test_a_terminal_shows_what_is_being_done_and_what_is_logged_meanwhile(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FORCE_COLOR", "1")
    with busy("thinking"):
        logging.getLogger("echoplan").info("Compiling [once]")
    logging.getLogger("echoplan").info("too late")
    shown = capsys.readouterr()
    assert shown.out == ""
    assert "thinking" in shown.err
    assert "Compiling [once]" in shown.err
    assert "too late" not in shown.err


def test_a_pipe_is_shown_nothing_of_what_is_being_done(capsys: pytest.CaptureFixture[str]) -> None:
    with busy("thinking"):
        logging.getLogger("echoplan").info("Compiling")
    assert capsys.readouterr() == ("", "")


def test_a_bar_leaves_the_level_of_the_log_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    logger = logging.getLogger("echoplan")
    monkeypatch.setenv("FORCE_COLOR", "1")
    before, during = logger.level, list[int]()
    for _ in tracked([0], total=1, task="counting"):
        during.append(logger.level)
    assert during == [logging.INFO]
    assert (logger.level, logger.handlers) == (before, [])
