"""Dead reckoning and its errors."""

import numpy as np
import pytest

from echoplan.classical.slam import GaussianState, MotionSettings, moved
from echoplan.geometry import compose

START = GaussianState(sizes={"a": 3}, mean=np.array([1.0, 2.0, 0.8]), covariance=np.diag([0.01, 0.04, 0.02]))
MOTION = np.array([0.6, 0.2, 0.3])


def test_the_pose_after_a_motion_is_that_of_dead_reckoning() -> None:
    after = moved(START, "b", MOTION, start="a", settings=MotionSettings())["b"]
    np.testing.assert_allclose(after, compose(START["a"], MOTION))


def test_a_heading_may_turn_on_beyond_a_full_circle() -> None:
    start = GaussianState(sizes={"a": 3}, mean=np.array([0.0, 0.0, 3.0]), covariance=np.zeros((3, 3)))
    assert moved(start, "b", np.array([0.0, 0.0, 0.5]), start="a", settings=MotionSettings())["b"][2] == 3.5


def test_the_spread_is_that_of_many_such_motions() -> None:
    settings = MotionSettings(along=0.05, lateral=0.01, yaw_per_metre=0.04, yaw_per_radian=0.02)
    rng = np.random.default_rng(4)
    starts = rng.multivariate_normal(START.mean, START.covariance / 100, size=40_000)
    motions = rng.multivariate_normal(MOTION, settings.covariance(MOTION), size=40_000)
    ends = compose(starts, motions)
    near = GaussianState(sizes={"a": 3}, mean=START.mean, covariance=START.covariance / 100)
    state = moved(near, "b", MOTION, start="a", settings=settings)
    np.testing.assert_allclose(state.marginal(["b"]).covariance, np.cov(ends.T), rtol=0.1, atol=3e-5)
    np.testing.assert_allclose(state.covariance[:3, 3:], np.cov(starts.T, ends.T)[:3, 3:], rtol=0.1, atol=3e-5)


def test_errors_along_the_way_are_along_the_way() -> None:
    aside = MotionSettings(along=0.1, lateral=0.0).covariance(np.array([0.0, 0.25, 0.0]))
    assert aside[:2, :2] == pytest.approx(np.diag([0.0, 0.1**2 * 0.25]))


def test_two_half_motions_have_the_covariance_of_the_whole_motion() -> None:
    settings = MotionSettings()
    whole, half = (settings.covariance(np.array([way, 0.0, 0.4 * way])) for way in (1.0, 0.5))
    np.testing.assert_allclose(whole, 2 * half)


def test_a_robot_that_stands_still_has_no_odometry_error() -> None:
    assert not MotionSettings().covariance(np.zeros(3)).any()
