"""Crossings of lines, and how they move with the lines."""

import math

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions

__all__ = ["crossing_slopes"]


def crossing_slopes(lines: FloatArray, crossing_xy: FloatArray) -> FloatArray:
    """Differentiate the crossing of two lines by their parameters: ``N dX = d(offset) - (t . X) d(angle)``.

    Parameters
    ----------
    lines : ndarray, shape (2, 2)
        Normal angle and offset of both [rad, m].
    crossing_xy : ndarray, shape (2,)
        Where they cross [m].

    Returns
    -------
    ndarray, shape (2, 4)
        Derivatives of x and y by both parameters of the first line, and of the second.

    Examples
    --------
    >>> crossing_slopes(np.array([[0.0, 2.0], [np.pi / 2, 1.0]]), np.array([2.0, 1.0])).round(6) + 0.0
    array([[-1.,  1.,  0.,  0.],
           [ 0.,  0.,  2.,  1.]])
    """
    inverse = np.linalg.inv(directions(lines[:, 0]))
    along = directions(lines[:, 0] + math.pi / 2) @ crossing_xy
    return np.column_stack([-along[0] * inverse[:, 0], inverse[:, 0], -along[1] * inverse[:, 1], inverse[:, 1]])
