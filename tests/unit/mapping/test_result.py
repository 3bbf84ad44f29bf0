import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.config import Run
from echoplan.errors import InputError, InvalidValueError, OutputError, UnknownNameError
from echoplan.io import builtin_rig, read_map, read_trajectory
from echoplan.mapping import PICTURES, MapResult, map_source, results_folder
from echoplan.model import Sweep, Truth
from echoplan.preprocessing import KmeansSettings
from echoplan.viewer import Plan
from helpers import maps


def at_station(index: int, pose: FloatArray) -> Sweep:
    """A sweep of three pings, a second apart."""
    return Sweep(
        index=index,
        stamps_ns=10_000_000_000 * index + 1_000_000_000 * np.arange(3),
        sensor_ids=np.arange(3),
        servo_angles=np.zeros(3),
        ranges=np.ones(3),
        map_from_base=np.array([pose] * 3),
    )


def result(truth: Truth | None = None) -> MapResult:
    """Result of a run that found the walls of a room."""
    found = maps.drawn(*(maps.wall(*ends) for ends in maps.ROOM.walls_xy), poses=maps.ROOM.poses)
    return MapResult(
        title="A room",
        run=Run(source="rec/", method="by hand", seed=7),
        settings={"method": KmeansSettings(min_members=4)},
        plan=Plan(feature_map=found, truth=truth, detections=(), echoes_xy=np.zeros((0, 2))),
        rig=builtin_rig("rotary-array"),
        sweeps=tuple(at_station(*station) for station in zip(found.sweeps.tolist(), found.poses, strict=True)),
    )


def test_five_files_are_saved(tmp_path: Path) -> None:
    result().save(tmp_path / "out")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "map.json",
        "map.svg",
        "report.html",
        "run.toml",
        "trajectory.tum",
    ]


def test_the_map_and_the_settings_are_those_of_the_run(tmp_path: Path) -> None:
    result().save(tmp_path)
    assert len(read_map(tmp_path / "map.json").walls) == len(maps.ROOM.walls_xy)
    record = tomllib.loads((tmp_path / "run.toml").read_text(encoding="utf-8"))
    assert (record["run"]["source"], record["run"]["seed"], record["method"]["min_members"]) == ("rec/", 7, 4)


def test_the_report_has_the_title_the_settings_and_with_a_truth_how_good_the_map_is(tmp_path: Path) -> None:
    texts = []
    for truth in (None, maps.ROOM):
        result(truth).save(tmp_path)
        texts.append((tmp_path / "report.html").read_text(encoding="utf-8"))
    for text in texts:
        assert "A room" in text
        assert "min_members" in text
    assert ["Recall and precision" in text for text in texts] == [False, True]


def test_an_unwritable_folder_is_refused(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine", encoding="utf-8")
    with pytest.raises(OutputError, match="choose another place"):
        result().save(tmp_path / "out")
    assert (tmp_path / "out").read_text(encoding="utf-8") == "mine"


def test_pictures_that_a_run_does_not_make_go_and_others_stay(tmp_path: Path) -> None:
    for made in (("map", "figure-05-fit"), ("map",)):
        with results_folder(tmp_path, result()) as draft:
            (draft / PICTURES).mkdir()
            for name in made:
                (draft / PICTURES / f"{name}.png").touch()
        (tmp_path / PICTURES / "mine.png").touch()
    assert sorted(path.name for path in (tmp_path / PICTURES).iterdir()) == ["map.png", "mine.png"]


def test_a_map_is_evaluated_against_the_truth_of_its_recording() -> None:
    assert len(result(maps.ROOM).evaluate().matches.walls.right) == len(maps.ROOM.walls_xy)
    with pytest.raises(ValueError, match="no ground truth"):
        result().evaluate()


def test_a_pose_has_the_time_at_which_the_robot_was_there(tmp_path: Path) -> None:
    result().save(tmp_path)
    assert result().stamps_ns.tolist() == read_trajectory(tmp_path / "trajectory.tum")[0].tolist()
    assert result().stamps_ns[0] == 10_000_000_000 * result().feature_map.sweeps[0] + 1_000_000_000


def test_the_other_files_are_saved_if_one_format_cannot_be_written(tmp_path: Path) -> None:
    late = replace(result(), sweeps=tuple(replace(each, stamps_ns=each.stamps_ns - 2**60) for each in result().sweeps))
    with pytest.raises(InvalidValueError, match="times_ns"):
        late.save(tmp_path, export="mcap,geojson")
    assert {"map.json", "report.html", "map.geojson"} <= {path.name for path in tmp_path.iterdir()}
    assert not (tmp_path / "map.mcap").exists()


@pytest.mark.parametrize("source", [None, [], 5])
def test_what_is_no_source_is_refused(source: Any) -> None:
    with pytest.raises(InvalidValueError, match=r"put sweeps into Recording"):
        map_source(source)


def test_a_map_is_exported_by_suffix(tmp_path: Path) -> None:
    result().export(tmp_path / "plan.svg")
    assert (tmp_path / "plan.svg").read_text(encoding="utf-8").startswith("<")
    with pytest.raises(
        InputError, match=r"no format for other software has the suffix '.xyz'; end it with one of .dxf"
    ):
        result().export(tmp_path / "plan.xyz")
    with pytest.raises(InputError, match="the name has no suffix"):
        result().export(tmp_path / "plan")


def test_a_wrong_setting_is_refused_with_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"settings, posess: the key 'posess' is unknown; did you mean 'poses'?"):
        map_source("sim:square", settings={"posess": "trust"})
    with pytest.raises(InputError, match="KmeansSettings has those of another method; pass JointSettings"):
        map_source("sim:square", settings=KmeansSettings())


def test_a_notebook_draws_a_map() -> None:
    assert result()._repr_svg_().startswith("<")


def test_all_formats_are_saved_and_go_with_the_next_run(tmp_path: Path) -> None:
    saved = result().save(tmp_path, export=["all"])
    assert set(saved) == {path.name for path in tmp_path.iterdir()} >= {"map.yaml", "map.pgm", "map.dxf", "map.geojson"}
    assert set(result().save(tmp_path)) == {path.name for path in tmp_path.iterdir()}


def test_an_unknown_format_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError, match="did you mean 'geojson'"):
        result().save(tmp_path / "out", export=["geojsn"])
    assert not (tmp_path / "out").exists()
