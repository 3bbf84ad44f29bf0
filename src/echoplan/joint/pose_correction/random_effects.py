"""Effects: what all that a station says of a feature is wrong by together, told by what is left of its readings."""

from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.factors import LinearFactor
from echoplan.joint.optimisation.optimiser import range_factors
from echoplan.joint.optimisation.pose_factors import PosePrior
from echoplan.joint.optimisation.values import Values
from echoplan.joint.optimisation.variance_components import map_scale_factor
from echoplan.preprocessing.servo import AS_RECORDED

__all__ = ["common_squares", "estimate_shared_bias", "without_shared_bias"]

# So often what is learned may change all from which it was learned, and by which share of it this is at rest.
_ROUNDS, _AT_REST = 8, 0.05
# So often all is adjusted as if there were none.
_AS_IF = 6


def without_shared_bias(estimate: Estimate, pose_prior: PosePrior) -> Estimate:
    """Adjust everything as if stations erred together by no more than rounding does.

    A guess of how much they do holds readings down, and leaves poses where beliefs in these and in the sonar draw them,
    though echoes would fit better elsewhere.  What is left of readings there would seem to be common errors.

    Parameters
    ----------
    estimate : Estimate
        What was heard, with poses that are nearly right.
    pose_prior : PosePrior
        What is believed of these; absolute.
    """
    estimate = replace(estimate, bias_sigma=estimate.offset_sigma)
    return estimate.alternate(estimate.noise, pose_prior, _AS_IF).estimate_noise()


def estimate_shared_bias(estimate: Estimate, pose_prior: PosePrior) -> Estimate:
    """Learn how much stations err together, and adjust everything anew.

    Nobody knows beforehand how straight walls are, or how far echoes are from what is expected of them: the guess is
    taken to be good to tenfold.  What is learned is never less than what rounding does.

    Parameters
    ----------
    estimate : Estimate
        What was heard, with poses that are at rest.
    pose_prior : PosePrior
        What is believed of these; absolute.
    """
    for _ in range(_ROUNDS):
        before = estimate.bias_sigma
        estimate = replace(estimate, bias_sigma=max(_learned(estimate, pose_prior), estimate.offset_sigma))
        estimate = estimate.optimise(estimate.noise, pose_prior)
        if abs(estimate.bias_sigma - before) < _AT_REST * before:
            break
    estimate = estimate.rescore(estimate.noise).estimate_noise()
    return estimate.alternate(estimate.noise, pose_prior, 2)


def _learned(estimate: Estimate, pose_prior: PosePrior) -> float:
    assert estimate.solution is not None
    now = Values(
        features=estimate.with_attenuation(estimate.features),
        model=estimate.model,
        latency=estimate.latency,
        servo=estimate.servo or AS_RECORDED,
        poses=estimate.poses,
    )
    single, settings = estimate.priors(estimate.noise, pose_prior)._replace(bias_sigma=0.0), estimate.settings
    rows = range_factors(estimate.recorded, now, single, settings.optimiser)
    squares, count = common_squares(rows, estimate.solution.covariance, common=estimate.bias_sigma)
    guess = settings.pose_errors.bias_sigma
    return guess * float(map_scale_factor(squares / guess**2, count, settings.pose_errors.pair_spread))


def common_squares(rows: LinearFactor, covariance: FloatArray, *, common: float) -> tuple[float, float]:
    r"""Tell the squares of what readings of one feature from one station have in common of their errors.

    They are random effects (Searle, Casella and McCulloch 1992).  Their variance is that for which the sum of the
    squares, as they are expected, is as many times its own as there are effects that the readings tell (MacKay 1992,
    Section 4).  Of g groups with weights W, means m of what is left and derivatives j of these means,

    .. math:: k = \frac{t^2}{t^2 + 1 / W}, \qquad
              S = \sum k^2 m^2, \qquad n = g - \sum \left(1 - k + \frac{k^2 j C j'}{t^2}\right)

    Parameters
    ----------
    rows : LinearFactor
        Of readings from free poses, each weighed by itself.
    covariance : ndarray, shape (u, u)
        Of all unknowns, C, as adjusted with the effects that are believed in.
    common : float
        Standard deviation t that is believed of them [m].

    Returns
    -------
    squares : float
        The sum S [m^2].
    count : float
        How many effects are told, n; at least 0.
    """
    owners, stations = rows.columns[:, 0], rows.columns[:, -1]
    groups = np.unique(owners * len(covariance) + stations, return_inverse=True)[1]
    weights = np.bincount(groups, rows.weights)
    means = np.bincount(groups, rows.weights * rows.residuals) / weights
    jacobian = np.zeros((len(weights), len(covariance) + 1))
    # What fills rows up has place -1: the last column, that is left out.
    np.add.at(jacobian, (groups[:, None], rows.columns), rows.weights[:, None] * rows.jacobian)
    jacobian = jacobian[:, :-1] / weights[:, None]
    variances = np.einsum("gi,ij,gj->g", jacobian, covariance, jacobian)
    shares = common**2 / (common**2 + 1.0 / weights)
    effects = np.sum(shares - shares**2 * variances / common**2)
    return float(np.sum((shares * means) ** 2)), max(float(effects), 0.0)
