import numpy as np
import pytest

from echoplan.geometry import aligned, compose, identity, invert, transform_points

# Two metres ahead and one to the left, looking left.
MAP_FROM_BASE = np.array([2.0, 1.0, np.pi / 2])


def test_a_pose_takes_points_from_the_base_to_the_map() -> None:
    assert transform_points(MAP_FROM_BASE, [[3.0, 0.0], [0.0, 0.5]]) == pytest.approx(
        np.array([[2.0, 4.0], [1.5, 1.0]])
    )


def test_a_sensor_on_a_robot_has_the_pose_of_both() -> None:
    assert compose(MAP_FROM_BASE, [0.1, -0.2, np.pi]) == pytest.approx([2.2, 1.1, -np.pi / 2])


def test_the_inverse_is_the_pose_of_the_map_in_the_frame_of_the_robot() -> None:
    assert invert(MAP_FROM_BASE) == pytest.approx([-1.0, 2.0, -np.pi / 2])
    turn = np.arctan2(3.0, 4.0)
    assert invert([2.0, 1.0, turn]) == pytest.approx([-2.2, 0.4, -turn])


def test_the_identity_moves_nothing() -> None:
    assert identity().tolist() == [0.0, 0.0, 0.0]
    assert compose(identity(), MAP_FROM_BASE) == pytest.approx(MAP_FROM_BASE)
    assert transform_points(identity(), [0.3, 0.7]) == pytest.approx([0.3, 0.7])


def test_many_poses_compose_pairwise_and_with_one() -> None:
    robots = np.array([MAP_FROM_BASE, [0.0, 0.0, np.pi]])
    assert compose(robots, [1.0, 0.0, 0.0]) == pytest.approx(np.array([[2.0, 2.0, np.pi / 2], [-1.0, 0.0, -np.pi]]))
    assert compose(robots[:, None], np.zeros((1, 5, 3))).shape == (2, 5, 3)


def test_a_body_is_laid_back_to_where_it_was_moved_from() -> None:
    rng = np.random.default_rng(5)
    poses = rng.uniform(-3.0, 3.0, (7, 3))
    moved = compose([4.0, -1.0, 2.5], poses)
    assert aligned(moved, poses) == pytest.approx(poses)
    # Nearest in least squares: no small turn or shift of the body is nearer to poses that are off.
    noisy = poses + rng.normal(0.0, 0.1, poses.shape)
    best = aligned(moved, noisy)
    for change in ([0.01, 0.0, 0.0], [0.0, -0.01, 0.0], [0.0, 0.0, 0.01], [0.0, 0.0, -0.01]):
        off = compose(change, best)
        assert np.sum((off - noisy)[:, :2] ** 2) > np.sum((best - noisy)[:, :2] ** 2)
