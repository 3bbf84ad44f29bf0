"""Tutorials and how-to pages do what they say: their commands and programs run, and print what the pages show."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from echoplan.io import write_recording
from echoplan.sources import open_source
from helpers.bags import JAZZY, Robot, drive, write_mcap
from helpers.typed import succeed

ROOT = Path(__file__).parents[2]
# Fleets, devices, the live page and ROS 2 are tested by themselves: they need a cluster, a device, a browser, a robot.
PAGES = sorted(
    path.relative_to(ROOT / "docs").as_posix()
    for folder in ("tutorials", "howto")
    for path in (ROOT / "docs" / folder).glob("*.md")
    if path.stem not in ("index", "batch", "calibrate", "live", "ros2-live")
)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Make the files with which the pages begin, and let all be done beside them."""
    shutil.copy(ROOT / "examples" / "serial-log.txt", tmp_path / "log.txt")
    write_recording(tmp_path / "rec", open_source("sim:square,seed=1"))
    write_mcap(tmp_path / "run.mcap", drive(open_source("sim:square,rig=ring-16,seed=1"), Robot(JAZZY)))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def blocks(page: str) -> list[tuple[str, str]]:
    """Language and content of the blocks of a page."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    return re.findall(r"^```(sh|python|text)\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)


def commands(content: str) -> list[list[str]]:
    """Words of the commands in a block, without their comments."""
    return [words for line in content.splitlines() if (words := shlex.split(line, comments=True))]


@pytest.mark.parametrize("page", PAGES)
def test_the_commands_and_programs_of_a_page_run_and_print_what_it_shows(page: str, folder: Path) -> None:
    printed = (folder / "log.txt").read_text(encoding="utf-8")
    names: dict[str, object] = {"__name__": "__main__"}
    for language, content in blocks(page):
        if language == "python":
            exec(compile(content, page, "exec"), names)
        elif language == "sh":
            for program, *words in commands(content):
                assert program == "echoplan"
                printed += succeed(*words)
        else:
            seen = {" ".join(line.split()) for line in printed.splitlines()}
            shown = [" ".join(line.split()) for line in content.splitlines()]
            assert [line for line in shown if line not in seen] == []


def test_each_tutorial_has_commands_that_are_run() -> None:
    tutorials = [page for page in PAGES if page.startswith("tutorials/")]
    assert len(tutorials) >= 3
    assert [page for page in tutorials if "sh" not in [language for language, _ in blocks(page)]] == []
