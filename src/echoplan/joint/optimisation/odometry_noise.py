"""Drift: whether and how far odometry goes astray, told by poses that were corrected."""

import math

import numpy as np
from pydantic import BaseModel, Field

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
    "scatter",
]

# From this logarithm of a ratio of likelihoods on evidence is very strong [nats] (Kass and Raftery 1995).
VERY_STRONG = 5.0
# Numbers that were written with some digits are as near to the round ones that they were.
_ROUND = 1e-3
# Of fewer poses nobody can tell.
_FEWEST = 3
# Of fewer steps a deviation is known to no better than a third (1 / sqrt(2 n)).
_STEPS = 5
# What digits leave of any error, squared [m^2, rad^2].
_LEAST = 1e-8
# What is left of the variance of a step that was believed, however much is heard.
_HEARD = 1e-9
# Deviations of axes are learned in turn, so often; each on a grid so far to either side [deviations of its logarithm].
_TURNS, _REACH, _GRID = 3, 6.0, 241


class OdometryNoiseSettings(BaseModel, frozen=True, extra="forbid"):
    """How fast belief in odometry gives way to what is seen of it."""

    spread: float = Field(
        default=0.5 * math.log(10.0), gt=0.0, description="deviation of a factor's logarithm: a guess good to tenfold"
    )
    least: float = Field(default=0.1, gt=0.0, description="share of what was believed of way-points that is learned")
    greatest: float = Field(default=10.0, gt=0.0, description="likewise")


def estimate_odometry_noise(
    priors: PosePrior,
    poses: FloatArray,
    covariance: FloatArray,
    settings: OdometryNoiseSettings,
    *,
    information_inflation: float = 1.0,
) -> PosePrior:
    r"""Take the errors of odometry, axis by axis, from poses that were corrected.

    What readings alone tell of the errors of all steps is the information about them after an adjustment without that
    of what was believed, and what that makes of the errors that came out.  With the errors of the other axes left
    open, its eigenvalues l and the pulls p along their vectors, all in deviations believed, a factor f of the
    deviations of one axis has the marginal likelihood

    .. math:: L(f) = \prod_k (1 + l_k f^2)^{-1/2} \exp \frac{p_k^2 f^2}{2 (1 + l_k f^2)}

    that is the evidence of Bishop (2006, Section 3.5).  Before anything was heard ln f is normal with deviation t and
    mean -t^2: some robots err tenfold less than others, and what is guessed is the root mean square of all.  Where
    nothing tells a small error from none the greatest likelihood would be that of none (Chung et al. 2013), and poses
    would seem surer than they are: taken is the factor that leaves as much of the errors open as all factors do in
    the mean.

    .. math:: \sum_k \frac{f^2}{1 + l_k f^2} = E_f \sum_k \frac{f^2}{1 + l_k f^2}

    Parameters
    ----------
    priors : PosePrior
        With what the poses were corrected; relative.
    poses : ndarray, shape (s, 3)
        As corrected [m, m, rad].
    covariance : ndarray, shape (3 s, 3 s)
        Of the corrected poses.
    settings : OdometryNoiseSettings
        How much what was believed counts.
    information_inflation : float, optional
        How many times more readings tell than they were let count for.

    Returns
    -------
    PosePrior
        The same with other deviations; what was believed where there are fewer than five steps.
    """
    if len(poses) <= _STEPS:
        return priors
    information, pull = (information_inflation * each for each in _heard_of_steps(priors, poses, covariance))
    squares = np.ones(3)
    for _ in range(_TURNS):
        for axis in range(3):
            squares[axis] = _square(*_heard_of_axis(information, pull, axis, squares), settings.spread)
    sigmas = priors.sigmas.copy()
    sigmas[1:] *= np.sqrt(squares)
    return priors._replace(sigmas=sigmas)


