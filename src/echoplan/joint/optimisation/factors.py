"""LinearFactor of a linearised least-squares problem: every observation, tie and prior is some of them."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.errors import InvalidValueError

__all__ = ["InformationPrior", "LinearFactor", "held", "normal_equations", "prior", "solve"]

# Systems of more unknowns than this are mostly empty, and are solved as such.
_DENSE = 250
# Information that holds what nothing is known of.
_TRACE = 1e-9


class LinearFactor(NamedTuple):
    """m linearised equations ``residual = slopes . step`` with at most k unknowns each.

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

    def on(self, columns: IntArray) -> "InformationPrior":
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
    """Sum rows up.

    Parameters
    ----------
    parts : sequence of LinearFactor
        All of them.
    size : int
        How many unknowns there are.

    Returns
    -------
    information : ndarray, shape (size, size)
        ``J' W J``.
    right : ndarray, shape (size,)
        ``J' W r``.

    Examples
    --------
    >>> normal_equations([prior(1, sigma=0.5, residual=3.0)], 2)[1]
    array([ 0., 12.])
    """
    information, right = np.zeros((size, size)), np.zeros(size)
    for rows in parts:
        _sum_up(rows, information, right)
    return information, right


def solve(information: FloatArray, right: ArrayLike) -> FloatArray:
    """Solve normal equations.

    Parameters
    ----------
    information : ndarray, shape (n, n)
        Symmetric and positive definite.
    right : array_like, shape (n,) or (n, k)
        Right-hand sides.

    Returns
    -------
    ndarray
        Solutions, of the same shape.

    Raises
    ------
    InvalidValueError
        If the rows leave an unknown undetermined.

    Examples
    --------
    >>> solve(np.diag([2.0, 4.0]), [2.0, 2.0])
    array([1. , 0.5])
    """
    from scipy.linalg import LinAlgError, cho_factor, cho_solve  # noqa: PLC0415 - SciPy is slow to import
    from scipy.sparse import csc_array  # noqa: PLC0415
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    measured_poses = np.asarray(right, dtype=np.float64)
    solution: FloatArray
    try:
        if len(information) > _DENSE:
            solution = splu(csc_array(information)).solve(measured_poses)
        else:
            solution = cho_solve(cho_factor(information), measured_poses)
    except (LinAlgError, RuntimeError):  # SuperLU says so by a RuntimeError
        raise InvalidValueError("the observations leave an unknown undetermined") from None
    return solution


def held(step: FloatArray, columns: Sequence[FloatArray], changes: Mapping[int, float]) -> FloatArray:
    """Let some unknowns change by so much and no other way: the others follow.

    Parameters
    ----------
    step : ndarray, shape (n,)
        Solution of normal equations.
    columns : sequence of ndarray, shape (n,)
        Columns of the covariance, of these unknowns.
    changes : mapping of int to float
        How much each of them is to change, by its place, in the same order.

    Returns
    -------
    ndarray, shape (n,)
        The solution under these constraints.

    Examples
    --------
    >>> held(np.array([1.0, 3.0]), [np.array([2.0, 1.0])], {0: 0.0})
    array([0. , 2.5])
    """
    places, responses = list(changes), np.column_stack(columns)
    missing = np.array(list(changes.values())) - step[places]
    constrained: FloatArray = step + responses @ np.linalg.solve(responses[places], missing)
    return constrained


@compiled
def _sum_up(rows: LinearFactor, information: FloatArray, right: FloatArray) -> None:
    for row in range(len(rows.residuals)):
        weight, columns, jacobian = rows.weights[row], rows.columns[row], rows.jacobian[row]
        for one, column in enumerate(columns):
            if column < 0:
                continue
            scaled = weight * jacobian[one]
            right[column] += scaled * rows.residuals[row]
            for other, second in enumerate(columns):
                if second >= 0:
                    information[column, second] += scaled * jacobian[other]
