"""Classical methods on recordings that others made: what they find there, and that none of them breaks."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from echoplan.evaluation import evaluate
from echoplan.io import read_recording, read_truth
from echoplan.methods import find_method, map_sweeps
from echoplan.model import FeatureMap, Recording

DATA = Path(__file__).parents[2] / ".." / "shared" / "data"
METHODS = [
    *("atm", "tbf", "arc-carving", "directional-maximum", "hough", "arc-hough-tbf", "iepf-kalman", "gmm"),
]


@cache
def recorded(name: str) -> Recording:
    """A recording with its sweeps in memory."""
    if not (DATA / name).is_dir():
        pytest.skip(f"the recording {name} is not here")
    source = read_recording(DATA / name)
    return Recording(name=name, rig=source.rig, sweeps=tuple(source))


@cache
def mapped(name: str, method: str) -> FeatureMap:
    recording = recorded(name)
    return map_sweeps(find_method(method).build(recording.rig), recording)


def share_of_walls(name: str, method: str) -> float:
    found = mapped(name, method)
    return evaluate(found, read_truth(DATA / name / "truth.json")).matches.walls.tally.recall


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["arena-a", "arena-b", "corridor", "rooms/ring00"])
def test_fixed_rings_and_coarse_turrets_break_nothing(name: str, method: str) -> None:
    found = mapped(name, method)
    assert len(found.poses) == len(recorded(name))
    for wall in found.walls:
        assert np.linalg.eigvalsh(wall.covariance).min() > 0


@pytest.mark.parametrize(
    ("method", "least"),
    [("atm", 0.8), ("tbf", 0.6), ("directional-maximum", 0.9), ("hough", 0.9), ("gmm", 0.9)],
)
def test_most_walls_of_a_room_are_found_by_a_ring(method: str, least: float) -> None:
    assert share_of_walls("rooms/ring00", method) >= least


@pytest.mark.parametrize(
    ("method", "least"),
    [("hough", 0.9), ("arc-hough-tbf", 0.9), ("iepf-kalman", 0.6), ("arc-carving", 0.15), ("directional-maximum", 0.9)],
)
def test_walls_of_the_papers_room_are_found_by_the_rotary_array(method: str, least: float) -> None:
    assert share_of_walls("rooms/paper", method) >= least