def _heard_of_steps(priors: PosePrior, poses: FloatArray, covariance: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Tell what readings alone say of the errors of steps in deviations believed: information, and how it pulls."""
    blocks = np.concatenate(between_jacobians(priors.measured_poses, poses), axis=2)[1:]
    jacobian = np.zeros((*blocks.shape[:2], len(covariance)))
    for step, (block, sigmas) in enumerate(zip(blocks, priors.sigmas[1:], strict=True)):
        jacobian[step, :, 3 * step : 3 * step + 6] = block / sigmas[:, None]
    jacobian = jacobian.reshape(-1, len(covariance))
    unit = np.eye(len(jacobian))
    known = np.linalg.inv(jacobian @ covariance @ jacobian.T + _HEARD * unit)
    return known - unit, known @ (between_residuals(priors.measured_poses, poses) / priors.sigmas[1:]).ravel()


def _heard_of_axis(
    information: FloatArray, pull: FloatArray, axis: int, squares: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Tell what readings say of the errors of one axis while those of the others are open, by so much squared."""
    own = np.arange(len(pull)) % 3 == axis
    known = information + np.diag(np.tile(1.0 / squares, len(pull) // 3))
    left = np.linalg.solve(known[~own][:, ~own], np.column_stack([information[~own][:, own], pull[~own]]))
    left = information[own][:, ~own] @ left
    return information[own][:, own] - left[:, :-1], pull[own] - left[:, -1]


def _square(information: FloatArray, pull: FloatArray, spread: float) -> float:
    """Tell how many times greater the squares of errors are than was believed."""
    log_densities, axes = np.linalg.eigh(information)
    log_densities, pulls = np.maximum(log_densities, 0.0), axes.T @ pull
    scores = np.linspace(-_REACH, _REACH, _GRID)
    logarithms = 2.0 * spread * (scores - spread)
    squares = np.exp(logarithms)[:, None]
    left = squares / (1.0 + log_densities * squares)
    llr_by_station = 0.5 * (np.sum(pulls**2 * left - np.log1p(log_densities * squares), axis=1) - scores**2)
    chances, sums = np.exp(llr_by_station - llr_by_station.max()), left.sum(axis=1)
    return float(np.exp(np.interp(chances @ sums / chances.sum(), sums, logarithms)))


def estimate_waypoint_noise(
    priors: PosePrior,
    poses: FloatArray,
    covariance: FloatArray,
    settings: OdometryNoiseSettings,
    *,
    headings: bool = False,
) -> PosePrior:
    """Take the errors of way-points from the squares that are expected of them where poses were corrected.

    A guess is good to tenfold either way (``map_scale_factor``).  Errors of headings are learned only if asked for.
    Stations that hear few walls of others turn about with what they hear: errors of headings learned from such would be
    what was believed of them.

    Parameters
    ----------
    priors : PosePrior
        What was believed; not relative.
    poses : ndarray, shape (s, 3)
        As corrected [m, m, rad].
    covariance : ndarray, shape (3 s, 3 s)
        Of the corrected poses.
    settings : OdometryNoiseSettings
        How much what was believed counts.
    headings : bool, optional
        Whether something else than other stations tells which way each faced.

    Returns
    -------
    PosePrior
        The same with other deviations.
    """
    errors = priors.measured_poses - poses
    errors[:, 2] = wrap(errors[:, 2])
    squares = (errors**2 + np.diag(covariance).reshape(-1, 3)) / priors.sigmas**2
    sigmas = priors.sigmas.copy()
    for axes in (slice(0, 2), slice(2, 3)) if headings else (slice(0, 2),):
        factor = map_scale_factor(squares[:, axes].sum(), float(squares[:, axes].size), settings.spread)
        sigmas[:, axes] *= np.clip(factor, settings.least, settings.greatest)
    return priors._replace(sigmas=sigmas)


def scatter(measured_poses: FloatArray, poses: FloatArray) -> float:
    r"""Tell whether errors of poses scatter about the truth, or add up from one to the next.

    Each error of a step stays in all poses after it; whoever sets way-points by hand errs at each anew.  Either way the
    errors are taken to be normal, those of positions and those of headings with deviations that nobody tells: then the
    logarithm of the ratio of their greatest likelihoods is about L, with the unbiased variances V of the errors of all
    steps along and across them, and of all poses about what comes out (von Neumann 1941 has their ratio for one axis).

    .. math:: L = \frac{n - 1}{2} \left( 2 \ln \frac{V_\mathrm{steps}}{V_\mathrm{poses}}
                                     + \ln \frac{V_\mathrm{turns}}{V_\mathrm{headings}} \right)

    Parameters
    ----------
    measured_poses : ndarray, shape (s, 3)
        As recorded [m, m, rad].
    poses : ndarray, shape (s, 3)
        As corrected, in whatever frame.

    Returns
    -------
    float
        L [nats], positive where they scatter; 0 for fewer than three poses.
    """
    if len(poses) < _FEWEST:
        return 0.0
    errors, steps, free = (
        measured_poses - aligned(poses, measured_poses),
        between_residuals(measured_poses, poses),
        len(poses) - 1,
    )
    turned = wrap(errors[:, 2])
    # Where all lie was fitted to them: two places and a turn.
    ratios = (
        (np.sum(steps[:, :2] ** 2) / (2 * free), np.sum(errors[:, :2] ** 2) / (2 * free - 1)),
        (np.mean(steps[:, 2] ** 2), np.sum((turned - turned.mean()) ** 2) / free),
    )
    (by_steps, by_poses), (by_turns, by_headings) = np.array(ratios) + _LEAST
    return 0.5 * free * float(2.0 * np.log(by_steps / by_poses) + np.log(by_turns / by_headings))


def are_quantised(measured_poses: FloatArray) -> bool:
    """Tell whether somebody may have marked poses: people do so at round numbers, where no wheels come to a halt.

    Parameters
    ----------
    measured_poses : ndarray, shape (s, 3)
        As recorded [m, m, rad].

    Returns
    -------
    bool
        Whether all positions are whole centimetres, or all headings whole degrees.
    """
    numbers = 100.0 * measured_poses[:, :2], np.degrees(measured_poses[:, 2])
    return any(bool(np.all(np.abs(each - np.round(each)) < _ROUND)) for each in numbers)
