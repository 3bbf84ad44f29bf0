"""Linear factors of measurements, constraints and priors, their normal equations, and marginal priors of past ones."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.optimisation.solver import solve

__all__ = ["InformationPrior", "LinearFactor", "normal_equations", "prior"]

# Information that holds what nothing is known of.
_TRACE = 1e-9


class LinearFactor(NamedTuple):
    """m linearised equations ``residual = jacobian . step`` with at most k unknowns each.

    Attributes
    ----------
    columns : ndarray of int, shape (m, k)
        Which unknowns; -1 fills up.
    jacobian : ndarray, shape (m, k)
        Derivatives of what is predicted by them.
    residuals : ndarray, shape (m,)
        What was observed less what is predicted.
    weights : ndarray, shape (m,)
        Reciprocals of the variances.
    """

    columns: IntArray
    jacobian: FloatArray
    residuals: FloatArray
    weights: FloatArray


class InformationPrior(NamedTuple):
    """What many rows that are gone said of k unknowns, linearised where these were then.

    Attributes
    ----------
    columns : ndarray of int, shape (k,)
        Which unknowns.
    information : ndarray, shape (k, k)
        ``J' W J``, with all other unknowns eliminated.
    vector : ndarray, shape (k,)
        ``J' W J x + J' W r``: what the normal equations of the values themselves have on the right.
    """

    columns: IntArray
    information: FloatArray
    vector: FloatArray

    def marginalised_onto(self, columns: IntArray) -> "InformationPrior":
        """Keep some unknowns, and eliminate the others (Schur complement).

        Parameters
        ----------
        columns : ndarray of int, shape (m,)
            Which to keep, by their places here.

        Returns
        -------
        InformationPrior
            What the rows said of these, whatever the others are.
        """
        gone = np.setdiff1d(np.arange(len(self.columns)), columns)
        if not len(gone):
            return self
        # A little information more: what was never heard would make the matrix singular.
        inner = self.information[np.ix_(gone, gone)] + _TRACE * np.eye(len(gone))
        cross = self.information[np.ix_(columns, gone)]
        carried = solve(inner, np.column_stack([cross.T, self.vector[gone]]))
        information = self.information[np.ix_(columns, columns)] - cross @ carried[:, :-1]
        return InformationPrior(
            columns=self.columns[columns],
            information=0.5 * (information + information.T),
            vector=self.vector[columns] - cross @ carried[:, -1],
        )


def prior(columns: ArrayLike, *, sigma: ArrayLike, residual: ArrayLike) -> LinearFactor:
    """Hold unknowns near values.

    Parameters
    ----------
    columns : int or ndarray of int, shape (k,)
        The unknowns.
    sigma : float or ndarray, shape (k,)
        Standard deviations about the values.
    residual : float or ndarray, shape (k,)
        The values less the present ones.

    Returns
    -------
    LinearFactor
        One an unknown.
    """
    own = np.atleast_1d(np.asarray(columns, dtype=np.int64))
    weights = np.broadcast_to(np.asarray(sigma, dtype=np.float64) ** -2.0, own.shape)
    residuals = np.broadcast_to(np.asarray(residual, dtype=np.float64), own.shape)
    return LinearFactor(own[:, None], np.ones((len(own), 1)), residuals.copy(), weights.copy())


def normal_equations(parts: Sequence[LinearFactor], size: int) -> tuple[FloatArray, FloatArray]:
    """Sum factors to normal equations.

    Parameters
    ----------
    parts : sequence of LinearFactor
        The factors.
    size : int
        How many unknowns there are.

    Returns
    -------
    information : ndarray, shape (size, size)
        ``J' W J``.
    vector : ndarray, shape (size,)
        ``J' W r``.

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
