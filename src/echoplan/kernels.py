"""Small functions for compiled code: NumPy has them, too, but Numba takes seconds to compile those.

Importing this module imports numba, which takes its time: import it where it is used.
"""

import math
from typing import TypeVar

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import inlined

__all__ = ["doubled", "log_gaussian", "median_of", "order_of", "solve_small", "sort"]

A = TypeVar("A", FloatArray, IntArray)
# Of the normal density.
_ROOT_TAU = math.sqrt(2.0 * math.pi)


@inlined
def sort(values: A) -> None:
    """Sort values in place (Shell 1959)."""
    gap = len(values) // 2
    while gap > 0:
        for end in range(gap, len(values)):
            value, place = values[end], end
            while place >= gap and values[place - gap] > value:
                values[place] = values[place - gap]
                place -= gap
            values[place] = value
        gap //= 2


@inlined
def order_of(keys: FloatArray) -> IntArray:
    """Return the positions that sort keys, in ascending order (Shell 1959)."""
    order = np.empty(len(keys), np.int64)
    for place in range(len(order)):
        order[place] = place
    gap = len(keys) // 2
    while gap > 0:
        for end in range(gap, len(order)):
            position, place = order[end], end
            while place >= gap and keys[order[place - gap]] > keys[position]:
                order[place] = order[place - gap]
                place -= gap
            order[place] = position
        gap //= 2
    return order


@inlined
def median_of(values: FloatArray) -> float:
    """Return the median of at least one value."""
    ordered, half = values.copy(), len(values) // 2
    sort(ordered)
    return float(ordered[half] if len(ordered) % 2 else (ordered[half - 1] + ordered[half]) / 2.0)


@inlined
def log_gaussian(probability: float, residual: float, sigma: float) -> float:
    """Return the logarithm of a probability times the normal density of a residual."""
    return math.log(probability / (_ROOT_TAU * sigma)) - 0.5 * (residual / sigma) ** 2


@inlined
def doubled(values: A) -> A:
    """Return an array of twice the length that begins with the given values; the rest is not set."""
    longer = np.empty(2 * len(values), values.dtype)
    for place in range(len(values)):
        longer[place] = values[place]
    return longer


@inlined
def solve_small(matrix: FloatArray, right: FloatArray) -> FloatArray:
    """Solve a small system with a symmetric positive definite matrix by elimination; both arguments are overwritten."""
    size = len(right)
    for column in range(size):
        for row in range(column + 1, size):
            factor = matrix[row, column] / matrix[column, column]
            for place in range(column, size):
                matrix[row, place] -= factor * matrix[column, place]
            right[row] -= factor * right[column]
    for row in range(size - 1, -1, -1):
        for place in range(row + 1, size):
            right[row] -= matrix[row, place] * right[place]
        right[row] /= matrix[row, row]
    return right
