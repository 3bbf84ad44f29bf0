"""Directions in which only odometry determines poses, such as along a corridor between two walls."""

import numpy as np
import pytest

from echoplan.acoustics import typical_transducer
from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert
from echoplan.joint.observability import (
    ObservabilitySettings,
    Undetermined,
    carried_covariances,
    covariances_between_walls,
    dead_reckoned_covariances,
    pose_covariances,
    undetermined,
)
from echoplan.joint.optimisation.factors import normal_equations
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS, Layout
from echoplan.joint.optimisation.pose_factors import PosePrior, PoseSettings, odometry_prior, pose_factors
from echoplan.joint.optimisation.solution import Solution
from echoplan.preprocessing.stations import Stations
from helpers import scenes

WAY = np.column_stack([np.linspace(0.0, 5.0, 11), np.zeros(11), np.full(11, 0.2)])
PRIORS = odometry_prior(WAY, PoseSettings())
ALONE = dead_reckoned_covariances(PRIORS._replace(sigmas=PRIORS.sigmas * [1.0, 1.0, 0.0]), WAY)
SETTINGS = ObservabilitySettings()
SWEEPS = Stations(np.array([0, 0, 1]), np.zeros((2, 3)))


def corridor(turn: float) -> FloatArray:
    """Return the information on each pose from walls on both sides of a corridor, with a sigma of 3 mm."""
    across = np.array([-np.sin(turn), np.cos(turn), 0.0])
    return np.tile(np.outer(across, across) / 0.003**2 + np.diag([0.0, 0.0, 1 / 0.005**2]), (11, 1, 1))


def covariances_of(detected: FloatArray, priors: PosePrior = PRIORS) -> FloatArray:
    information, _ = normal_equations([pose_factors(priors, WAY, 0)], 33)
    for station, block in enumerate(detected):
        information[3 * station : 3 * station + 3, 3 * station : 3 * station + 3] += block
    covariance = np.linalg.inv(information)
    return np.array([covariance[k : k + 3, k : k + 3] for k in range(0, 33, 3)])


def undetermined_runs(covariances: FloatArray, alone: FloatArray) -> tuple[Undetermined, ...]:
    """Return the undetermined runs, given the walls."""
    return undetermined(covariances, covariances, alone, SETTINGS)


