"""Estimation of odometry noise that is smaller or larger than its prior."""

import math

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import compose
from echoplan.joint.optimisation.factors import normal_equations, prior
from echoplan.joint.optimisation.odometry_noise import (
    VERY_STRONG,
    OdometryNoiseSettings,
    are_quantised,
    estimate_odometry_noise,
    estimate_waypoint_noise,
    log_odds_absolute_vs_odometry,
)
from echoplan.joint.optimisation.pose_factors import (
    PosePrior,
    PoseSettings,
    odometry_prior,
    pose_factors,
    waypoint_prior,
)

pytestmark = pytest.mark.slow

SETTINGS = OdometryNoiseSettings()
STEPS = 200
KNOWN = np.zeros((3 * STEPS + 3, 3 * STEPS + 3))


def simulated_path(spread: FloatArray) -> tuple[PosePrior, FloatArray]:
    """Return the prior of a long path of half metres, and simulated poses with errors in units of its sigmas."""
    steps = np.tile([0.5, 0.0, 0.3], (STEPS, 1))
    measured_poses = accumulated(steps)
    priors = odometry_prior(measured_poses, PoseSettings())
    errors = spread * priors.sigmas[1:] * np.random.default_rng(4).standard_normal(steps.shape)
    return priors, accumulated(steps + errors)


def accumulated(steps: FloatArray) -> FloatArray:
    poses = [np.zeros(3)]
    for step in steps:
        poses.append(compose(poses[-1], step))
    return np.array(poses)


def factors(before: PosePrior, after: PosePrior) -> FloatArray:
    ratios: FloatArray = after.sigmas[-1] / before.sigmas[-1]
    return ratios


def test_the_odometry_noise_is_estimated_per_axis() -> None:
    priors, poses = simulated_path(np.array([3.0, 0.3, 1.0]))
    assert factors(priors, estimate_odometry_noise(priors, poses, KNOWN, SETTINGS)) == pytest.approx(
        [3.0, 0.3, 1.0], rel=0.15
    )


def test_poses_without_readings_do_not_change_the_odometry_noise() -> None:
    # With the covariance of odometry alone, the expected squares of the steps are those of the prior.
    priors, _ = simulated_path(np.ones(3))
    information, _ = normal_equations([pose_factors(priors, priors.measured_poses, 0)], 3 * STEPS + 3)
    covariance: FloatArray = np.linalg.inv(information).astype(np.float64)
    learned = estimate_odometry_noise(priors, priors.measured_poses, covariance, SETTINGS)
    assert factors(priors, learned) == pytest.approx(np.ones(3), rel=1e-3)


# Standard deviation of the readings in units of the prior sigmas of steps.
READING_NOISE = 0.3


def solution(priors: PosePrior, truth: FloatArray, *, sigma_factor: float = 1.0) -> tuple[FloatArray, FloatArray]:
    """Return estimated poses and their covariance, with a factor on the sigma of the readings."""
    sigmas = np.tile(READING_NOISE * priors.sigmas[-1], len(truth))
    found = truth
    measured = truth.ravel() + sigmas * np.random.default_rng(1).standard_normal(truth.size)
    for _ in range(5):
        held = prior(np.arange(truth.size), sigma=sigma_factor * sigmas, residual=measured - found.ravel())
        information, right = normal_equations([pose_factors(priors, found, 0), held], truth.size)
        found = found + np.linalg.solve(information, right).reshape(-1, 3)
    covariance: FloatArray = np.linalg.inv(information).astype(np.float64)
    return found, covariance


@pytest.mark.parametrize("off", [0.3, 1.0, 3.0])
def test_the_odometry_noise_is_separated_from_the_noise_of_the_readings(off: float) -> None:
    # The noise of the readings exceeds the smallest of these step errors.
    priors, truth = simulated_path(np.full(3, off))
    poses, covariance = solution(priors, truth)
    assert factors(priors, estimate_odometry_noise(priors, poses, covariance, SETTINGS)) == pytest.approx(off, rel=0.2)


