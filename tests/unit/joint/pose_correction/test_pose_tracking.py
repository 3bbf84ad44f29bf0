"""Pose tracking of a robot with drifting odometry in a simulated room."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert, wrap
from echoplan.io import builtin_rig, builtin_world
from echoplan.joint.calibration import calibration
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.marginalisation import marginalise, survey
from echoplan.joint.optimisation.pose_factors import odometry_prior
from echoplan.joint.pose_correction.consistency import has_duplicated_walls
from echoplan.joint.pose_correction.pose_tracking import (
    register_in_order,
    up_to_station,
    without_greatest_error,
)
from echoplan.joint.settings import EstimateSettings
from echoplan.model import Route, Sweep
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.simulation import OdometryNoise, Simulation, SimulationSettings
from helpers.tracking import track_poses

WAY = np.array(
    [
        [0.0, 0.0, 0.0],
        [0.6, 0.0, 0.4],
        [1.0, 0.4, 1.2],
        [1.1, 1.0, 1.8],
        [0.7, 1.5, 2.8],
        [0.1, 1.4, -2.2],
        [0.1, 0.7, -1.2],
    ]
)
DRIFT = OdometryNoise(along=0.04, yaw_per_metre=np.radians(4.0))


@cache
def drive() -> tuple[Sweep, ...]:
    """Return seven sweeps in the square with drifting odometry."""
    return tuple(
        Simulation(
            world=builtin_world("square"),
            rig=builtin_rig("rotary-array"),
            route=Route(map_from_base=WAY),
            settings=SimulationSettings(odometry=DRIFT),
            seed=3,
        )
    )


def estimate_of(sweeps: tuple[Sweep, ...]) -> Estimate:
    rig = builtin_rig("rotary-array")
    measured_poses = np.array([sweep.station for sweep in sweeps])
    detected = join_measurements([measurements_of(sweep, rig) for sweep in sweeps])
    return initial_estimate(rig, detected, measured_poses, EstimateSettings())


@cache
def tracked() -> Estimate:
    estimate = estimate_of(drive())
    return track_poses(estimate, odometry_prior(estimate.measured_poses, estimate.settings.pose_errors))


def errors(poses: FloatArray) -> tuple[float, float]:
    """Return the greatest errors of position [m] and of heading [rad]."""
    away, turned = np.hypot(*(poses - WAY)[:, :2].T), np.abs(wrap(poses[:, 2] - WAY[:, 2]))
    return float(away.max()), float(turned.max())


def test_dead_reckoning_drifts() -> None:
    away, turned = errors(estimate_of(drive()).measured_poses)
    assert away > 0.03
    assert np.degrees(turned) > 2.0


def test_tracking_corrects_the_poses() -> None:
    away, turned = errors(tracked().poses)
    assert away < 0.012
    assert np.degrees(turned) < 1.0


def test_a_station_is_found_nearly_four_standard_deviations_from_its_prediction() -> None:
    estimate, sigmas = estimate_of(drive()), np.array([0.05, 0.05, np.radians(2.0)])
    priors = odometry_prior(estimate.measured_poses, estimate.settings.pose_errors)

    def expected(_poses: FloatArray, station: int, _recognised: Sequence[int]) -> tuple[FloatArray, FloatArray]:
        off = 3.8 * sigmas[0] if station == 5 else 0.0
        return WAY[station] + [off, 0.0, 0.0], sigmas

    found = register_in_order(estimate, priors, expected).poses[5]
    assert np.hypot(*(found - WAY[5])[:2]) < 0.02


def test_the_first_pose_is_fixed() -> None:
    assert tracked().poses[0] == pytest.approx(tracked().measured_poses[0], abs=1e-4)


def there_and_back(stations: int) -> Estimate:
    """Return the first stations of a drive there and back as recorded."""
    way = np.concatenate([WAY, WAY[-2::-1]])[:stations]
    simulation = Simulation(
        world=builtin_world("square"), rig=builtin_rig("rotary-array"), route=Route(map_from_base=way)
    )
    return estimate_of(tuple(simulation))


@pytest.mark.parametrize("step", [5, 6, 8])
def test_a_wrong_registration_is_undone_for_all_later_stations(step: int) -> None:
    estimate = there_and_back(13)
    displaced = compose(estimate.poses[step], [0.1, -0.3, 0.2])
    after = compose(compose(displaced, invert(estimate.poses[step])), estimate.poses[step:])
    wrong = np.concatenate([estimate.poses[:step], after])
    priors = odometry_prior(estimate.measured_poses, estimate.settings.pose_errors)
    found = without_greatest_error(replace(estimate, poses=wrong), priors)
    assert found is not None
    assert found.poses == pytest.approx(estimate.poses)
    assert not found.features


@pytest.mark.parametrize(("stations", "step"), [(13, 0), (13, 4), (13, 9), (9, 4), (1, 0)])
def test_likely_steps_and_those_near_either_end_are_not_undone(stations: int, step: int) -> None:
    estimate = there_and_back(stations)
    priors = odometry_prior(estimate.measured_poses, estimate.settings.pose_errors)
    poses = estimate.poses + np.where(np.arange(stations) < step, 0.0, 0.3)[:, None] * [1.0, 0.0, 0.0]
    assert without_greatest_error(replace(estimate, poses=poses), priors) is None


def test_the_final_search_uses_the_tracked_poses(monkeypatch: pytest.MonkeyPatch) -> None:
    centers, original = list[FloatArray](), Estimate.search

    def searched(estimate: Estimate, *, rounds: int | None = None) -> Estimate:
        if rounds is None:
            centers.append(estimate.measurements.centers)
        return original(estimate, rounds=rounds)

    estimate = estimate_of(drive())
    monkeypatch.setattr(Estimate, "search", searched)
    estimate = track_poses(estimate, odometry_prior(estimate.measured_poses, estimate.settings.pose_errors))
    assert np.hypot(*(centers[0] - WAY[:, :2]).T).max() < 0.03


def test_the_search_is_not_repeated_at_stations_without_new_echoes(monkeypatch: pytest.MonkeyPatch) -> None:
    learned, original = list[int](), Estimate.search

    def searched(estimate: Estimate, *, rounds: int | None = None) -> Estimate:
        if rounds is not None:
            learned.append(len(estimate.measured_poses))
        return original(estimate, rounds=rounds)

    estimate = estimate_of(drive())
    monkeypatch.setattr(Estimate, "search", searched)
    estimate = track_poses(estimate, odometry_prior(estimate.measured_poses, estimate.settings.pose_errors))
    # The first two stations detect most of the room.
    assert learned[0] == 2
    assert len(learned) < len(WAY) / 2


def test_walls_are_mapped_once_at_their_true_places() -> None:
    walls = survey(tracked(), marginalise(tracked(), len(WAY)), WAY[:, :2]).walls([])
    assert len(walls) == 4
    distances = sorted(abs(wall.offset) for wall in walls)
    assert distances == pytest.approx([0.5, 1.0, 2.0, 2.5], abs=0.01)


def test_errors_of_poses_agree_with_their_sigmas() -> None:
    estimate = tracked()
    assert estimate.solution is not None
    start = estimate.solution.layout.pose
    sigmas = np.sqrt(np.diag(estimate.solution.covariance)[start:]).reshape(-1, 3)
    off = np.abs(estimate.poses - WAY)
    off[:, 2] = np.abs(wrap(estimate.poses[:, 2] - WAY[:, 2]))
    assert (off[1:] / sigmas[1:]).mean() < 3.0
    assert (sigmas[1:, :2] < 0.02).all()


def test_exact_poses_duplicate_no_walls() -> None:
    straight = estimate_of(
        tuple(
            Simulation(
                world=builtin_world("square"),
                rig=builtin_rig("rotary-array"),
                route=Route(map_from_base=WAY),
                settings=SimulationSettings(),
                seed=3,
            )
        )
    )
    straight = straight.initialise()
    assert not has_duplicated_walls(straight)
    assert straight.inlier_mask(straight.features).mean() > 0.5


def test_the_estimate_of_the_first_stations_has_no_pings_of_others() -> None:
    estimate = estimate_of(drive())
    part = up_to_station(estimate, 3)
    assert len(part.measurements.centers) == 3
    assert part.measurements.stations.max() == 2
    assert {arc.station for arc in part.arcs} == {0, 1, 2}
    assert len(estimate.measurements.centers) == 7


def test_the_initial_sonar_is_that_of_the_data_sheet() -> None:
    estimate = estimate_of(drive())
    assert estimate.model.range_scale == 0.0
    assert estimate.offset_sigma == pytest.approx(0.005 / np.sqrt(12))
    assert estimate.has_servo


def test_the_calibration_has_sigmas() -> None:
    learned = calibration(tracked(), survey(tracked(), marginalise(tracked(), len(WAY)), WAY[:, :2]).solution)
    scale = learned["range_scale"]
    assert isinstance(scale, dict)
    assert abs(scale["value"]) < 3 * scale["sigma"] + 0.002
    assert set(learned) >= {"range_offset", "walk_gain", "servo_latency", "noise", "inlier_ratio", "poses"}
