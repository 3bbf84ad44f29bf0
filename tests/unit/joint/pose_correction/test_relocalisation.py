"""A station that converged beside its true place: it misses the walls before it."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.io import builtin_rig, builtin_world
from echoplan.joint import pose_model_selection
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.optimisation.pose_factors import at_poses
from echoplan.joint.pose_correction.annealing import refine
from echoplan.joint.pose_correction.relocalisation import relocalised
from echoplan.joint.pose_model_selection import estimate_map
from echoplan.joint.pose_status import PoseReason, PoseStatus
from echoplan.joint.settings import EstimateSettings, PoseMode
from echoplan.model import Route
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.simulation import Simulation, SimulationSettings

WAY = np.array([[0.0, 0.0, 0.0], [0.6, 0.0, 0.4], [1.0, 0.4, 1.2], [1.1, 1.0, 1.8], [0.7, 1.5, 2.8], [0.1, 1.4, -2.2]])
STATION, ASIDE = 3, np.array([0.07, 0.0, 0.0])


@cache
def settled() -> Estimate:
    """Return the refined estimate of a square from the true poses."""
    simulation = Simulation(
        world=builtin_world("square"),
        rig=builtin_rig("rotary-array"),
        route=Route(map_from_base=WAY),
        settings=SimulationSettings(),
        seed=3,
    )
    detected = join_measurements([measurements_of(sweep, simulation.rig) for sweep in simulation])
    estimate = initial_estimate(
        simulation.rig, detected, WAY, EstimateSettings(poses=PoseMode.CORRECT, max_waypoints=0)
    )
    return refine(estimate, estimate.odometry())


def misplaced() -> Estimate:
    """Return the same with one station displaced."""
    estimate = settled()
    poses = estimate.poses.copy()
    poses[STATION] += ASIDE
    estimate = replace(estimate, poses=poses, measurements=at_poses(estimate.recorded, estimate.measured_poses, poses))
    return estimate.rescore(estimate.noise).optimise(estimate.noise)


def test_a_misplaced_station_is_relocalised() -> None:
    estimate = misplaced()
    assert relocalised(estimate, estimate.odometry(), STATION) == pytest.approx(WAY[STATION], abs=0.01)


def test_consistent_stations_are_not_relocalised() -> None:
    assert all(relocalised(settled(), settled().odometry(), station) is None for station in range(1, len(WAY)))


def test_a_misplaced_station_is_corrected_without_a_wheel_slip(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pose_model_selection, "register_in_order", lambda estimate, *_: estimate)
    monkeypatch.setattr(pose_model_selection, "agrees", lambda _: False)
    found = estimate_map(misplaced())
    assert found.poses == pytest.approx(WAY, abs=0.01)
    assert found.pose_status == PoseStatus(reason=PoseReason.ODOMETRY, is_requested=True)
