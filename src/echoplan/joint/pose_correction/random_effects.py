"""Random effects: the error that all readings of one landmark from one station share, estimated from residuals."""

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

# Maximum number of iterations, and relative change of the estimate at which they have converged.
_ROUNDS, _AT_REST = 8, 0.05
# Iterations of the optimisation without shared errors.
_AS_IF = 6


def without_shared_bias(estimate: Estimate, pose_prior: PosePrior) -> Estimate:
    """Return the estimate optimised as if readings of a station shared no error but that of rounding.

    The default of the shared error lowers the weights of the readings and leaves poses near their priors, even if
    echoes fit better elsewhere. Residuals there would then be taken for shared errors. ``pose_prior`` is absolute.
    """
    estimate = replace(estimate, bias_sigma=estimate.offset_sigma)
    return estimate.alternate(estimate.noise, pose_prior, _AS_IF).estimate_noise()


def estimate_shared_bias(estimate: Estimate, pose_prior: PosePrior) -> Estimate:
    """Return the estimate with an estimated standard deviation of the shared error, optimised anew with it.

    How straight walls are and how accurate the sonar model is, is unknown beforehand, so the prior is log-normal over a
    factor of ten. The estimate is no less than the error of rounding. ``pose_prior`` is absolute.
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
    """Return the standard deviation of the shared error by maximum a posteriori, from the present residuals [m]."""
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
    return guess * float(map_scale_factor(squares / guess**2, count, settings.pose_errors.bias_log_sigma))


def common_squares(rows: LinearFactor, covariance: FloatArray, *, common: float) -> tuple[float, float]:
    r"""Return the expected sum of squares S of the shared errors [m^2] and the effective number n of them.

    The shared errors are random effects (Searle, Casella and McCulloch 1992). Their variance is that for which the
    expected sum of their squares is the variance times the number of effects that the readings determine (MacKay 1992,
    Section 4). With weights W of g groups, means m of their residuals and derivatives j of these means,

    .. math:: k = \frac{t^2}{t^2 + 1 / W}, \qquad
              S = \sum k^2 m^2, \qquad n = g - \sum \left(1 - k + \frac{k^2 j C j'}{t^2}\right)

    ``rows`` are the range factors with independent weights and free poses. C is the ``covariance`` of all unknowns,
    shape (u, u), from an optimisation with shared errors of standard deviation t (``common``) [m].
    """
    owners, stations = rows.columns[:, 0], rows.columns[:, -1]
    groups = np.unique(owners * len(covariance) + stations, return_inverse=True)[1]
    weights = np.bincount(groups, rows.weights)
    means = np.bincount(groups, rows.weights * rows.residuals) / weights
    jacobian = np.zeros((len(weights), len(covariance) + 1))
    # Padding has the position -1: the last column, which is dropped.
    np.add.at(jacobian, (groups[:, None], rows.columns), rows.weights[:, None] * rows.jacobian)
    jacobian = jacobian[:, :-1] / weights[:, None]
    variances = np.einsum("gi,ij,gj->g", jacobian, covariance, jacobian)
    shares = common**2 / (common**2 + 1.0 / weights)
    effects = np.sum(shares - shares**2 * variances / common**2)
    return float(np.sum((shares * means) ** 2)), max(float(effects), 0.0)
