"""Angles on the circle, in radians, counter-clockwise from +x (REP 103)."""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray

__all__ = ["circular_mean", "directions", "rotation_step", "wrap"]


def wrap(angles: ArrayLike) -> FloatArray:
    """Wrap angles into [-pi, pi).

    Parameters
    ----------
    angles : array_like
        Angles [rad], any shape.

    Returns
    -------
    ndarray of float64
        The same directions in [-pi, pi) [rad], same shape.

    Examples
    --------
    >>> float(wrap(1.5 * np.pi)) == -0.5 * np.pi
    True
    """
    wrapped: FloatArray = (np.asarray(angles, dtype=np.float64) + np.pi) % (2 * np.pi) - np.pi
    # Just below -pi the remainder rounds up to a whole turn.
    return wrapped - 2 * np.pi * (wrapped >= np.pi)


def circular_mean(angles: ArrayLike) -> float:
    """Mean direction: the angle of the sum of unit vectors.

    Parameters
    ----------
    angles : array_like, shape (n,)
        Angles [rad].

    Returns
    -------
    float
        Mean direction in [-pi, pi) [rad].

    Examples
    --------
    >>> round(circular_mean([np.pi - 0.1, -np.pi + 0.3]), 6) == round(-np.pi + 0.1, 6)
    True
    """
    angles = np.asarray(angles, dtype=np.float64)
    return float(wrap(np.arctan2(np.sin(angles).sum(), np.cos(angles).sum())))


def directions(angles: ArrayLike) -> FloatArray:
    """Turn angles into unit vectors.

    Parameters
    ----------
    angles : array_like, shape (...,)
        Angles [rad].

    Returns
    -------
    ndarray of float64, shape (..., 2)
        ``(cos, sin)`` of each.

    Examples
    --------
    >>> directions(0.0)
    array([1., 0.])
    """
    angles = np.asarray(angles, dtype=np.float64)
    vectors = np.empty((*angles.shape, 2))
    np.cos(angles, out=vectors[..., 0])
    np.sin(angles, out=vectors[..., 1])
    return vectors


def rotation_step(bearings: FloatArray) -> float:
    """Return the usual turn from one ping to the next around the circle.

    Parameters
    ----------
    bearings : ndarray, shape (n,)
        Directions of the beam axes of one sweep [rad], at least one.

    Returns
    -------
    float
        Median gap between neighbouring directions that differ [rad]; a full turn for one direction.

    Examples
    --------
    >>> round(float(np.degrees(rotation_step(np.radians([0.0, 1, 2, 2, 5, 6])))), 6)
    1.0
    """
    around = np.sort(np.mod(bearings, 2 * np.pi))
    gaps = np.diff(around, append=around[0] + 2 * np.pi)
    return float(np.median(gaps[gaps > 1e-6]))
