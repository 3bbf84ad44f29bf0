"""Odometry that is better or worse than believed is found out."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import compose
from echoplan.mapping.drift import DriftSettings, learn_drift
from echoplan.mapping.poses import PoseBeliefs, PoseSettings, odometry_beliefs, pose_rows
from echoplan.mapping.rows import normal_equations

SETTINGS = DriftSettings()
STEPS = 200
KNOWN = np.zeros((3 * STEPS + 3, 3 * STEPS + 3))


def walked(spread: FloatArray) -> tuple[PoseBeliefs, FloatArray]:
    """A long way of half metres, as believed and as it was: off by so many of the deviations believed in."""
    steps = np.tile([0.5, 0.0, 0.3], (STEPS, 1))
    given = added_up(steps)
    beliefs = odometry_beliefs(given, PoseSettings())
    errors = spread * beliefs.sigmas[1:] * np.random.default_rng(4).standard_normal(steps.shape)
    return beliefs, added_up(steps + errors)


def added_up(steps: FloatArray) -> FloatArray:
    poses = [np.zeros(3)]
    for step in steps:
        poses.append(compose(poses[-1], step))
    return np.array(poses)


def factors(before: PoseBeliefs, after: PoseBeliefs) -> FloatArray:
    ratios: FloatArray = after.sigmas[-1] / before.sigmas[-1]
    return ratios


def test_each_axis_is_learned_by_itself() -> None:
    beliefs, poses = walked(np.array([3.0, 0.3, 1.0]))
    assert factors(beliefs, learn_drift(beliefs, poses, KNOWN, SETTINGS)) == pytest.approx([3.0, 0.3, 1.0], rel=0.15)


def test_poses_that_nothing_tells_teach_nothing() -> None:
    # The covariance of a way that odometry alone adds up: what is expected of each step is what was believed.
    beliefs, _ = walked(np.ones(3))
    information, _ = normal_equations([pose_rows(beliefs, beliefs.given, 0)], 3 * STEPS + 3)
    covariance: FloatArray = np.linalg.inv(information).astype(np.float64)
    assert factors(beliefs, learn_drift(beliefs, beliefs.given, covariance, SETTINGS)) == pytest.approx(np.ones(3))


def test_one_step_counts_as_much_as_what_was_believed() -> None:
    given = added_up(np.tile([0.5, 0.0, 0.0], (1, 1)))
    beliefs = odometry_beliefs(given, PoseSettings())
    learned = learn_drift(beliefs, given, np.zeros((6, 6)), SETTINGS)
    assert factors(beliefs, learned) == pytest.approx(np.full(3, np.sqrt(SETTINGS.steps / (SETTINGS.steps + 1))))


def test_the_first_pose_stays_the_frame() -> None:
    beliefs, poses = walked(np.full(3, 5.0))
    assert (learn_drift(beliefs, poses, KNOWN, SETTINGS).sigmas[0] == beliefs.sigmas[0]).all()


def test_nothing_is_learned_beyond_bounds() -> None:
    beliefs, poses = walked(np.array([1e-3, 1e3, 1.0]))
    learned = factors(beliefs, learn_drift(beliefs, poses, KNOWN, SETTINGS))
    least = max(SETTINGS.least, np.sqrt(SETTINGS.steps / (STEPS + SETTINGS.steps)))
    assert learned[:2].tolist() == pytest.approx([least, SETTINGS.greatest], rel=0.02)


def test_one_pose_has_no_steps() -> None:
    beliefs = odometry_beliefs(np.zeros((1, 3)), PoseSettings())
    assert learn_drift(beliefs, np.zeros((1, 3)), np.zeros((3, 3)), SETTINGS) is beliefs
