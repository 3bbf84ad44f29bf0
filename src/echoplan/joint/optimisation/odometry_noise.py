"""Noise of odometry and waypoints, estimated from corrected poses."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import aligned, wrap
from echoplan.joint.optimisation.pose_factors import PosePrior, between_jacobians, between_residuals
from echoplan.joint.optimisation.variance_components import map_scale_factor

__all__ = [
    "VERY_STRONG",
    "OdometryNoiseSettings",
    "are_quantised",
    "estimate_odometry_noise",
    "estimate_waypoint_noise",
    "log_odds_absolute_vs_odometry",
]

# Log-likelihood ratio from which evidence is very strong [nats] (Kass and Raftery 1995).
VERY_STRONG = 5.0
# Greatest deviation of a round number, due to the digits with which it was recorded [cm, degrees].
_ROUND = 1e-3
# Minimum number of poses to distinguish independent from accumulated errors.
_FEWEST = 3
# Minimum number of steps: with fewer, a standard deviation is known to no better than a third (1 / sqrt(2 n)).
_STEPS = 5
# Variance due to the digits with which poses are recorded [m^2, rad^2].
_LEAST = 1e-8
# Lower bound of the posterior variance of a step, as a share of its prior variance.
_LEAST_VARIANCE = 1e-9
# Sweeps over the axes; half width of the grid of factors [sigmas of the logarithm], and number of its points.
_TURNS, _REACH, _GRID = 3, 6.0, 241


class OdometryNoiseSettings(NamedTuple):
    """Settings of the estimated noise of odometry and waypoints."""

    # Standard deviation of the logarithm of the factor of the odometry noise: two of them are a factor of ten.
    log_sigma: float = 0.5 * math.log(10.0)
    # Smallest factor by which the noise of waypoints is scaled.
    min_factor: float = 0.1
    # Largest factor by which the noise of waypoints is scaled.
    max_factor: float = 10.0


def estimate_odometry_noise(
    pose_prior: PosePrior,
    poses: FloatArray,
    covariance: FloatArray,
    settings: OdometryNoiseSettings,
    *,
    information_inflation: float = 1.0,
) -> PosePrior:
    r"""Return the pose prior with standard deviations of odometry that are estimated from corrected poses, per axis.

    The information of the readings alone on the errors of all steps is that of the solution minus that of the pose
    prior. The errors of the other axes are marginalised. With the eigenvalues l of this information and the components
    p of the information vector along its eigenvectors, all in units of the prior standard deviations, a factor f of the
    standard deviations of one axis has the marginal likelihood

    .. math:: L(f) = \prod_k (1 + l_k f^2)^{-1/2} \exp \frac{p_k^2 f^2}{2 (1 + l_k f^2)}

    which is the evidence of Bishop (2006, Section 3.5). The prior of ln f is normal with standard deviation t and mean
    -t^2: robots differ by a factor of ten, and the default is their root mean square. If readings cannot distinguish a
    small error from none, the likelihood is greatest at f = 0 (Chung et al. 2013), and poses would be overconfident. So
    f is chosen such that the posterior variance of the errors equals its mean over the posterior of f:

    .. math:: \sum_k \frac{f^2}{1 + l_k f^2} = E_f \sum_k \frac{f^2}{1 + l_k f^2}

    ``pose_prior`` is relative and contributed to ``poses`` and their ``covariance``, shape (3 s, 3 s);
    ``information_inflation`` is the ratio of the information of the readings to that which their weights give them.
    With fewer than five steps the prior is returned unchanged.
    """
    if len(poses) <= _STEPS:
        return pose_prior
    information, pull = (information_inflation * each for each in _information_on_steps(pose_prior, poses, covariance))
    squares = np.ones(3)
    for _ in range(_TURNS):
        for axis in range(3):
            squares[axis] = _square(*_information_on_axis(information, pull, axis, squares), settings.log_sigma)
    sigmas = pose_prior.sigmas.copy()
    sigmas[1:] *= np.sqrt(squares)
    return pose_prior._replace(sigmas=sigmas)


def _information_on_steps(
    pose_prior: PosePrior, poses: FloatArray, covariance: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return information matrix and vector of the readings alone on the errors of steps, in units of prior sigmas."""
    blocks = np.concatenate(between_jacobians(pose_prior.measured_poses, poses), axis=2)[1:]
    jacobian = np.zeros((*blocks.shape[:2], len(covariance)))
    for step, (block, sigmas) in enumerate(zip(blocks, pose_prior.sigmas[1:], strict=True)):
        jacobian[step, :, 3 * step : 3 * step + 6] = block / sigmas[:, None]
    jacobian = jacobian.reshape(-1, len(covariance))
    unit = np.eye(len(jacobian))
    known = np.linalg.inv(jacobian @ covariance @ jacobian.T + _LEAST_VARIANCE * unit)
    return known - unit, known @ (between_residuals(pose_prior.measured_poses, poses) / pose_prior.sigmas[1:]).ravel()


