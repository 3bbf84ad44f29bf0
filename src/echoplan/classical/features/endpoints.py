"""Iterative end-point fit: chains of points split where they are farthest from the chord (Ramer 1972)."""

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import distances_to_segments

__all__ = ["split_at_farthest", "split_at_steps"]


def split_at_steps(points_xy: FloatArray, *, max_step: float) -> list[IntArray]:
    """Split a chain of points where two neighbours are far apart.

    Parameters
    ----------
    points_xy : ndarray, shape (n, 2)
        Points in their order [m].
    max_step : float
        Greatest distance between neighbours [m].

    Returns
    -------
    list of ndarray of int
        Indices of each piece.

    Examples
    --------
    >>> points = np.array([[0.0, 0.0], [0.1, 0.0], [2.0, 0.0]])
    >>> [piece.tolist() for piece in split_at_steps(points, max_step=0.3)]
    [[0, 1], [2]]
    """
    steps = np.hypot(*np.diff(points_xy, axis=0).T)
    return np.split(np.arange(len(points_xy)), np.flatnonzero(steps > max_step) + 1) if len(points_xy) else []


def split_at_farthest(points_xy: FloatArray, *, tolerance: float) -> list[IntArray]:
    """Split a chain of points at the one that is farthest from the chord, and its parts likewise.

    Parameters
    ----------
    points_xy : ndarray, shape (n, 2)
        Points in their order, at least one [m].
    tolerance : float
        Greatest distance of a point from the chord of its piece [m].

    Returns
    -------
    list of ndarray of int
        Indices of each piece, in order; neighbouring pieces share the point at which they were split.

    Examples
    --------
    >>> bent = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [2.0, 2.0]])
    >>> [piece.tolist() for piece in split_at_farthest(bent, tolerance=0.1)]
    [[0, 1, 2], [2, 3, 4]]
    """
    pieces, waiting = [], [np.arange(len(points_xy))]
    while waiting:
        piece = waiting.pop()
        chord = points_xy[piece[[0, -1]]]
        distances = distances_to_segments(points_xy[piece], chord[None])[:, 0]
        farthest = int(np.argmax(distances))
        if distances[farthest] <= tolerance:
            pieces.append(piece)
        else:
            waiting += [piece[farthest:], piece[: farthest + 1]]
    return pieces
