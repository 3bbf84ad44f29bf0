"""The solver: normal equations by dense or sparse factorisation, and solutions under constraints."""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError

__all__ = ["held", "solve"]

# With more unknowns than this most of the matrix is zero, and a sparse factorisation is faster.
_DENSE = 250


def solve(information: FloatArray, vectors: ArrayLike) -> FloatArray:
    """Solve normal equations with a symmetric positive definite matrix for right-hand sides of shape (n,) or (n, k).

    InvalidValueError is raised if an unknown is undetermined.

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
    except (LinAlgError, RuntimeError):  # SuperLU raises RuntimeError
        raise InvalidValueError("the observations leave an unknown undetermined") from None
    return solution


def held(step: FloatArray, columns: Sequence[FloatArray], changes: Mapping[int, float]) -> FloatArray:
    """Return the solution of normal equations under the constraint that some unknowns change by given amounts.

    ``step``, shape (n,), is the solution without constraints, ``columns`` are the columns of the covariance for these
    unknowns, and ``changes`` maps their positions to the amounts, in the same order.

    Examples
    --------
    >>> held(np.array([1.0, 3.0]), [np.array([2.0, 1.0])], {0: 0.0})
    array([0. , 2.5])
    """
    places, responses = list(changes), np.column_stack(columns)
    missing = np.array(list(changes.values())) - step[places]
    constrained: FloatArray = step + responses @ np.linalg.solve(responses[places], missing)
    return constrained