def _information_on_axis(
    information: FloatArray, pull: FloatArray, axis: int, squares: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return information matrix and vector on the errors of one axis, with those of the others marginalised.

    ``squares`` are the present ratios of error variance to prior variance, by axis.
    """
    own = np.arange(len(pull)) % 3 == axis
    known = information + np.diag(np.tile(1.0 / squares, len(pull) // 3))
    left = np.linalg.solve(known[~own][:, ~own], np.column_stack([information[~own][:, own], pull[~own]]))
    left = information[own][:, ~own] @ left
    return information[own][:, own] - left[:, :-1], pull[own] - left[:, -1]


def _square(information: FloatArray, pull: FloatArray, spread: float) -> float:
    """Return the ratio of the error variance of one axis to its prior variance."""
    eigenvalues, axes = np.linalg.eigh(information)
    eigenvalues, pulls = np.maximum(eigenvalues, 0.0), axes.T @ pull
    scores = np.linspace(-_REACH, _REACH, _GRID)
    logarithms = 2.0 * spread * (scores - spread)
    squares = np.exp(logarithms)[:, None]
    left = squares / (1.0 + eigenvalues * squares)
    log_posterior = 0.5 * (np.sum(pulls**2 * left - np.log1p(eigenvalues * squares), axis=1) - scores**2)
    chances, sums = np.exp(log_posterior - log_posterior.max()), left.sum(axis=1)
    return float(np.exp(np.interp(chances @ sums / chances.sum(), sums, logarithms)))


def estimate_waypoint_noise(
    pose_prior: PosePrior,
    poses: FloatArray,
    covariance: FloatArray,
    settings: OdometryNoiseSettings,
    *,
    headings: bool = False,
) -> PosePrior:
    """Return the pose prior with standard deviations of waypoints estimated from their expected squared errors.

    Each is the prior value times a factor with a log-normal prior (``map_scale_factor``). Yaw is included only with
    ``headings``, if something other than other stations determines it: the yaw of a station that shares few walls with
    others follows its prior, and so would the estimate. ``covariance``, shape (3 s, 3 s), is that of the corrected
    poses.
    """
    errors = pose_prior.measured_poses - poses
    errors[:, 2] = wrap(errors[:, 2])
    squares = (errors**2 + np.diag(covariance).reshape(-1, 3)) / pose_prior.sigmas**2
    sigmas = pose_prior.sigmas.copy()
    for axes in (slice(0, 2), slice(2, 3)) if headings else (slice(0, 2),):
        factor = map_scale_factor(squares[:, axes].sum(), float(squares[:, axes].size), settings.log_sigma)
        sigmas[:, axes] *= np.clip(factor, settings.min_factor, settings.max_factor)
    return pose_prior._replace(sigmas=sigmas)


def log_odds_absolute_vs_odometry(measured_poses: FloatArray, poses: FloatArray) -> float:
    r"""Return the log odds of independent pose errors (absolute poses) against accumulated ones (odometry) [nats].

    An error of odometry persists in all later poses; a waypoint placed by hand has an error of its own. Both kinds are
    taken for normal, positions and headings with unknown standard deviations. The log ratio of the maximum likelihoods
    is then about L, with the unbiased variances V of the errors of all steps along and across them, and of all poses
    after alignment (von Neumann 1941 has this ratio for one axis).

    .. math:: L = \frac{n - 1}{2} \left( 2 \ln \frac{V_\mathrm{steps}}{V_\mathrm{poses}}
                                     + \ln \frac{V_\mathrm{turns}}{V_\mathrm{headings}} \right)

    Corrected ``poses`` may be in any frame. The result is 0 for fewer than three poses.
    """
    if len(poses) < _FEWEST:
        return 0.0
    errors, steps, free = (
        measured_poses - aligned(poses, measured_poses),
        between_residuals(measured_poses, poses),
        len(poses) - 1,
    )
    turned = wrap(errors[:, 2])
    # The alignment uses three degrees of freedom: x, y and yaw.
    ratios = (
        (np.sum(steps[:, :2] ** 2) / (2 * free), np.sum(errors[:, :2] ** 2) / (2 * free - 1)),
        (np.mean(steps[:, 2] ** 2), np.sum((turned - turned.mean()) ** 2) / free),
    )
    (by_steps, by_poses), (by_turns, by_headings) = np.array(ratios) + _LEAST
    return 0.5 * free * float(2.0 * np.log(by_steps / by_poses) + np.log(by_turns / by_headings))


def are_quantised(measured_poses: FloatArray) -> bool:
    """Return whether all positions are whole centimetres, or all headings whole degrees.

    Such poses may be waypoints that were placed by hand; odometry does not stop at round numbers.
    """
    numbers = 100.0 * measured_poses[:, :2], np.degrees(measured_poses[:, 2])
    return any(bool(np.all(np.abs(each - np.round(each)) < _ROUND)) for each in numbers)
