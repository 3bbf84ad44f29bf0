"""Sweeps of a head that turns while the robot drives: pings between two stations, whose drift grows with the way."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.joint.optimisation.edge_diffraction import edges_of
from echoplan.joint.optimisation.layout import POSE_COLUMNS
from echoplan.joint.optimisation.optimiser import Features, OptimiserSettings, Priors, optimise, range_factors
from echoplan.joint.optimisation.pose_factors import (
    PoseSettings,
    at_poses,
    bridge_variances,
    neighbours_of,
    odometry_prior,
)
from echoplan.joint.optimisation.solution import Solution
from echoplan.joint.optimisation.values import Values
from echoplan.model import Odometry
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import NOISE, REACH, ROOM, SONAR, cylinder, listening, pings_of

# Stations along a straight path, half of the way between two of them, and by how much odometry underestimates it.
STATIONS_X, HALF, DRIFT = np.linspace(-0.8, 0.8, 5), 0.2, 0.06
MEASURED = np.column_stack([STATIONS_X, np.zeros((5, 2))])
TRUE = MEASURED * [1.0 + DRIFT, 1.0, 1.0] + [DRIFT * 0.8, 0.0, 0.0]
REFLECTORS = np.array([*ROOM, cylinder(0.3, 0.9, 0.1)])


def driven(*, true: bool = False) -> Measurements:
    """Return silent pings of a head that makes one turn a station, in places by odometry or the true ones."""
    standing = listening([(x, 0.0) for x in STATIONS_X])
    ways = np.tile(np.linspace(-HALF, HALF, len(standing.x) // len(STATIONS_X)), len(STATIONS_X))
    drift = DRIFT * (STATIONS_X[standing.stations] + ways + 0.8) if true else 0.0
    return standing._replace(x=standing.x + ways + drift, ways=ways)


def recorded() -> Measurements:
    """Return the pings with the readings from the true places."""
    return driven()._replace(readings=pings_of(driven(true=True), REFLECTORS).readings)


def state(poses: FloatArray) -> Values:
    """Return the true landmarks, which all stations detect, and poses."""
    extents, none = np.tile([-REACH, REACH], (len(REFLECTORS), 1)), np.zeros((len(REFLECTORS), len(poses)))
    ends = edges_of(REFLECTORS, extents)
    features = Features(reflectors=REFLECTORS, extents=extents, attenuations=none, bias_variances=none, ends=ends)
    return Values(features=features, model=SONAR, poses=poses)


def priors() -> Priors:
    """Return the priors of an odometry with the usual errors, in air of known temperature."""
    poses = odometry_prior(MEASURED, PoseSettings())
    return Priors(
        noise=NOISE, offset_sigma=0.0015, walk_gain=SONAR.walk_gain, has_servo=False, scale_sigma=1e-4, poses=poses
    )


def solution(measurements: Measurements) -> Solution:
    return optimise(measurements, state(MEASURED), priors(), OptimiserSettings(max_iterations=20))


def test_pings_between_stations_take_a_share_of_both_corrections() -> None:
    found, true = at_poses(driven(), MEASURED, TRUE), driven(true=True)
    inside = (found.x > TRUE[0, 0] + 0.1) & (found.x < TRUE[-1, 0] - 0.1)
    assert found.x[inside] == pytest.approx(true.x[inside], abs=1e-9)
    rigid = at_poses(driven()._replace(ways=np.zeros(len(true.x))), MEASURED, TRUE)
    assert np.abs(rigid.x - true.x)[inside].max() > 0.9 * DRIFT * HALF


def test_headings_between_stations_are_interpolated_across_the_border_of_full_turns() -> None:
    poses = MEASURED.copy()
    poses[:, 2] = [3.0, 3.1, 3.1 + 0.2 - 2.0 * np.pi, 3.4, 3.4]
    moved = at_poses(driven(), MEASURED, poses)
    own = np.flatnonzero((driven().stations == 1) & (driven().ways > 0.0))
    turned = wrap(moved.bearings[own] - driven().bearings[own])
    assert wrap(turned - 3.1) == pytest.approx(0.2 * driven().ways[own] / (2.0 * HALF))


def test_pings_of_a_robot_that_stands_move_with_their_station() -> None:
    standing = listening([(x, 0.0) for x in STATIONS_X])
    moved = at_poses(standing, MEASURED, TRUE)
    assert (moved.x == TRUE[standing.stations, 0] + (standing.x - STATIONS_X[standing.stations])).all()
    assert not bridge_variances(standing, odometry_prior(MEASURED, PoseSettings())).any()


def test_the_shares_of_two_sweeps_meet_halfway() -> None:
    measurements = driven()
    others, shares = neighbours_of(measurements, MEASURED)
    first, second = (np.flatnonzero(measurements.stations == station) for station in (1, 2))
    assert (others[first[-1]], others[second[0]]) == (2, 1)
    assert shares[first[-1]] == pytest.approx(0.5)
    assert shares[second[0]] == pytest.approx(0.5)
    assert shares[measurements.ways < 0.0][0] == 0.0


def test_positions_scatter_about_their_interpolation_as_a_brownian_bridge() -> None:
    specified = odometry_prior(MEASURED, PoseSettings(), Odometry(along=0.02, lateral=0.02))
    scatter, measurements = bridge_variances(driven(), specified), driven()
    rng = np.random.default_rng(0)
    paths = np.cumsum(rng.normal(0.0, 0.02 * np.sqrt(0.4 / 100), (4000, 100)), axis=1)
    bridge = paths[:, 49] - 0.5 * paths[:, 99]
    inner = (measurements.stations == 2) & (np.abs(measurements.ways) == HALF)
    assert np.sqrt(scatter[inner]) == pytest.approx(bridge.std(), rel=0.05)


def test_the_jacobian_by_the_poses_equals_finite_differences() -> None:
    now, measurements = state(TRUE + np.array([0.003, -0.004, 0.01])), recorded()
    factor = range_factors(measurements, now, priors(), OptimiserSettings())
    assert factor.jacobian.shape[1] == POSE_COLUMNS + 6
    for column in range(now.layout.pose, now.layout.size):
        step = np.eye(now.layout.size)[column] * 1e-6
        rows = [
            range_factors(measurements, now.retracted(sign * step), priors(), OptimiserSettings()) for sign in (1, -1)
        ]
        numeric = (rows[1].residuals - rows[0].residuals) / 2e-6
        analytic = np.where(factor.columns == column, factor.jacobian, 0.0).sum(axis=1)
        rows_of_pose = (factor.columns == column).any(axis=1)
        # The tables of the range walk are piecewise linear.
        assert np.quantile(np.abs(numeric - analytic)[rows_of_pose], 0.95) < 0.02


def test_drift_within_sweeps_is_corrected() -> None:
    measurements = recorded()
    found = solution(measurements)
    rigid = solution(measurements._replace(ways=np.zeros(len(measurements.ways))))
    errors = [np.abs(each.reflectors[:4, 2] - ROOM[:, 2]).max() for each in (found, rigid)]
    assert errors[0] < 0.003
    assert errors[1] > 0.008


def test_a_sweep_is_no_less_certain_for_standing_beside_moving_ones() -> None:
    measurements = recorded()
    standing = measurements.stations == 0
    mixed = measurements._replace(ways=np.where(standing, 0.0, measurements.ways))
    weights = range_factors(mixed, state(TRUE), priors()._replace(noise=0.006), OptimiserSettings()).weights
    assert weights.max() > 2.0 * np.median(weights)
