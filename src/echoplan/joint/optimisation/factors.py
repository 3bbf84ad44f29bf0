"""Linearised factors of measurements, constraints and priors, their normal equations, and marginal priors."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.optimisation.solver import solve

__all__ = ["InformationPrior", "LinearFactor", "normal_equations", "prior"]

# Information added to eliminated unknowns, of which some may be unobserved.
_TRACE = 1e-9


class LinearFactor(NamedTuple):
    """m linearised equations ``residual = jacobian . step`` with at most k unknowns each."""

    # Positions of the unknowns, shape (m, k); -1 is padding.
    columns: IntArray
    # Derivatives of the predictions by these unknowns, shape (m, k).
    jacobian: FloatArray
    # Observation minus prediction, shape (m,).
    residuals: FloatArray
    # Inverse variances, shape (m,).
    weights: FloatArray


class InformationPrior(NamedTuple):
    """Gaussian prior of k unknowns in information form, left by marginalised factors."""

    # Positions of the unknowns, shape (k,).
    columns: IntArray
    # ``J' W J`` with all other unknowns eliminated, linearised at their values at that time, shape (k, k).
    information: FloatArray
    # ``J' W J x + J' W r``, shape (k,): right-hand side of the normal equations of the values, not of a step.
    vector: FloatArray

    def marginalised_onto(self, columns: IntArray) -> "InformationPrior":
        """Return the prior of some unknowns, by their positions here, with the others eliminated (Schur complement)."""
        gone = np.setdiff1d(np.arange(len(self.columns)), columns)
        if not len(gone):
            return self
        # Unobserved unknowns would make the matrix singular.
        inner = self.information[np.ix_(gone, gone)] + _TRACE * np.eye(len(gone))
        cross = self.information[np.ix_(columns, gone)]
        carried = solve(inner, np.column_stack([cross.T, self.vector[gone]]))
        information = self.information[np.ix_(columns, columns)] - cross @ carried[:, :-1]
        return InformationPrior(
            columns=self.columns[columns],
            information=0.5 * (information + information.T),
            vector=self.vector[columns] - cross @ carried[:, -1],
        )

    def considered(self, columns: IntArray, means: FloatArray, weights: FloatArray) -> "InformationPrior":
        """Return the prior if some unknowns, by their positions here, are known by their own priors only.

        Of these, ``means`` are the means and ``weights`` the inverse variances, shape (c,). The other unknowns, given
        them, are as before (consider parameters; Schmidt 1966).
        """
        rest = np.setdiff1d(np.arange(len(self.columns)), columns)
        inner = self.information[np.ix_(rest, rest)] + _TRACE * np.eye(len(rest))
        cross = self.information[np.ix_(columns, rest)]
        carried = solve(inner, np.column_stack([cross.T, self.vector[rest]]))
        information, vector = self.information.copy(), self.vector.copy()
        information[np.ix_(columns, columns)] = cross @ carried[:, :-1] + np.diag(weights)
        vector[columns] = cross @ carried[:, -1] + weights * means
        return InformationPrior(self.columns, information, vector)


def prior(columns: ArrayLike, *, sigma: ArrayLike, residual: ArrayLike) -> LinearFactor:
    """Return a prior factor with one row per unknown; ``residual`` is the prior mean minus the present value."""
    own = np.atleast_1d(np.asarray(columns, dtype=np.int64))
    weights = np.broadcast_to(np.asarray(sigma, dtype=np.float64) ** -2.0, own.shape)
    residuals = np.broadcast_to(np.asarray(residual, dtype=np.float64), own.shape)
    return LinearFactor(own[:, None], np.ones((len(own), 1)), residuals.copy(), weights.copy())


def normal_equations(parts: Sequence[LinearFactor], size: int) -> tuple[FloatArray, FloatArray]:
    """Return the normal equations of factors: ``J' W J``, shape (size, size), and ``J' W r``, shape (size,).

    Examples
    --------
    >>> normal_equations([prior(1, sigma=0.5, residual=3.0)], 2)[1]
    array([ 0., 12.])
    """
    information, vector = np.zeros((size, size)), np.zeros(size)
    for factor in parts:
        _sum_up(factor, information, vector)
    return information, vector


@compiled
def _sum_up(factor: LinearFactor, information: FloatArray, vector: FloatArray) -> None:
    for row in range(len(factor.residuals)):
        weight, columns, jacobian = factor.weights[row], factor.columns[row], factor.jacobian[row]
        for one, column in enumerate(columns):
            if column < 0:
                continue
            scaled = weight * jacobian[one]
            vector[column] += scaled * factor.residuals[row]
            for other, second in enumerate(columns):
                if second >= 0:
                    information[column, second] += scaled * jacobian[other]
