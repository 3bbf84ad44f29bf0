"""The filter in worlds of which everything is known."""

from itertools import pairwise
from typing import TypeAlias

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.features import Observation
from echoplan.classical.slam import CIRCLE, LINE, Shape, Slam, SlamSettings
from echoplan.geometry import compose, wrap
from helpers.scenes import observed

# An oblique room, and a pillar in it.
World: TypeAlias = list[tuple[Shape, FloatArray]]
WORLD: World = [
    (LINE, np.array([0.1, 3.0])),
    (LINE, np.array([1.7, 2.5])),
    (LINE, np.array([-1.5, 2.0])),
    (LINE, np.array([3.0, 2.6])),
    (CIRCLE, np.array([0.9, 1.2, 0.08])),
]
WAY = np.array(
    [[0, 0, 0], [0.6, 0.1, 0.3], [1.2, 0.5, 1.0], [1.3, 1.2, 1.9], [0.6, 1.6, 2.7], [0, 1.2, 3.6], [0, 0.5, 4.6]],
    dtype=np.float64,
)


def sightings(
    pose: FloatArray, sweep: int, *, rng: np.random.Generator | None = None, world: World = WORLD
) -> list[Observation]:
    """What is seen of a world from a pose, as noisy as the filter assumes."""
    settings = SlamSettings()
    found = []
    for shape, values in world:
        bearing, distance = shape.expect(pose, values, np.zeros(2)).values
        errors = (
            np.zeros(2)
            if rng is None
            else rng.normal(size=2) * [settings.common_bearing_sigma, settings.common_distance_sigma]
        )
        found.append(
            observed(
                (0.0, 0.0),
                bearing=float(bearing + errors[0]),
                distance=float(distance + errors[1]),
                sweep=sweep,
                degrees=(1.0, 1.0, 1.0),
                bearing_sigma=1e-6,
            )
        )
    return found


def drifted(rng: np.random.Generator) -> FloatArray:
    """The way as dead reckoning has it."""
    motions = SlamSettings().motion
    poses = [WAY[0]]
    for before, after in pairwise(WAY):
        cosine, sine = np.cos(before[2]), np.sin(before[2])
        x, y = after[:2] - before[:2]
        motion = np.array([cosine * x + sine * y, cosine * y - sine * x, after[2] - before[2]])
        poses.append(compose(poses[-1], rng.multivariate_normal(motion, motions.covariance(motion))))
    return np.array(poses)


def run(rng: np.random.Generator) -> tuple[Slam, FloatArray]:
    """Drive along the way with drift and noise."""
    slam, stations = Slam(), drifted(rng)
    for sweep, (true, station) in enumerate(zip(WAY, stations, strict=True)):
        slam.add(sweep, station, sightings(true, sweep, rng=rng))
    return slam, stations


def errors(poses: FloatArray) -> FloatArray:
    return np.concatenate([poses[:, :2] - WAY[:, :2], wrap(poses[:, 2] - WAY[:, 2])[:, None]], axis=1)


@pytest.fixture(scope="module")
def runs() -> list[tuple[Slam, FloatArray]]:
    return [run(np.random.default_rng(seed)) for seed in range(25)]


def test_every_object_becomes_one_landmark_of_its_shape() -> None:
    slam, _ = run(np.random.default_rng(1))
    assert sorted(each.shape.name for each in slam.landmarks) == ["circle", "line", "line", "line", "line"]
    circle = next(each for each in slam.landmarks if each.shape is CIRCLE)
    np.testing.assert_allclose(slam.state[circle.name], WORLD[-1][1], atol=0.05)


def test_corrected_poses_are_better_than_dead_reckoning(runs: list[tuple[Slam, FloatArray]]) -> None:
    odometric, corrected = (
        np.sqrt(np.mean(np.square([errors(each) for each in poses]), axis=(0, 1)))
        for poses in ([stations for _, stations in runs], [slam.poses for slam, _ in runs])
    )
    assert np.hypot(*corrected[:2]) < np.hypot(*odometric[:2]) / 3
    assert corrected[2] < odometric[2] / 2


def test_the_filter_is_as_unsure_as_it_is_wrong(runs: list[tuple[Slam, FloatArray]]) -> None:
    nees = []
    for slam, _ in runs:
        error = errors(slam.poses)[-1]
        covariance = slam.state.marginal([f"pose {len(WAY) - 1}"]).covariance
        nees.append(float(error @ np.linalg.solve(covariance, error)))
    # Three degrees of freedom; the bounds hold the mean of 25 with a probability of 99.9 %, and linearisation.
    assert 1.6 < np.mean(nees) < 5.0


def test_seeing_a_landmark_again_makes_it_surer() -> None:
    slam, sizes = Slam(), []
    for sweep, pose in enumerate(WAY):
        slam.add(sweep, pose, sightings(pose, sweep, world=WORLD[:2]))
        if slam.landmarks:
            sizes.append(np.trace(slam.state.marginal([slam.landmarks[0].name]).covariance))
    assert len(sizes) == len(WAY) - 1
    assert all(later < earlier for earlier, later in pairwise(sizes))


def test_coming_back_makes_the_poses_before_surer_too() -> None:
    slam = Slam()
    for sweep, pose in enumerate(WAY[:3]):
        slam.add(sweep, pose, [])
    before = slam.state.marginal(["pose 1"]).covariance
    for sweep, pose in enumerate(WAY[3:], start=3):
        slam.add(sweep, pose, sightings(pose, sweep))
    slam.add(7, WAY[0], sightings(WAY[0], 7))
    assert np.trace(slam.state.marginal(["pose 1"]).covariance) < np.trace(before)


def test_without_observations_the_poses_are_those_of_dead_reckoning() -> None:
    slam = Slam()
    for sweep, pose in enumerate(WAY):
        slam.add(sweep, pose, [])
    np.testing.assert_allclose(errors(slam.poses), 0.0, atol=1e-12)


def test_one_sweep_alone_makes_no_landmark() -> None:
    slam = Slam()
    slam.add(0, WAY[0], sightings(WAY[0], 0))
    assert slam.landmarks == []


def test_two_sweeps_from_one_place_do_not_determine_a_class() -> None:
    slam = Slam()
    for sweep in range(2):
        slam.add(sweep, WAY[0], sightings(WAY[0], sweep))
    assert slam.landmarks == []


def test_a_stray_sighting_moves_nothing() -> None:
    slam = Slam()
    for sweep, pose in enumerate(WAY[:4]):
        slam.add(sweep, pose, sightings(pose, sweep))
    before = slam.state.mean
    stray = observed((0.0, 0.0), bearing=0.9, distance=0.4, sweep=3, degrees=(1.0, 1.0, 1.0))
    slam._observe(stray)
    assert slam.state.mean is before


@pytest.mark.parametrize("window", [2, 4])
def test_poses_that_leave_the_window_stay_as_they_were_then(window: int) -> None:
    slam = Slam(SlamSettings(window=window))
    for sweep, pose in enumerate(WAY):
        slam.add(sweep, pose, sightings(pose, sweep))
    assert sum(block.startswith("pose") for block in slam.state.sizes) == window
    assert slam.poses.shape == WAY.shape
    np.testing.assert_allclose(errors(slam.poses), 0.0, atol=1e-3)
