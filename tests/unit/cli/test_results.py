import tomllib
from pathlib import Path

import numpy as np
import pytest

from echoplan.cli.results import PICTURES, Results, results_folder, say_what_was_found, write_results
from echoplan.config import Run
from echoplan.errors import OutputError
from echoplan.io import read_map
from echoplan.model import Truth
from echoplan.preprocessing import KmeansSettings
from echoplan.viewer import Plan
from helpers import maps
from helpers.drawings import gapped_map


def results(truth: Truth | None = None) -> Results:
    """Results of a run that found the walls of a room."""
    found = maps.drawn(*(maps.wall(*ends) for ends in maps.ROOM.walls_xy), poses=maps.ROOM.poses)
    return Results(
        title="A room",
        run=Run(source="rec/", method="by hand", seed=7),
        settings={"method": KmeansSettings(min_members=4)},
        plan=Plan(feature_map=found, truth=truth, detections=(), echoes_xy=np.zeros((0, 2))),
        times=np.arange(float(len(found.sweeps))),
    )


def test_five_files_are_left_and_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_results(tmp_path / "out", results())
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "map.json",
        "map.svg",
        "report.html",
        "run.toml",
        "trajectory.tum",
    ]
    assert "map.json, map.svg, report.html, trajectory.tum, run.toml" in capsys.readouterr().out


def test_the_map_and_the_settings_are_those_of_the_run(tmp_path: Path) -> None:
    write_results(tmp_path, results())
    assert len(read_map(tmp_path / "map.json").walls) == len(maps.ROOM.walls_xy)
    record = tomllib.loads((tmp_path / "run.toml").read_text(encoding="utf-8"))
    assert (record["run"]["source"], record["run"]["seed"], record["method"]["min_members"]) == ("rec/", 7, 4)


def test_the_report_has_the_title_the_settings_and_with_a_truth_how_good_the_map_is(tmp_path: Path) -> None:
    texts = []
    for truth in (None, maps.ROOM):
        write_results(tmp_path, results(truth))
        texts.append((tmp_path / "report.html").read_text(encoding="utf-8"))
    for text in texts:
        assert "A room" in text
        assert "min_members" in text
    assert ["Recall and precision" in text for text in texts] == [False, True]


def test_an_unwritable_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match="choose another place"):
        write_results(tmp_path / "out", results())
    assert (tmp_path / "out").read_text(encoding="utf-8") == "mine"


def test_pictures_that_a_run_does_not_make_go_and_others_stay(tmp_path: Path) -> None:
    for made in (("map", "figure-05-fit"), ("map",)):
        with results_folder(tmp_path, results()) as draft:
            (draft / PICTURES).mkdir()
            for name in made:
                (draft / PICTURES / f"{name}.png").touch()
        (tmp_path / PICTURES / "mine.png").touch()
    assert sorted(path.name for path in (tmp_path / PICTURES).iterdir()) == ["map.png", "mine.png"]


def test_what_was_found_is_said_in_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    say_what_was_found(results().plan)
    assert capsys.readouterr().out == "6 walls, 0 corners and 0 cylinders, detected from 2 stations.\n"


def test_openings_are_listed_with_their_widths(capsys: pytest.CaptureFixture[str]) -> None:
    say_what_was_found(Plan(feature_map=gapped_map()))
    printed = capsys.readouterr().out
    assert "0.900 ± 0.039" in printed
    assert "driven through" in printed
    assert "seen through" in printed
