import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, invert, wrap
from echoplan.joint.optimisation.factors import LinearFactor, normal_equations
from echoplan.joint.optimisation.pose_factors import (
    PosePrior,
    PoseSettings,
    at_poses,
    odometry_prior,
    pose_factors,
    waypoint_prior,
)
from echoplan.joint.optimisation.solver import solve
from echoplan.model import Odometry
from helpers.expectations import listening, pings_of, wall

WAY = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.5], [1.5, 0.8, 1.6], [1.4, 1.9, 3.0]])
SETTINGS = PoseSettings()
POSES = st.lists(st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3, 3)), min_size=2, max_size=6)


def residuals_at(priors: PosePrior, poses: FloatArray) -> FloatArray:
    return pose_factors(priors, poses, 0).residuals


def dense(rows: LinearFactor, layout: int) -> FloatArray:
    """Return the dense Jacobian."""
    matrix = np.zeros((len(rows.residuals), layout + 1))
    for row, (columns, jacobian) in enumerate(zip(rows.columns, rows.jacobian, strict=True)):
        np.add.at(matrix[row], columns, jacobian)
    return matrix[:, :layout]


def test_a_longer_step_has_greater_sigmas() -> None:
    given_poses = np.array([[0.0, 0, 0], [0.5, 0, 0], [2.5, 0, 0]])
    sigmas = odometry_prior(given_poses, SETTINGS).sigmas
    assert sigmas[1] == pytest.approx([0.0155, 0.013, np.hypot(np.radians(1.25), np.radians(0.3))])
    assert (sigmas[2] > sigmas[1]).all()


def test_a_greater_turn_has_a_greater_heading_sigma() -> None:
    straight = odometry_prior(np.array([[0.0, 0, 0], [1.0, 0, 0.0]]), SETTINGS).sigmas[1]
    turned = odometry_prior(np.array([[0.0, 0, 0], [1.0, 0, 2.0]]), SETTINGS).sigmas[1]
    assert turned[2] > straight[2]
    assert turned[:2] == pytest.approx(straight[:2])


def test_specified_odometry_noise_is_a_random_walk() -> None:
    specified = Odometry(along=0.02, lateral=0.01, yaw_per_metre=0.03, yaw_per_radian=0.04)
    one = odometry_prior(np.array([[0.0, 0, 0], [4.0, 0, 1.0]]), SETTINGS, specified)
    assert one.sigmas[1] == pytest.approx([0.04, 0.02, np.sqrt(0.03**2 * 4 + 0.04**2)], rel=0.01)
    assert one.specified
    many = odometry_prior(np.linspace([0.0, 0, 0], [4.0, 0, 1.0], 11), SETTINGS, specified)
    assert np.sqrt((many.sigmas[1:] ** 2).sum(axis=0)) == pytest.approx(one.sigmas[1], rel=0.03)


@pytest.mark.parametrize("way", [0.0, 0.7, np.pi / 2, np.pi, -2.0])
@pytest.mark.parametrize("turn", [0.0, 1.2])
def test_odometry_errors_are_along_and_across_the_direction_of_travel(way: float, turn: float) -> None:
    direction = np.array([np.cos(way), np.sin(way)])
    given_poses = np.array([[0.0, 0.0, 0.0], [*direction, turn]])
    priors = odometry_prior(given_poses, SETTINGS, Odometry(along=0.1, lateral=0.001))
    information, _ = normal_equations([pose_factors(priors, given_poses, 0)], 6)
    spread = np.linalg.inv(information)[3:5, 3:5]
    assert np.sqrt(direction @ spread @ direction) == pytest.approx(0.1, rel=0.01)
    assert np.sqrt(direction[::-1] * [-1, 1] @ spread @ (direction[::-1] * [-1, 1])) < 0.002
    own = np.array([np.cos(way - turn), np.sin(way - turn)])
    assert priors.reaches[1, :2] == pytest.approx(0.1 * np.abs(own), abs=0.002)


def test_without_specification_the_noise_is_a_default() -> None:
    assert not odometry_prior(WAY, SETTINGS).specified


def test_missing_odometry_values_are_defaults_and_zeros_are_kept() -> None:
    guessed = odometry_prior(WAY, SETTINGS).sigmas[1:]
    sigmas = odometry_prior(WAY, SETTINGS, Odometry(along=0.3, lateral=0.0)).sigmas[1:]
    length = np.hypot(*np.diff(WAY[:, :2], axis=0).T)
    assert sigmas[:, 0] == pytest.approx(0.3 * np.sqrt(length), rel=0.01)
    assert sigmas[:, 1].max() < 0.001
    assert sigmas[:, 2] == pytest.approx(guessed[:, 2], rel=0.01)
    turning = odometry_prior(WAY, SETTINGS, Odometry(yaw_per_metre=0.0)).sigmas[1:]
    assert turning[:, :2] == pytest.approx(guessed[:, :2], rel=0.02)
    floor = np.hypot(SETTINGS.yaw_per_radian * np.abs(wrap(np.diff(WAY[:, 2]))), SETTINGS.min_yaw_sigma)
    assert turning[:, 2] == pytest.approx(floor, rel=0.01)