def test_the_information_inflation_corrects_the_odometry_noise() -> None:
    # Poses estimated with twice the true sigma of the readings.
    priors, truth = simulated_path(np.full(3, 0.3))
    poses, covariance = solution(priors, truth, sigma_factor=2.0)
    learned = [
        factors(priors, estimate_odometry_noise(priors, poses, covariance, SETTINGS, information_inflation=u))
        for u in (1.0, 4.0)
    ]
    assert (learned[0][:2] < 0.2).all()
    assert learned[1] == pytest.approx(0.3, rel=0.2)


def test_steps_without_error_give_a_small_but_positive_noise() -> None:
    # A small error cannot be distinguished from none: one well below the noise of the readings remains.
    priors, truth = simulated_path(np.zeros(3))
    poses, covariance = solution(priors, truth)
    learned = factors(priors, estimate_odometry_noise(priors, poses, covariance, SETTINGS))
    assert ((learned > 0.002) & (learned < 0.1)).all()


@pytest.mark.parametrize("steps", [5, 9, 200])
@pytest.mark.parametrize("off", [0.2, 1.0, 6.0])
def test_the_prior_of_the_odometry_noise_is_log_normal(steps: int, off: float) -> None:
    # Numerical posterior mean of the information of the factor, for known steps.
    priors = odometry_prior(accumulated(np.tile([0.5, 0.0, 0.0], (steps, 1))), PoseSettings())
    poses = accumulated(np.tile([0.5, 0.0, 0.0], (steps, 1)) + off * priors.sigmas[1:] * [1.0, 0.0, 0.0])
    learned = estimate_odometry_noise(priors, poses, np.zeros((3 * steps + 3,) * 2), SETTINGS)

    def gain(logarithm: float) -> float:
        score = logarithm / SETTINGS.log_sigma + SETTINGS.log_sigma
        return -steps * logarithm - 0.5 * steps * off**2 * math.exp(-2.0 * logarithm) - 0.5 * score**2

    logarithms = np.linspace(-4.0, 4.0, 4001)
    chances = np.exp([gain(each) - max(map(gain, logarithms[::100])) for each in logarithms])
    expected = (chances.sum() / (chances @ np.exp(-2.0 * logarithms))) ** 0.5
    assert factors(priors, learned)[0] == pytest.approx(expected, rel=1e-3)


def test_the_sigmas_of_the_first_pose_are_unchanged() -> None:
    priors, poses = simulated_path(np.full(3, 5.0))
    assert (estimate_odometry_noise(priors, poses, KNOWN, SETTINGS).sigmas[0] == priors.sigmas[0]).all()


@pytest.mark.parametrize("steps", [0, 1, 4])
def test_few_steps_do_not_change_the_odometry_noise(steps: int) -> None:
    priors = odometry_prior(accumulated(np.tile([0.5, 0.0, 0.3], (steps, 1))), PoseSettings())
    assert estimate_odometry_noise(priors, priors.measured_poses, np.zeros((3 * steps + 3,) * 2), SETTINGS) is priors


@pytest.mark.parametrize(("off", "bound"), [(1e-5, SETTINGS.min_factor), (1e3, SETTINGS.max_factor)])
def test_the_waypoint_noise_is_bounded(off: float, bound: float) -> None:
    priors = waypoint_prior(accumulated(np.tile([0.5, 0.0, 0.3], (STEPS, 1))), PoseSettings())
    poses = priors.measured_poses + np.array([off, off, 0.0])
    learned = estimate_waypoint_noise(priors, poses, KNOWN, SETTINGS)
    assert factors(priors, learned)[:2].tolist() == pytest.approx([bound, bound])


