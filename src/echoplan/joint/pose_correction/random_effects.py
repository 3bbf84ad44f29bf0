"""Random effects: the error that all readings of one landmark from one station share, estimated from residuals."""

from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.factors import LinearFactor
from echoplan.joint.optimisation.optimiser import optimise, range_factors
from echoplan.joint.optimisation.pose_factors import PosePrior
from echoplan.joint.optimisation.variance_components import map_scale_factor

__all__ = ["common_squares", "estimate_shared_bias"]

# Maximum number of iterations, and relative change of the estimate at which they have converged.
_ROUNDS, _AT_REST = 8, 0.05


def estimate_shared_bias(estimate: Estimate, pose_prior: PosePrior) -> Estimate:
    """Estimate the standard deviation of the shared error (maximum a posteriori), and optimise with it.

    How straight walls are and how accurate the sonar model is, is unknown beforehand, so the prior is log-normal over a
    factor of ten. The estimate is no less than the error of rounding. ``pose_prior`` is absolute.
    """
    settings, least = estimate.settings, estimate.offset_sigma
    guess, spread = settings.pose_errors.bias_sigma, settings.pose_errors.bias_log_sigma
    for _ in range(_ROUNDS):
        assert estimate.solution is not None
        before, now = estimate.bias_sigma, estimate.values(estimate.features, estimate.poses)
        single = estimate.priors(estimate.noise, pose_prior)._replace(bias_sigma=0.0)
        rows = range_factors(estimate.recorded, now, single, settings.optimiser)
        squares, count = common_squares(rows, estimate.solution.covariance, common=before)
        learned = guess * float(map_scale_factor(squares / guess**2, count, spread))
        estimate = replace(estimate, bias_sigma=max(learned, least))
        solution = optimise(*estimate.problem(estimate.noise, pose_prior))
        estimate = estimate.with_solution(solution, pose_prior)
        if abs(estimate.bias_sigma - before) < _AT_REST * before:
            break
    return estimate.rescore(estimate.noise).estimate_noise()


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