def test_the_first_pose_is_the_frame_of_the_map() -> None:
    assert odometry_prior(WAY, SETTINGS).sigmas[0].max() < 1e-3


def test_all_waypoints_have_the_same_sigmas() -> None:
    priors = waypoint_prior(WAY, SETTINGS)
    assert not priors.relative
    assert (
        priors.sigmas == [SETTINGS.absolute_xy_sigma, SETTINGS.absolute_xy_sigma, SETTINGS.absolute_yaw_sigma]
    ).all()


@pytest.mark.parametrize("priors", [odometry_prior(WAY, SETTINGS), waypoint_prior(WAY, SETTINGS)])
def test_recorded_poses_have_zero_residuals(priors: PosePrior) -> None:
    assert residuals_at(priors, WAY) == pytest.approx(np.zeros(12), abs=1e-12)


@given(poses=POSES, seed=st.integers(0, 99))
@settings(max_examples=30, deadline=None)
def test_the_jacobian_of_pose_factors_equals_finite_differences(
    poses: list[tuple[float, float, float]], seed: int
) -> None:
    given_poses = np.array(poses)
    now = given_poses + np.random.default_rng(seed).normal(0.0, 0.05, given_poses.shape)
    for priors in (odometry_prior(given_poses, SETTINGS), waypoint_prior(given_poses, SETTINGS)):
        matrix, step = dense(pose_factors(priors, now, 0), now.size), 1e-6
        for column in range(now.size):
            there = now.copy()
            there.flat[column] += step
            back = now.copy()
            back.flat[column] -= step
            change = residuals_at(priors, back) - residuals_at(priors, there)
            change[2::3] = wrap(change[2::3])
            assert change / (2 * step) == pytest.approx(matrix[:, column], abs=1e-5)


def test_odometry_factors_do_not_depend_on_the_frame() -> None:
    moved = compose(np.broadcast_to([0.3, -0.2, 0.7], WAY.shape), WAY)
    assert residuals_at(odometry_prior(WAY, SETTINGS), moved)[3:] == pytest.approx(np.zeros(9), abs=1e-12)
    assert np.abs(residuals_at(waypoint_prior(WAY, SETTINGS), moved)).max() > 0.1


def test_heading_residuals_are_wrapped() -> None:
    given_poses = np.array([[0.0, 0, np.pi - 0.01], [1.0, 0, -np.pi + 0.01]])
    now = given_poses + np.array([[0, 0, 0.02], [0, 0, -0.02]])
    assert np.abs(residuals_at(waypoint_prior(given_poses, SETTINGS), now)).max() == pytest.approx(0.02)


def test_odometry_factors_alone_give_the_recorded_poses() -> None:
    priors, now = odometry_prior(WAY, SETTINGS), WAY + 0.03
    for _ in range(5):
        now = now + solve(*normal_equations([pose_factors(priors, now, 0)], now.size)).reshape(-1, 3)
    assert now == pytest.approx(WAY, abs=1e-9)


def test_pose_factors_start_at_the_given_column() -> None:
    columns = pose_factors(odometry_prior(WAY, SETTINGS), WAY, 7).columns
    assert columns.max() == 7 + 12 - 1
    assert columns[columns >= 0].min() == 7


def test_pings_move_with_the_robot() -> None:
    measurements = listening()
    given_poses = np.column_stack([measurements.centers, np.zeros(len(measurements.centers))])
    poses = compose(np.broadcast_to([0.2, 0.1, 0.4], given_poses.shape), given_poses)
    moved = at_poses(measurements, given_poses, poses)
    places = compose(
        np.broadcast_to([0.2, 0.1, 0.4], (len(measurements.x), 3)),
        np.column_stack([measurements.x, measurements.y, np.arctan2(measurements.uy, measurements.ux)]),
    )
    assert np.column_stack([moved.x, moved.y]) == pytest.approx(places[:, :2])
    assert wrap(np.arctan2(moved.uy, moved.ux) - places[:, 2]) == pytest.approx(np.zeros(len(moved.x)), abs=1e-12)
    assert np.hypot(moved.arms_x, moved.arms_y) == pytest.approx(np.hypot(measurements.arms_x, measurements.arms_y))


def test_moving_there_and_back_changes_nothing() -> None:
    measurements = pings_of(listening(), [wall(0.0, 2.0)])
    given_poses = np.column_stack([measurements.centers, np.zeros(len(measurements.centers))])
    poses = given_poses + np.array([0.1, -0.2, 0.3])
    back = at_poses(at_poses(measurements, given_poses, poses), poses, given_poses)
    for name in ("x", "y", "ux", "uy", "arms_x", "arms_y", "centers"):
        assert getattr(back, name) == pytest.approx(getattr(measurements, name), abs=1e-12)
    assert (back.readings == measurements.readings).all()


def test_a_step_and_its_inverse_cancel() -> None:
    assert compose(invert(WAY), WAY) == pytest.approx(np.zeros(WAY.shape), abs=1e-12)
