"""Waypoints in a simulated room, each registered to its neighbours."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.arrays import FloatArray
from echoplan.geometry import aligned, compose, wrap
from echoplan.io import builtin_rig, builtin_world
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.optimisation.pose_factors import PoseSettings, waypoint_steps
from echoplan.joint.pose_correction.annealing import refine
from echoplan.joint.pose_correction.pose_tracking import register_in_order
from echoplan.joint.pose_correction.registration_order import (
    rearranged,
    seen_from_others,
    spanning_tree_order,
    waypoint_prediction,
)
from echoplan.joint.settings import EstimateSettings
from echoplan.model import Route
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.simulation import Simulation
from helpers.tracking import track_poses

pytestmark = pytest.mark.slow

# An order in which neighbouring places are not consecutive.
WAY = np.array(
    [
        [0.0, 0.0, 0.0],
        [1.1, 1.0, 1.8],
        [0.6, 0.0, 0.4],
        [0.1, 1.4, -2.2],
        [1.0, 0.4, 1.2],
        [0.1, 0.7, -1.2],
        [0.7, 1.5, 2.8],
    ]
)
SETTINGS = PoseSettings()


def misplaced_estimate(seed: int) -> Estimate:
    """Return the initial estimate of seven stations, with errors of 3 cm and 14 degrees."""
    rig = builtin_rig("rotary-array")
    sweeps = Simulation(world=builtin_world("square"), rig=rig, route=Route(map_from_base=WAY), seed=3)
    off = np.random.default_rng(seed).normal(0.0, (0.03, 0.03, 0.25), WAY.shape)
    measured = [replace(sweep, map_from_base=sweep.map_from_base + by) for sweep, by in zip(sweeps, off, strict=True)]
    detected = join_measurements([measurements_of(sweep, rig) for sweep in measured])
    return initial_estimate(rig, detected, np.array([sweep.station for sweep in measured]), EstimateSettings())


def placed(estimate: Estimate) -> FloatArray:
    """Return the poses after each station was registered to those near it, shape (s, 3) [m, m, rad]."""
    order = spanning_tree_order(estimate.measured_poses[:, :2])
    part = rearranged(estimate, order)
    steps = waypoint_steps(part.measured_poses, SETTINGS)
    found = refine(register_in_order(part, steps, waypoint_prediction(part.measured_poses, SETTINGS)), steps)
    return found.poses[np.argsort(order)]


def errors(poses: FloatArray) -> tuple[float, float]:
    """Return the greatest errors of position [m] and of heading [rad] after alignment."""
    moved = aligned(poses, WAY)
    away, turned = np.hypot(*(moved - WAY)[:, :2].T), np.abs(wrap(moved[:, 2] - WAY[:, 2]))
    return float(away.max()), float(turned.max())


def test_stations_are_registered_to_their_neighbours() -> None:
    found = 0
    for seed in range(8, 14):
        estimate = misplaced_estimate(seed)
        away, turned = errors(estimate.poses)
        assert away > 0.03
        assert np.degrees(turned) > 10.0
        away, turned = errors(placed(estimate))
        found += away < 0.002 and np.degrees(turned) < 1.0
    # A square is symmetric, so that a station is sometimes registered to the wrong walls.
    assert found >= 4


def test_tracking_in_recorded_order_fails() -> None:
    estimate = misplaced_estimate(10)
    estimate = track_poses(estimate, waypoint_steps(estimate.measured_poses, SETTINGS))
    assert errors(estimate.poses)[0] > 0.05


@given(places=st.lists(st.tuples(st.floats(-9, 9), st.floats(-9, 9)), min_size=1, max_size=9))
def test_each_place_is_the_nearest_remaining_one(places: list[tuple[float, float]]) -> None:
    xy = np.array(places)
    order = spanning_tree_order(xy)
    assert sorted(order) == list(range(len(xy)))
    apart = np.hypot(*(xy[:, None] - xy[None]).transpose(2, 0, 1))
    for count in range(1, len(order)):
        before, left = order[:count], order[count:]
        assert apart[before, left[0]].min() == apart[np.ix_(before, left)].min()


def test_one_neighbour_predicts_a_station_with_the_error_of_its_heading() -> None:
    waypoints, frame = np.array([[1.0, 0.0, 0.3]]), np.array([2.0, -1.0, 0.7])
    pose, sigmas = seen_from_others(np.array([4.0, 4.0, 1.0]), waypoints, compose(frame, waypoints), SETTINGS)
    assert pose == pytest.approx(compose(frame, np.array([4.0, 4.0, 1.0])))
    assert sigmas[:2] == pytest.approx(
        np.hypot(SETTINGS.absolute_xy_sigma * np.sqrt(2.0), 5.0 * SETTINGS.absolute_yaw_sigma)
    )
    assert sigmas[2] == pytest.approx(SETTINGS.absolute_yaw_sigma * np.sqrt(2.0))


def test_more_neighbours_reduce_the_sigmas_of_the_prediction() -> None:
    waypoints, frame = np.column_stack([np.arange(6.0), np.zeros(6), np.zeros(6)]), np.array([2.0, -1.0, 0.7])
    found, sought = compose(frame, waypoints), np.array([6.0, 0.0, 0.0])
    sigmas = [seen_from_others(sought, waypoints[:count], found[:count], SETTINGS)[1] for count in range(1, 7)]
    assert (np.diff(sigmas, axis=0) < 0.0).all()
    # The sigma that remains is that of the station itself and of the rotation of the frame.
    assert sigmas[-1][0] < 2.0 * SETTINGS.absolute_xy_sigma


def test_the_sigmas_of_the_prediction_agree_with_simulated_errors() -> None:
    rng, sought, off = np.random.default_rng(5), np.array([3.0, 1.0, 0.4]), []
    waypoints = np.column_stack([rng.uniform(0.0, 3.0, (4, 2)), rng.uniform(-3.0, 3.0, 4)])
    spread = (SETTINGS.absolute_xy_sigma, SETTINGS.absolute_xy_sigma, SETTINGS.absolute_yaw_sigma)
    for _ in range(2000):
        measured_poses = np.vstack([waypoints, sought]) + rng.normal(0.0, spread, (5, 3))
        pose, sigmas = seen_from_others(measured_poses[-1], measured_poses[:-1], waypoints, SETTINGS)
        away = pose - sought
        away[2] = wrap(away[2])
        off.append(away / sigmas)
    spreads = np.std(off, axis=0)
    assert np.sqrt(np.mean(spreads[:2] ** 2)) == pytest.approx(1.0, abs=0.25)
    assert spreads[2] == pytest.approx(1.0, abs=0.1)
