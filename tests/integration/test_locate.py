"""Where a recording was made in a map: the command, and the function of the library."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import echoplan as ep
from echoplan.geometry import compose, invert
from echoplan.io import read_recording, read_trajectory, read_truth, write_map, write_recording
from echoplan.model import Recording
from helpers import maps
from helpers.typed import echoplan, succeed


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A map of a square room, and a later recording of it with poses in a frame of their own."""
    folder = tmp_path_factory.mktemp("locate")
    succeed("simulate", "square", "--out", folder / "rec", "--seed", "4")
    succeed("map", folder / "rec", "--out", folder / "map")
    succeed("simulate", "square", "--out", folder / "raw", "--seed", "5")
    raw = read_recording(folder / "raw")
    away = invert(next(iter(raw)).station)
    sweeps = tuple(replace(sweep, map_from_base=compose(away, sweep.map_from_base)) for sweep in raw)
    write_recording(folder / "later", Recording(name="later", rig=raw.rig, sweeps=sweeps))
    return folder


def start(folder: Path) -> str:
    """The true first pose of the later recording, a little off."""
    x, y, yaw = read_truth(folder / "raw" / "truth.json").poses[0]
    return f"{x + 0.05:.2f},{y - 0.05:.2f},{yaw + 0.05:.2f}"


def test_a_recording_is_located_from_a_start(folder: Path, tmp_path: Path) -> None:
    words = ("locate", folder / "later", "--map", folder / "map", "--out", tmp_path / "out", "--export", "mcap")
    printed = succeed(*words, f"--start={start(folder)}")
    assert "Located: " in printed
    assert "Written to" in printed
    names = ["localisation.json", "located.mcap", "located.svg", "run.toml", "trajectory.tum"]
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == names
    _, poses = read_trajectory(tmp_path / "out" / "trajectory.tum")
    true = read_truth(folder / "raw" / "truth.json").poses
    assert np.hypot(*(poses - true)[:, :2].T).max() < 0.005
    document = json.loads((tmp_path / "out" / "localisation.json").read_text(encoding="utf-8"))
    assert document["format"] == "echoplan-localisation/1"
    assert document["quality"]["verdict"] == "good"
    assert [each["sweep"] for each in document["poses"]] == list(range(len(true)))
    assert np.array([each["covariance"] for each in document["poses"]]).shape == (len(true), 3, 3)


def test_a_square_room_is_ambiguous_without_a_start(folder: Path, tmp_path: Path) -> None:
    printed = succeed("locate", folder / "later", "--map", folder / "map", "--out", tmp_path / "out")
    assert printed.startswith("Located, but doubtful: ")
    document = json.loads((tmp_path / "out" / "localisation.json").read_text(encoding="utf-8"))
    (segment,) = document["segments"]
    assert segment["is_ambiguous"]
    weights = [each["weight"] for each in segment["starts"]]
    assert weights == sorted(weights, reverse=True)
    assert sum(weights) == pytest.approx(1.0)


def test_a_recording_of_another_place_is_not_located(folder: Path, tmp_path: Path) -> None:
    write_map(tmp_path / "map.json", maps.drawn(maps.wall([0, 0], [9, 0]), maps.wall([9, 0], [9, 1])))
    words = ("locate", folder / "later", "--map", tmp_path / "map.json", "--out", tmp_path / "out")
    done = echoplan(*words)
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert re.search(
        r"echoes and map agree to only \d+ % \(70 % are needed\); check that the map is of this place", done.err
    )
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--start", "1,2"), "--start: '1,2' is not X,Y,YAW; write for example"),
        (("--start", "1,2,nan"), "--start: '1,2,nan' is not X,Y,YAW; write for example"),
        (("--export", "pdf"), "unknown export format of a path 'pdf'"),
        (("--map", "nowhere"), "nowhere"),
    ],
)
def test_bad_options_are_refused_in_one_line(folder: Path, tmp_path: Path, words: tuple[str, ...], said: str) -> None:
    done = echoplan("locate", folder / "later", "--map", folder / "map", "--out", tmp_path / "out", *words)
    assert done.status == 2
    assert said in done.err
    assert done.err.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_the_folder_of_the_map_is_not_overwritten(folder: Path) -> None:
    before = (folder / "map" / "run.toml").read_bytes()
    done = echoplan("locate", folder / "later", "--map", folder / "map", "--out", folder / "map")
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert "holds the map or the recording" in done.err
    assert (folder / "map" / "run.toml").read_bytes() == before


def test_a_map_without_walls_is_refused(folder: Path, tmp_path: Path) -> None:
    write_map(tmp_path / "map.json", maps.drawn())
    done = echoplan("locate", folder / "later", "--map", tmp_path / "map.json", "--out", tmp_path / "out")
    assert done.status == 2
    assert "the map has no walls" in done.err


def test_the_library_locates_a_recording(folder: Path, tmp_path: Path) -> None:
    pose = [float(word) for word in start(folder).split(",")]
    found = ep.locate(folder / "later", folder / "map", start=pose)
    assert found.quality.verdict is ep.Verdict.GOOD
    assert found.feature_map.walls
    assert np.array_equal(found.feature_map.poses, found.poses)
    assert found.save(tmp_path / "out") == ("localisation.json", "located.svg", "trajectory.tum", "run.toml")
    with pytest.raises(ep.InvalidValueError, match="start"):
        ep.locate(folder / "later", folder / "map", start=[1.0, 2.0])
