from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.arrays import FloatArray
from echoplan.evaluation.trajectory import Trajectory, compare_poses, trajectory_table
from echoplan.geometry import compose
from echoplan.model import FeatureMap, Truth
from helpers import maps

WAY = np.array([[0.0, 0, 0], [1.0, 0, 0.5], [1.5, 0.8, 1.6], [1.4, 1.9, 3.0], [0.2, 1.5, -2.5]])


def compared(poses: FloatArray, true: FloatArray = WAY, **known: Any) -> Trajectory:
    truth = Truth(walls_xy=np.zeros((0, 2, 2)), walls_detected_by=np.zeros(0, dtype=np.int64), poses=true)
    found = FeatureMap(method="by hand", sweeps=np.arange(len(poses)), poses=poses, **known)
    trajectory = compare_poses(found, truth)
    assert trajectory is not None
    return trajectory


def test_positions_and_headings_are_root_mean_squares() -> None:
    # True: (1, 1, 0) and (1, 2, 3).  Off by 3 and 4 cm, then by 12 cm; by 0.1 rad, then by -0.2 across the seam.
    poses = [[1.03, 1.04, 0.1], [1.0, 2.12, 2.8 - 2 * np.pi]]
    trajectory = compare_poses(maps.drawn(poses=poses), maps.ROOM)
    assert trajectory is not None
    assert trajectory.distances == pytest.approx([0.05, 0.12])
    assert trajectory.angles == pytest.approx([0.1, -0.2])
    assert trajectory.absolute_error == pytest.approx(np.sqrt((0.0025 + 0.0144) / 2))
    assert trajectory.heading_error == pytest.approx(np.sqrt(0.025))


def test_steps_are_compared_with_steps() -> None:
    # One step ahead of 1 m is taken for 1.03 m and 4 cm to the left, and for a turn of 0.1 rad too much.
    true = np.array([[0.0, 0, np.pi / 2], [0.0, 1.0, np.pi / 2]])
    trajectory = compared(np.array([[0.0, 0, np.pi / 2], [-0.04, 1.03, np.pi / 2 + 0.1]]), true)
    assert trajectory.steps[0] == pytest.approx([0.03, 0.04, 0.1])
    assert trajectory.relative_error == pytest.approx(0.05)
    assert trajectory.relative_heading_error == pytest.approx(0.1)


@given(st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)))
def test_a_map_that_lies_elsewhere_as_a_whole_has_right_steps(pose: tuple[float, float, float]) -> None:
    moved = compared(compose(np.array(pose), WAY))
    assert moved.relative_error == pytest.approx(0.0, abs=1e-9)
    assert moved.relative_heading_error == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_errors_are_those_of_evo(seed: int) -> None:
    metrics: Any = pytest.importorskip("evo.core.metrics", reason="evo is not installed")
    from evo.core.trajectory import PosePath3D  # noqa: PLC0415 - with the other

    found = WAY + 0.1 * np.random.default_rng(seed).standard_normal(WAY.shape)
    ours = compared(found)
    pair = tuple(PosePath3D(poses_se3=[_matrix(pose) for pose in poses]) for poses in (WAY, found))
    relations = metrics.PoseRelation
    both = [
        (metrics.APE(relations.translation_part), ours.absolute_error),
        (metrics.APE(relations.rotation_angle_rad), ours.heading_error),
        (metrics.RPE(relations.translation_part), ours.relative_error),
        (metrics.RPE(relations.rotation_angle_rad), ours.relative_heading_error),
    ]
    for metric, own in both:
        metric.process_data(pair)
        assert own == pytest.approx(metric.get_statistic(metrics.StatisticsType.rmse), rel=1e-6)


def _matrix(pose: FloatArray) -> FloatArray:
    x, y, yaw = pose
    matrix = np.eye(4)
    matrix[:2, :2] = [[np.cos(yaw), -np.sin(yaw)], [np.sin(yaw), np.cos(yaw)]]
    matrix[:2, 3] = x, y
    return matrix


def test_all_poses_but_the_first_are_compared_with_their_covariances() -> None:
    found = WAY + np.array([0.003, 0.004, 0.01])
    covariance = np.diag([0.003**2, 0.004**2, 0.005**2])
    trajectory = compared(found, pose_covariances=np.tile(covariance, (len(WAY), 1, 1)))
    assert trajectory.positions.nees == pytest.approx([2.0] * 4)
    assert trajectory.headings.nees == pytest.approx([4.0] * 4)


def test_the_table_has_a_row_for_positions_and_one_for_headings() -> None:
    table = trajectory_table(compared(WAY + np.array([0.003, 0.004, 0.0])))
    assert table.rows[0][:2] == ("position (mm)", "5.0")
    assert table.rows[1] == ("heading (°)", "0.00", "0.00", "0.00", "-")


def test_a_single_pose_has_no_steps() -> None:
    table = trajectory_table(compared(WAY[:1], WAY[:1]))
    assert table.rows[0] == ("position (mm)", "0.0", "-", "0.0", "-")


def test_poses_that_cannot_be_compared_make_an_empty_table() -> None:
    assert trajectory_table(None).rows == ()


@pytest.mark.parametrize("count", [0, 1, 3])
def test_poses_that_differ_in_number_are_not_compared(count: int) -> None:
    assert compare_poses(maps.drawn(poses=np.zeros((count, 3))), maps.ROOM) is None


def test_no_poses_are_not_compared_with_none() -> None:
    assert compare_poses(maps.drawn(), maps.NOWHERE) is None
