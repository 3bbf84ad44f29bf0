"""Drift: whether and how far odometry goes astray, told by poses that were corrected."""

import math

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray
from echoplan.geometry import aligned, wrap
from echoplan.mapping.joint.adjustment.deviations import learned_factor
from echoplan.mapping.joint.adjustment.poses import PoseBeliefs, step_residuals, step_slopes

__all__ = ["VERY_STRONG", "DriftSettings", "are_round", "learn_drift", "learn_waypoints", "scatter"]

# From this logarithm of a ratio of likelihoods on evidence is very strong [nats] (Kass and Raftery 1995).
VERY_STRONG = 5.0
# Numbers that were written with some digits are as near to the round ones that they were.
_ROUND = 1e-3
# Of fewer poses nobody can tell.
_FEWEST = 3
# What digits leave of any error, squared [m^2, rad^2].
_LEAST = 1e-8


class DriftSettings(BaseModel, frozen=True, extra="forbid"):
    """How fast belief in odometry gives way to what is seen of it."""

    spread: float = Field(
        default=0.5 * math.log(10.0), gt=0.0, description="deviation of a factor's logarithm: a guess good to tenfold"
    )
    least: float = Field(default=0.1, gt=0.0, description="of what was believed, that may be learned")
    greatest: float = Field(default=10.0, gt=0.0, description="likewise")


def learn_drift(
    beliefs: PoseBeliefs, poses: FloatArray, covariance: FloatArray, settings: DriftSettings
) -> PoseBeliefs:
    r"""Take the errors of odometry, axis by axis, from poses that were corrected.

    One step of expectation and maximisation for a factor f of each axis (Dempster, Laird and Rubin 1977) whose
    logarithm is normal before anything was seen, with deviation t: whoever guesses a deviation means its order of
    magnitude.  The expected square of an error is that of the corrected step less the given one, and its variance.

    .. math:: S = \sum_k (r_k^2 + J_k C J_k') / \sigma_k^2

    Parameters
    ----------
    beliefs : PoseBeliefs
        What was believed; relative.
    poses : ndarray, shape (s, 3)
        As corrected [m, m, rad].
    covariance : ndarray, shape (3 s, 3 s)
        Of the corrected poses.
    settings : DriftSettings
        How much what was believed counts.

    Returns
    -------
    PoseBeliefs
        The same with other deviations.
    """
    if len(poses) < 2:
        return beliefs
    slopes = np.concatenate(step_slopes(beliefs.given, poses), axis=2)[1:]
    places = 3 * np.arange(len(poses) - 1)[:, None] + np.arange(6)
    blocks = covariance[places[:, :, None], places[:, None, :]]
    variances = np.einsum("kij,kjl,kil->ki", slopes, blocks, slopes)
    squares = (step_residuals(beliefs.given, poses) ** 2 + variances) / beliefs.sigmas[1:] ** 2
    factors = learned_factor(squares.sum(axis=0), float(len(squares)), settings.spread)
    sigmas = beliefs.sigmas.copy()
    sigmas[1:] *= np.clip(factors, settings.least, settings.greatest)
    return beliefs._replace(sigmas=sigmas)


def learn_waypoints(
    beliefs: PoseBeliefs, poses: FloatArray, covariance: FloatArray, settings: DriftSettings, *, headings: bool = False
) -> PoseBeliefs:
    """Take the errors of way-points from poses that were corrected, as ``learn_drift`` does those of odometry.

    Those of headings only if asked to.  Stations that hear few walls of others turn about with what they hear: errors
    of headings learned from such would be what was believed of them.

    Parameters
    ----------
    beliefs : PoseBeliefs
        What was believed; not relative.
    poses : ndarray, shape (s, 3)
        As corrected [m, m, rad].
    covariance : ndarray, shape (3 s, 3 s)
        Of the corrected poses.
    settings : DriftSettings
        How much what was believed counts.
    headings : bool, optional
        Whether something else than other stations tells which way each faced.

    Returns
    -------
    PoseBeliefs
        The same with other deviations.
    """
    errors = beliefs.given - poses
    errors[:, 2] = wrap(errors[:, 2])
    squares = (errors**2 + np.diag(covariance).reshape(-1, 3)) / beliefs.sigmas**2
    sigmas = beliefs.sigmas.copy()
    for axes in (slice(0, 2), slice(2, 3)) if headings else (slice(0, 2),):
        factor = learned_factor(squares[:, axes].sum(), float(squares[:, axes].size), settings.spread)
        sigmas[:, axes] *= np.clip(factor, settings.least, settings.greatest)
    return beliefs._replace(sigmas=sigmas)


def scatter(given: FloatArray, poses: FloatArray) -> float:
    r"""Tell whether errors of poses scatter about the truth, or add up from one to the next.

    Each error of a step stays in all poses after it; whoever sets way-points by hand errs at each anew.  Either way the
    errors are taken to be normal, those of positions and those of headings with deviations that nobody tells: then the
    logarithm of the ratio of their greatest likelihoods is about L, with the unbiased variances V of the errors of all
    steps along and across them, and of all poses about what comes out (von Neumann 1941 has their ratio for one axis).

    .. math:: L = \frac{n - 1}{2} \left( 2 \ln \frac{V_\mathrm{steps}}{V_\mathrm{poses}}
                                     + \ln \frac{V_\mathrm{turns}}{V_\mathrm{headings}} \right)

    Parameters
    ----------
    given : ndarray, shape (s, 3)
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
    errors, steps, free = given - aligned(poses, given), step_residuals(given, poses), len(poses) - 1
    turned = wrap(errors[:, 2])
    # Where all lie was fitted to them: two places and a turn.
    ratios = (
        (np.sum(steps[:, :2] ** 2) / (2 * free), np.sum(errors[:, :2] ** 2) / (2 * free - 1)),
        (np.mean(steps[:, 2] ** 2), np.sum((turned - turned.mean()) ** 2) / free),
    )
    (by_steps, by_poses), (by_turns, by_headings) = np.array(ratios) + _LEAST
    return 0.5 * free * float(2.0 * np.log(by_steps / by_poses) + np.log(by_turns / by_headings))


def are_round(given: FloatArray) -> bool:
    """Tell whether somebody may have marked poses: people do so at round numbers, where no wheels come to a halt.

    Parameters
    ----------
    given : ndarray, shape (s, 3)
        As recorded [m, m, rad].

    Returns
    -------
    bool
        Whether all positions are whole centimetres, or all headings whole degrees.
    """
    numbers = 100.0 * given[:, :2], np.degrees(given[:, 2])
    return any(bool(np.all(np.abs(each - np.round(each)) < _ROUND)) for each in numbers)
