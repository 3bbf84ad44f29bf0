import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.io import builtin_rig
from echoplan.model import Odometry
from echoplan.simulation import OdometryNoise, with_odometry
from echoplan.simulation.odometry import dead_reckoning


def way(steps: int) -> FloatArray:
    """Four metres ahead in so many steps."""
    return np.column_stack([np.linspace(0.0, 4.0, steps + 1), np.zeros(steps + 1), np.zeros(steps + 1)])


def spread(noise: OdometryNoise, poses: FloatArray) -> FloatArray:
    """Standard deviation of the last pose over many runs."""
    ends = [dead_reckoning(poses, noise, np.random.default_rng(run))[-1] for run in range(1000)]
    deviation: FloatArray = np.std(ends, axis=0)
    return deviation


def test_without_noise_the_robot_knows_where_it_is() -> None:
    poses = way(3)
    assert dead_reckoning(poses, OdometryNoise(), np.random.default_rng(0)) is poses


def test_the_first_pose_is_true_and_the_rest_are_not() -> None:
    poses = np.add(way(3), [1.0, 2.0, 0.3])
    found = dead_reckoning(poses, OdometryNoise(along=0.02, yaw_per_metre=0.03), np.random.default_rng(0))
    np.testing.assert_allclose(found[0], poses[0])
    assert (np.abs(found[1:] - poses[1:]).max(axis=1) > 1e-4).all()


@pytest.mark.parametrize("steps", [1, 10])
def test_deviations_grow_with_the_root_of_the_way_however_it_is_cut(steps: int) -> None:
    assert spread(OdometryNoise(along=0.02), way(steps)) == pytest.approx([0.04, 0, 0], rel=0.08, abs=1e-12)
    assert spread(OdometryNoise(lateral=0.01), way(steps)) == pytest.approx([0, 0.02, 0], rel=0.08, abs=1e-12)
    assert spread(OdometryNoise(yaw_per_metre=0.03), way(steps))[2] == pytest.approx(0.06, rel=0.08)


def test_turning_spoils_the_heading_only() -> None:
    poses = np.array([[1.0, 1.0, 0.0], [1.0, 1.0, 1.0], [1.0, 1.0, 0.0]])
    found = spread(OdometryNoise(yaw_per_radian=0.05, along=0.1), poses)
    assert found == pytest.approx([0, 0, 0.05 * np.sqrt(2)], rel=0.08, abs=1e-12)


def test_along_and_across_go_with_the_way_not_with_the_axes() -> None:
    poses = np.array([[0.0, 0.0, 0.7], [0.0, 4.0, 0.7]])
    assert spread(OdometryNoise(along=0.02), poses) == pytest.approx([0, 0.04, 0], rel=0.08, abs=1e-9)
    assert spread(OdometryNoise(lateral=0.02), poses) == pytest.approx([0.04, 0, 0], rel=0.08, abs=1e-9)


def test_a_wrong_heading_makes_positions_drift() -> None:
    poses = way(4)
    found = spread(OdometryNoise(yaw_per_metre=0.03), poses)
    # Headings 0.03, 0.042, 0.052 off after 1, 2 and 3 m, each for a metre on.
    assert found[1] == pytest.approx(0.03 * np.sqrt(3**2 + 2**2 + 1), rel=0.08)


def test_a_rig_states_the_noise_it_is_given() -> None:
    noise = OdometryNoise(along=0.02, lateral=0.01, yaw_per_metre=0.03, yaw_per_radian=0.04)
    stated = with_odometry(builtin_rig("rotary-array"), noise).odometry
    assert stated == Odometry(along=0.02, lateral=0.01, yaw_per_metre=0.03, yaw_per_radian=0.04)


def test_a_rig_of_a_robot_that_knows_where_it_is_states_no_noise() -> None:
    rig = builtin_rig("rotary-array")
    assert with_odometry(rig, OdometryNoise()) is rig