# Standard deviations along, across and in heading [m, m, rad].
ERRORS = (0.01, 0.01, 0.02)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize(("count", "doubt"), [(8, VERY_STRONG), (20, 0.0)], ids=["few", "many"])
def test_odometry_errors_accumulate_and_waypoint_errors_are_independent(seed: int, count: int, doubt: float) -> None:
    rng, steps = np.random.default_rng(seed), np.tile([0.5, 0.0, 0.4], (count - 1, 1))
    # In another frame, as an odometry solution is.
    found = compose([1.0, -2.0, 0.7], accumulated(steps))
    assert log_odds_absolute_vs_odometry(accumulated(steps + rng.normal(0.0, ERRORS, steps.shape)), found) < doubt
    assert log_odds_absolute_vs_odometry(accumulated(steps) + rng.normal(0.0, ERRORS, found.shape), found) > -doubt


@pytest.mark.parametrize("seed", range(5))
def test_errors_of_many_steps_clearly_accumulate(seed: int) -> None:
    steps = np.tile([0.5, 0.0, 0.4], (19, 1))
    found = accumulated(steps + np.random.default_rng(seed).normal(0.0, ERRORS, steps.shape))
    assert log_odds_absolute_vs_odometry(accumulated(steps), found) < -VERY_STRONG


@pytest.mark.parametrize("count", [1, 2, 5])
def test_steps_without_error_are_no_evidence(count: int) -> None:
    poses = accumulated(np.tile([0.5, 0.0, 0.5], (count - 1, 1)))
    assert abs(log_odds_absolute_vs_odometry(poses, poses)) < 1.0


@pytest.mark.parametrize(
    ("measured_poses", "expected"),
    [
        ([[0.84, 0.3, -0.19], [1.8, 0.3, -0.26]], True),
        ([[0.843, 0.3, -0.19], [1.8, 0.3, -0.26]], False),
        ([[0.8413, 0.3, 0.0], [1.8, 0.3117, 0.0]], True),
        ([[0.8413, 0.3, -0.191986], [1.8, 0.3117, 0.087266]], True),
        ([[0.8413, 0.3, -0.19], [1.8, 0.3117, 0.0]], False),
    ],
    ids=["centimetres", "millimetres", "one heading", "degrees", "neither"],
)
def test_poses_at_round_numbers_are_quantised(measured_poses: list[list[float]], *, expected: bool) -> None:
    assert are_quantised(np.array(measured_poses)) is expected


@pytest.mark.parametrize("off", [0.01, 0.05])
def test_the_waypoint_noise_is_estimated_from_pose_residuals(off: float) -> None:
    priors = waypoint_prior(accumulated(np.tile([0.5, 0.0, 0.3], (STEPS, 1))), PoseSettings())
    errors = np.random.default_rng(6).normal(0.0, [off, off, 0.5], priors.measured_poses.shape)
    learned = estimate_waypoint_noise(priors, priors.measured_poses + errors, KNOWN, SETTINGS)
    assert learned.sigmas[:, :2] == pytest.approx(off, rel=0.1)
    # The sigmas of headings are unchanged.
    assert learned.sigmas[:, 2].tolist() == priors.sigmas[:, 2].tolist()


@pytest.mark.parametrize("turns", [0, 1])
def test_the_heading_noise_of_waypoints_is_estimated_if_headings_are_determined(turns: int) -> None:
    priors = waypoint_prior(np.zeros((STEPS + 1, 3)), PoseSettings())
    errors = 0.07 * np.random.default_rng(6).standard_normal(priors.measured_poses.shape) * [0.0, 0.0, 1.0]
    poses = priors.measured_poses + errors + [0.0, 0.0, 2 * np.pi * turns]
    learned = estimate_waypoint_noise(priors, poses, KNOWN, SETTINGS, headings=True)
    assert learned.sigmas[:, 2] == pytest.approx(0.07, rel=0.1)
    assert (
        learned.sigmas[:, :2].tolist() == estimate_waypoint_noise(priors, poses, KNOWN, SETTINGS).sigmas[:, :2].tolist()
    )


def test_waypoints_without_readings_do_not_change_their_noise() -> None:
    priors = waypoint_prior(np.zeros((4, 3)), PoseSettings())
    covariance = np.diag(priors.sigmas.ravel() ** 2)
    assert estimate_waypoint_noise(priors, priors.measured_poses, covariance, SETTINGS).sigmas == pytest.approx(
        priors.sigmas
    )
