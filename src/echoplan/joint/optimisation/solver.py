"""The solver: normal equations by a dense or a sparse factorisation, and solutions under constraints."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError

__all__ = ["held", "solve"]

# Systems of more unknowns than this are mostly empty, and a sparse factorisation is faster.
_DENSE = 250


def solve(information: FloatArray, vectors: ArrayLike) -> FloatArray:
    """Solve normal equations.

    Parameters
    ----------
    information : ndarray, shape (n, n)
        Symmetric and positive definite.
    vectors : array_like, shape (n,) or (n, k)
        Right-hand sides.

    Returns
    -------
    ndarray
        Solutions, of the same shape.

    Raises
    ------
    InvalidValueError
        If the factors leave an unknown undetermined.

    Examples
    --------
    >>> solve(np.diag([2.0, 4.0]), [2.0, 2.0])
    array([1. , 0.5])
    """
    from scipy.linalg import LinAlgError, cho_factor, cho_solve  # noqa: PLC0415 - SciPy is slow to import
    from scipy.sparse import csc_array  # noqa: PLC0415
    from scipy.sparse.linalg import splu  # noqa: PLC0415

    right = np.asarray(vectors, dtype=np.float64)
    solution: FloatArray
    try:
        if len(information) > _DENSE:
            solution = splu(csc_array(information)).solve(right)
        else:
            solution = cho_solve(cho_factor(information), right)
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
