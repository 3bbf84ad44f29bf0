"""Salient features and the filter on simulated echoes."""

import numpy as np
import pytest

from echoplan.classical.salient_ekf import SalientEkfMapper
from echoplan.evaluation import evaluate
from echoplan.io import builtin_rig, builtin_route, builtin_world
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Truth
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.simulation.settings import OdometryNoise
from helpers.scenes import rig, sweep_of

DRIFT = OdometryNoise(along=0.02, lateral=0.02, yaw_per_metre=0.035, yaw_per_radian=0.035)


def drive(odometry: OdometryNoise, *, seed: int = 0) -> tuple[FeatureMap, Truth]:
    made = Simulation(
        world=builtin_world("paper-room"),
        rig=builtin_rig("rotary-array"),
        route=builtin_route("paper-room"),
        settings=SimulationSettings(odometry=odometry),
        seed=seed,
    )
    return map_sweeps(SalientEkfMapper(made.rig), made), made.truth


@pytest.mark.parametrize("seed", [0, 1])
def test_drifting_odometry_is_corrected(seed: int) -> None:
    found, truth = drive(DRIFT, seed=seed)
    odometry = np.sqrt(np.mean(np.sum((truth.given - truth.poses)[:, :2] ** 2, axis=1)))
    trajectory = evaluate(found, truth).trajectory
    assert trajectory is not None
    assert trajectory.absolute_error < odometry / 3


def test_with_good_poses_the_room_is_right_and_the_poses_stay() -> None:
    found, truth = drive(OdometryNoise())
    evaluation = evaluate(found, truth)
    assert evaluation.matches.walls.tally.recall == 1.0
    assert evaluation.matches.walls.tally.precision == 1.0
    assert evaluation.matches.cylinders.tally.found == 1
    assert evaluation.trajectory is not None
    assert evaluation.trajectory.absolute_error < 0.03


def test_asking_for_the_map_changes_nothing() -> None:
    mapper = SalientEkfMapper(rig())
    mapper.add(sweep_of(np.full(360, 1.5)))
    first, second = mapper.result(), mapper.result()
    assert len(first.walls) == len(second.walls) == 0
    np.testing.assert_array_equal(first.poses, second.poses)


def test_a_sweep_without_echoes_is_still_a_step_of_the_way() -> None:
    mapper = SalientEkfMapper(rig())
    for index, x in enumerate((0.0, 0.5)):
        mapper.add(sweep_of(np.full(360, np.inf), index=index, pose=(x, 0.0, 0.0)))
    np.testing.assert_allclose(mapper.result().poses, [[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]], atol=1e-12)


def test_what_was_seen_lies_on_the_walls_after_the_correction() -> None:
    made = Simulation(
        world=builtin_world("paper-room"), rig=builtin_rig("rotary-array"), route=builtin_route("paper-room")
    )
    mapper = SalientEkfMapper(made.rig)
    found = map_sweeps(mapper, made)
    lines = np.array([[wall.normal_angle, wall.offset] for wall in found.walls])
    for seen in mapper.observations:
        if seen.degrees[2] == 1.0:
            normals = np.stack([np.cos(lines[:, 0]), np.sin(lines[:, 0])], axis=1)
            assert np.abs(normals @ seen.point.position_xy - lines[:, 1]).min() < 0.05
