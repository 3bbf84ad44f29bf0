"""Consistency tests that distinguish exact from drifting poses."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.io import builtin_rig, builtin_world
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.pose_correction.consistency import (
    agrees,
    are_weakly_connected,
    contradicts_odometry,
    has_duplicated_walls,
    inlier_ratio,
    is_inconsistent,
    log_evidence,
    stations_disagree,
)
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.pose_status import PoseModel, PoseReason
from echoplan.joint.search.duplicates import without_duplicates
from echoplan.joint.settings import EstimateSettings, PoseMode
from echoplan.model import Odometry, Route
from echoplan.preprocessing.measurements import Measurements, join_measurements, measurements_of
from echoplan.simulation import OdometryNoise, Simulation, SimulationSettings
from helpers.constants import settings_with
from helpers.tracking import track_poses

pytestmark = pytest.mark.slow

RIG = builtin_rig("rotary-array")
WAY = np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.4], [1.0, 0.4, 1.2], [1.1, 1.0, 1.8], [0.7, 1.5, 2.8], [0.1, 1.4, -2.2]])
LOST = OdometryNoise(along=0.03, yaw_per_metre=np.radians(3.0))


@cache
def drive(*, odometry: OdometryNoise | None) -> tuple[Measurements, FloatArray]:
    """Return the pings of a round through the square, and the recorded poses."""
    settings = SimulationSettings() if odometry is None else SimulationSettings(odometry=odometry)
    simulation = Simulation(
        world=builtin_world("square"),
        rig=RIG,
        route=Route(map_from_base=WAY),
        settings=settings,
        seed=3,
    )
    sweeps = tuple(simulation)
    return join_measurements([measurements_of(sweep, RIG) for sweep in sweeps]), np.array(
        [each.station for each in sweeps]
    )


def estimate_of(odometry: OdometryNoise | None, **settings: object) -> Estimate:
    detected, measured_poses = drive(odometry=odometry)
    return initial_estimate(RIG, detected, measured_poses, settings_with(EstimateSettings, **settings))


@cache
def trusted(*, odometry: OdometryNoise | None) -> Estimate:
    """Return the estimate with fixed poses."""
    return estimate_map(estimate_of(odometry, poses=PoseMode.TRUST))


@cache
def corrected() -> Estimate:
    """Return the estimate of the drifting drive with corrected poses."""
    estimate = estimate_of(LOST)
    return track_poses(estimate, estimate.odometry())


def test_exact_poses_are_consistent() -> None:
    estimate = trusted(odometry=None)
    assert inlier_ratio(estimate) > 0.97
    assert agrees(estimate)
    assert not has_duplicated_walls(estimate)
    assert not is_inconsistent(estimate)


def test_stations_that_share_no_walls_are_inconsistent() -> None:
    estimate = trusted(odometry=None)
    assert not are_weakly_connected(estimate)
    alone = np.where(np.arange(len(WAY)) == 2, 1.0, 0.0)
    estimate = replace(
        estimate, features=[replace(each, llr_by_station=alone * each.llr_by_station) for each in estimate.features]
    )
    assert are_weakly_connected(estimate)
    assert agrees(estimate)
    assert is_inconsistent(estimate)


def test_drifting_poses_are_inconsistent() -> None:
    estimate = trusted(odometry=LOST)
    assert is_inconsistent(estimate)
    assert inlier_ratio(estimate) < inlier_ratio(trusted(odometry=None))


def test_the_inlier_ratio_is_zero_without_landmarks_and_one_without_echoes() -> None:
    estimate = estimate_of(None)
    assert inlier_ratio(estimate) == 0.0
    silent = estimate.recorded._replace(readings=np.full(len(estimate.recorded.readings), np.inf))
    assert inlier_ratio(initial_estimate(RIG, silent, estimate.measured_poses, EstimateSettings())) == 1.0


def test_unusual_noise_is_inconsistent() -> None:
    estimate = estimate_of(None)
    estimate = replace(estimate, features=trusted(odometry=None).features)
    estimate = replace(estimate, noise=0.02)
    assert inlier_ratio(estimate) > 0.97
    assert not agrees(estimate)


def test_drifting_poses_are_detected_and_unexplained_echoes_are_not_drift() -> None:
    assert stations_disagree(trusted(odometry=LOST))
    estimate = trusted(odometry=None)
    estimate = replace(estimate, settings=EstimateSettings(min_inlier_ratio=1.0))
    assert not agrees(estimate)
    assert not stations_disagree(estimate)
    estimate = replace(estimate, solution=None)
    assert stations_disagree(estimate)


@pytest.mark.parametrize(
    ("common", "own", "odds"), [(0.0025, 0.0005, False), (0.0025, 0.004, True), (0.0013, 0.004, False)]
)
def test_common_rounding_errors_are_no_pose_errors(common: float, own: float, *, odds: bool) -> None:
    # With a resolution of 1 cm, readings of a wall from one station may share an error of 2.5 mm, but not if they
    # scatter by 4 mm. A little more than a millimetre may be an error of the sonar model.
    estimate = trusted(odometry=None)
    assert estimate.solution is not None
    rng, owners = np.random.default_rng(4), estimate.solution.owners
    together = rng.standard_normal((len(estimate.features), len(WAY)))[owners, estimate.measurements.stations]
    errors = common * together + own * rng.standard_normal(len(owners))
    estimate = replace(estimate, solution=replace(estimate.solution, residuals=np.where(owners >= 0, errors, 0.0)))
    estimate = replace(estimate, resolution=0.01, noise=float(np.hypot(common, own)))
    assert stations_disagree(estimate) is odds


def test_many_duplicated_walls_are_detected() -> None:
    estimate = estimate_of(None)
    walls = [each for each in trusted(odometry=None).features if each.is_wall]
    moved = [replace(each, reflector=each.reflector + np.array([0.0, 0.05, 0.03, 0.0])) for each in walls]
    estimate = replace(estimate, features=[*walls, moved[0]])
    assert not has_duplicated_walls(estimate)
    estimate = replace(estimate, features=[*walls, *moved])
    assert has_duplicated_walls(estimate)


def with_consistent_echoes(estimate: Estimate) -> Estimate:
    """Return an estimate whose pings agree and leave no residuals."""
    assert estimate.solution is not None
    solution = replace(estimate.solution, residuals=np.zeros(len(estimate.solution.residuals)))
    return replace(estimate, settings=EstimateSettings(min_inlier_ratio=0.5), solution=solution)


def test_a_wall_duplicated_by_drift_is_inconsistent() -> None:
    drifting = trusted(odometry=LOST)
    assert is_inconsistent(drifting)
    # The low inlier ratio of the drive would be enough to make it inconsistent.
    drifting = with_consistent_echoes(drifting)
    assert agrees(drifting)
    assert stations_disagree(drifting)
    drifting = replace(drifting, features=without_duplicates(drifting.features, drifting.settings.duplicates))
    assert not stations_disagree(drifting)


def test_corrected_poses_have_more_log_evidence_than_drifting_ones() -> None:
    assert log_evidence(corrected()) > log_evidence(trusted(odometry=LOST)) + 100.0


def test_the_log_evidence_includes_the_bayesian_information_criterion_of_poses() -> None:
    estimate = corrected()
    free = log_evidence(replace(estimate, pose_prior=None))
    # The first pose is the frame; each of the others has a hundred readings or more.
    cost = free - log_evidence(estimate)
    assert cost == pytest.approx(5 * 1.5 * np.log(250), rel=0.2)


def test_a_duplicated_wall_reduces_the_log_evidence() -> None:
    estimate = estimate_of(None)
    estimate = replace(estimate, features=trusted(odometry=None).features)
    once = log_evidence(estimate), inlier_ratio(estimate)
    wall = next(each for each in estimate.features if each.is_wall)
    copied = replace(
        wall, reflector=wall.reflector + np.array([0.0, 0.0, 0.03, 0.0]), llr_by_station=0.5 * wall.llr_by_station
    )
    estimate = replace(estimate, features=[*estimate.features, copied])
    assert inlier_ratio(estimate) == once[1]
    assert log_evidence(estimate) < once[0] - 12.0


def test_a_wall_that_pings_pass_reduces_the_log_evidence() -> None:
    estimate = estimate_of(None)
    estimate = replace(estimate, features=trusted(odometry=None).features)
    without = log_evidence(estimate)
    wall = next(each for each in estimate.features if each.is_wall)
    # Too far off to be a duplicate, and nearer, so that pings that detect the real wall pass the false one.
    nearer = wall.reflector - np.array([0.0, 0.0, 0.4, 0.0])
    there = replace(estimate.likelihood.score(nearer), extent=wall.extent)
    estimate = replace(estimate, features=[*estimate.features, there])
    cost = estimate.settings.search.min_log_likelihood_ratio
    assert len(without_duplicates(estimate.features, estimate.settings.duplicates)) == len(estimate.features)
    assert log_evidence(estimate) < without - cost - 12.0
    estimate = replace(estimate, features=[*estimate.features[:-1], replace(there, extent=(0.0, 0.0))])
    assert log_evidence(estimate) == pytest.approx(without - cost, abs=6.0)


def test_the_log_evidence_includes_the_pose_prior() -> None:
    estimate = corrected()
    likely = log_evidence(estimate)
    estimate = replace(estimate, poses=estimate.poses + np.outer(np.arange(len(estimate.poses)) >= 3, [0.5, 0.0, 0.0]))
    assert log_evidence(estimate) < likely - 50.0


def test_errors_of_ten_times_the_specified_odometry_noise_contradict_it() -> None:
    estimate = corrected()
    assert not contradicts_odometry(estimate)
    detected, measured_poses = drive(odometry=LOST)
    specified = Odometry(along=0.003, lateral=0.0, yaw_per_metre=np.radians(0.3), yaw_per_radian=0.0)
    sure = initial_estimate(replace(RIG, odometry=specified), detected, measured_poses, EstimateSettings())
    sure = replace(sure, poses=estimate.poses, pose_prior=sure.odometry())
    assert contradicts_odometry(sure)
    assert not contradicts_odometry(trusted(odometry=None))


def test_a_single_slip_does_not_contradict_the_odometry_noise() -> None:
    estimate = corrected()
    estimate = replace(estimate, poses=estimate.poses + np.outer(np.arange(len(estimate.poses)) >= 3, [0.5, 0.0, 0.0]))
    assert log_evidence(estimate) < log_evidence(corrected()) - 50.0
    assert not contradicts_odometry(estimate)


def test_drift_is_corrected_automatically_and_exact_poses_are_kept() -> None:
    lost = estimate_map(estimate_of(LOST))
    assert lost.pose_model is PoseModel.ODOMETRY
    assert lost.pose_status.reason in (PoseReason.DUPLICATED_WALLS, PoseReason.INCONSISTENT)
    right = estimate_map(estimate_of(None))
    assert right.pose_model is PoseModel.FIXED
    assert right.pose_status.reason is PoseReason.CONSISTENT
    assert right.poses == pytest.approx(WAY)


def test_a_requested_correction_keeps_exact_poses() -> None:
    asked = estimate_map(estimate_of(None, poses=PoseMode.CORRECT))
    assert asked.pose_model is PoseModel.FIXED
    assert asked.poses == pytest.approx(WAY)
    assert asked.pose_status.reason is PoseReason.NO_CORRECTION_NEEDED
    right = trusted(odometry=None)
    assert [each.key for each in asked.features] == [each.key for each in right.features]


def test_a_requested_correction_corrects_drift() -> None:
    asked = estimate_map(estimate_of(LOST, poses=PoseMode.CORRECT))
    assert asked.pose_model is PoseModel.ODOMETRY
    assert asked.pose_status.is_requested
    assert asked.pose_status.reason is PoseReason.ODOMETRY
    assert np.hypot(*(asked.poses - WAY)[:, :2].T).max() < 0.02
