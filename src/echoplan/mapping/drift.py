"""Drift: whether and how far odometry goes astray, told by poses that were corrected."""

import math

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray
from echoplan.geometry import aligned, wrap
from echoplan.mapping.deviations import learned_factor
from echoplan.mapping.poses import PoseBeliefs, step_residuals, step_slopes

__all__ = ["VERY_STRONG", "DriftSettings", "adds_up", "learn_drift"]

# From this logarithm of a ratio of likelihoods on evidence is very strong [nats] (Kass and Raftery 1995).
VERY_STRONG = 5.0


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
    slopes = np.concatenate(step_slopes(poses), axis=2)[1:]
    places = 3 * np.arange(len(poses) - 1)[:, None] + np.arange(6)
    blocks = covariance[places[:, :, None], places[:, None, :]]
    variances = np.einsum("kij,kjl,kil->ki", slopes, blocks, slopes)
    squares = (step_residuals(beliefs.given, poses) ** 2 + variances) / beliefs.sigmas[1:] ** 2
    factors = learned_factor(squares.sum(axis=0), float(len(squares)), settings.spread)
    sigmas = beliefs.sigmas.copy()
    sigmas[1:] *= np.clip(factors, settings.least, settings.greatest)
    return beliefs._replace(sigmas=sigmas)


def adds_up(given: FloatArray, poses: FloatArray) -> bool:
    r"""Tell whether errors of poses add up from one to the next, unless they clearly scatter about the truth.

    Each error of odometry stays in all poses after it; whoever sets way-points by hand errs at each anew.  The ratio of
    von Neumann (1941) of the errors e along each axis tells: it is about 2 where they scatter, and near 0 where they
    add up.  The logarithm of the ratio of the likelihoods of both is about L.

    .. math:: r = \frac{n}{n - 1} \frac{\sum (e_{k+1} - e_k)^2}{\sum e_k^2}, \qquad
              L = \frac{n - 1}{2} (2 \ln r_\mathrm{position} + \ln r_\mathrm{heading})

    Parameters
    ----------
    given : ndarray, shape (s, 3)
        As recorded [m, m, rad].
    poses : ndarray, shape (s, 3)
        As corrected, in whatever frame.

    Returns
    -------
    bool
        Whether a ratio is at most 1, or the evidence that errors scatter not very strong.
    """
    errors = given - aligned(poses, given)
    turned = wrap(errors[:, 2])
    position, heading = _ratio(errors[:, :2]), _ratio((turned - turned.mean())[:, None])
    if min(position, heading) <= 1.0:
        return True
    return 0.5 * (len(poses) - 1) * (2.0 * math.log(position) + math.log(heading)) <= VERY_STRONG


def _ratio(errors: FloatArray) -> float:
    total, count = float(np.sum(errors**2)), len(errors)
    return count / (count - 1) * float(np.sum(np.diff(errors, axis=0) ** 2)) / total if total > 0.0 else 0.0