def test_dead_reckoned_covariances_are_those_of_the_odometry_factors() -> None:
    way = np.array([[0.0, 0, 0], [1.0, 0, 0.5], [1.5, 0.8, 1.6], [1.4, 1.9, 3.0]])
    priors = odometry_prior(way, PoseSettings())
    information, _ = normal_equations([pose_factors(priors, way, 0)], 12)
    covariance = np.linalg.inv(information)
    blocks = np.array([covariance[k : k + 3, k : k + 3] for k in range(0, 12, 3)])
    assert dead_reckoned_covariances(priors, way) == pytest.approx(blocks, rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("turn", [0.0, 0.7, -1.2])
def test_a_corridor_leaves_the_direction_along_it_undetermined(turn: float) -> None:
    (found,) = undetermined_runs(covariances_of(corridor(turn)), ALONE)
    assert found.direction == pytest.approx(turn, abs=0.05)
    assert found.along > 3 * found.across
    assert found.across < 0.004
    assert found.last == 10


def test_a_corner_ends_the_undetermined_run() -> None:
    detected = corridor(0.0)
    detected[6:] += np.diag([1 / 0.003**2, 0.0, 0.0])
    found = undetermined_runs(covariances_of(detected), ALONE)
    # From the corner, odometry determines the last stations before it.
    assert not found or found[0].last < 6


def test_a_room_determines_all_poses() -> None:
    detected = corridor(0.0) + np.diag([1 / 0.003**2, 0.0, 0.0])
    assert undetermined_runs(covariances_of(detected), ALONE) == ()


def test_accurate_odometry_is_not_reported_as_undetermined() -> None:
    sure = PRIORS._replace(sigmas=1e-3 * PRIORS.sigmas)
    assert undetermined_runs(covariances_of(corridor(0.0), sure), dead_reckoned_covariances(sure, WAY)) == ()


def test_covariances_of_sweeps_include_the_rotation_of_their_station() -> None:
    station = np.diag([1e-6, 4e-6, 1e-4])
    poses = np.array([[1.0, 2.0, 0.3], [1.1, 2.0, 0.3], [5.0, 5.0, 0.0]])
    carried = carried_covariances(np.array([station, station]), SWEEPS, poses)
    assert carried[0] == pytest.approx(station)
    assert carried[2] == pytest.approx(station)
    assert carried[1, 1, 1] == pytest.approx(4e-6 + 0.1**2 * 1e-4)
    assert carried[1, 0, 0] == pytest.approx(1e-6)


def test_covariances_of_sweeps_agree_with_simulated_errors() -> None:
    rng, station = np.random.default_rng(2), np.diag([1e-4, 4e-4, 9e-4])
    poses = np.array([[1.0, 2.0, 0.3], [1.3, 2.4, 0.5], [0.0, 0.0, 0.0]])
    step = compose(invert(poses[0]), poses[1])
    drawn = compose(poses[0] + rng.multivariate_normal(np.zeros(3), station, 20_000), step)
    covariance = carried_covariances(np.array([station, station]), SWEEPS, poses)[1]
    assert np.cov(drawn.T) == pytest.approx(covariance, rel=0.05, abs=1e-5)


def test_fixed_poses_have_no_covariances() -> None:
    assert carried_covariances(np.zeros((0, 3, 3)), SWEEPS, np.zeros((3, 3))).shape == (0, 3, 3)


def test_an_undetermined_run_is_reported_by_sweep_numbers() -> None:
    stations = Stations(np.array([0, 0, 1, 2, 2, 3]), np.zeros((4, 3)))
    (found,) = undetermined_runs(covariances_of(corridor(0.0)), ALONE)
    direction = found.at_sweeps(stations, np.array([3, 4, 5, 7, 8, 9]))
    assert (direction["first"], direction["last"]) == (5, 9)
    assert direction["along"] == found.along


def solution(kinds: list[Kind], information: FloatArray) -> Solution:
    layout = Layout(kinds=np.array(kinds, dtype=np.int64), poses=2)
    nothing = np.zeros(0)
    return Solution(
        reflectors=np.zeros((len(kinds), 4)),
        model=EchoModel.of(typical_transducer(scenes.rig().sensors[0])),
        latency=0.0,
        poses=np.zeros((2, 3)),
        layout=layout,
        information=information,
        measurement_information=information,
        information_inflation=1.0,
        extents=np.zeros((len(kinds), 2)),
        owners=nothing.astype(np.int64),
        residuals=nothing,
        newton_decrement=0.0,
        excesses=nothing,
    )


def test_covariances_between_walls_are_conditional_on_the_walls() -> None:
    kinds = [Kind.WALL, Kind.CYLINDER, Kind.WALL]
    size = 2 + 3 + 2 + len(SONAR_UNKNOWNS) + 6
    root = np.random.default_rng(1).normal(size=(size, 2 * size))
    information = root @ root.T
    rest = [2, 3, 4, *range(7, size)]
    covariance = np.linalg.inv(information[np.ix_(rest, rest)])
    expected = [covariance[-6:-3, -6:-3], covariance[-3:, -3:]]
    assert covariances_between_walls(solution(kinds, information)) == pytest.approx(np.array(expected))


def test_without_walls_the_covariances_are_unconditional() -> None:
    alone = solution([Kind.CYLINDER], np.diag(np.arange(1.0, 3.0 + len(SONAR_UNKNOWNS) + 7.0)))
    np.testing.assert_array_equal(covariances_between_walls(alone), pose_covariances(alone))


def test_an_uncertain_rotation_of_the_frame_does_not_hide_undetermined_poses() -> None:
    # A common rotation about the first pose moves poses sideways in proportion to their distance.
    askew = np.array([np.diag([0.0, (0.01 * pose[0]) ** 2, 0.0]) for pose in WAY])
    between = covariances_of(corridor(0.0))
    (found,) = undetermined(between + askew, between, ALONE, SETTINGS)
    assert found.direction == pytest.approx(0.0, abs=0.05)
    assert found.along > 3 * found.across
