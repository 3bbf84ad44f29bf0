"""Several recordings of one place, each with poses in a frame of its own, make one map."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import echoplan as ep
from echoplan.geometry import compose, invert
from echoplan.io import read_map, write_recording
from echoplan.model import Recording, Rig, Sweep
from helpers.typed import echoplan, succeed

# Frame of the second recording in that of the first one: 0.3 m and 20 degrees away.
AWAY = np.array([0.3, -0.1, np.radians(20.0)])


def written(folder: Path, sweeps: Sequence[Sweep], *, rig: Rig, away: np.ndarray) -> Path:
    """Write sweeps as a recording of their own, with poses in another frame."""
    moved = tuple(
        replace(sweep, index=number, map_from_base=compose(invert(away), sweep.map_from_base))
        for number, sweep in enumerate(sweeps)
    )
    write_recording(folder, Recording(name=folder.name, rig=rig, sweeps=moved))
    return folder


@pytest.fixture(scope="module")
def flat() -> ep.Simulation:
    """A flat of two rooms."""
    return ep.simulate("two-room-flat", seed=2)


@pytest.fixture(scope="module")
def recordings(flat: ep.Simulation, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The flat in two recordings: four stations are in both."""
    folder, sweeps = tmp_path_factory.mktemp("recordings"), list(flat)
    return [
        written(folder / "one", sweeps[:13], rig=flat.rig, away=np.zeros(3)),
        written(folder / "two", sweeps[9:], rig=flat.rig, away=AWAY),
    ]


@pytest.fixture(scope="module")
def mapped(recordings: list[Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The map of both."""
    out = tmp_path_factory.mktemp("mapped") / "map"
    succeed("map", *recordings, "--out", out)
    return out


def test_they_make_the_map_of_one_recording(flat: ep.Simulation, mapped: Path) -> None:
    found = ep.evaluate(mapped, flat.truth).matches.walls
    assert found.tally.found == found.tally.wanted
    assert not found.spurious
    assert max(each.distance for each in found.right) < 0.003


def test_the_poses_of_both_are_in_the_frame_of_the_first(flat: ep.Simulation, mapped: Path) -> None:
    found, true = read_map(mapped), flat.truth.poses
    assert found.sweeps.tolist() == list(range(len(true) + 4))
    assert np.hypot(*(found.poses - np.concatenate([true[:13], true[9:]]))[:, :2].T).max() < 0.003


def test_the_way_between_two_recordings_is_no_path(mapped: Path) -> None:
    assert len(read_map(mapped).openings) == 1


def test_a_recording_that_shares_too_little_is_refused(
    flat: ep.Simulation, recordings: list[Path], tmp_path: Path
) -> None:
    other = written(tmp_path / "other", list(flat)[22:], rig=flat.rig, away=AWAY)
    done = echoplan("map", recordings[0], other, "--out", tmp_path / "map")
    assert done.status == 2
    assert "other: it begins where the recordings before it show too little" in done.err
    assert done.err.count("\n") == 1
    assert not (tmp_path / "map").exists()


def test_only_joint_maps_several(recordings: list[Path], tmp_path: Path) -> None:
    done = echoplan("map", *recordings, "--method", "rcd", "--out", tmp_path / "map")
    assert (done.status, done.err) == (
        2,
        "echoplan: --method: it maps one recording only; use joint for several recordings\n",
    )


def test_recordings_of_other_sensors_are_refused(recordings: list[Path], tmp_path: Path) -> None:
    succeed("simulate", "square", "--rig", "ring-16", "--out", tmp_path / "ring")
    done = echoplan("map", recordings[0], tmp_path / "ring", "--out", tmp_path / "map")
    assert done.status == 2
    assert "its sensors are not those of one" in done.err
