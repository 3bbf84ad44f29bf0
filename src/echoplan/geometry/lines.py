"""Straight lines in Hesse normal form: ``n . p = offset`` with ``n = (cos, sin)`` of ``normal_angle``.

A line is an array ``(normal_angle, offset)`` in radians and metres; leading axes are items.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.geometry.angles import directions

__all__ = ["PARALLEL", "along", "feet", "intersections", "lines_through", "path_crossings", "signed_distances"]

# Lines whose normals differ by less than this sine are parallel: rounding alone would place their crossing.
PARALLEL = 1e-9


def lines_through(starts_xy: ArrayLike, ends_xy: ArrayLike) -> FloatArray:
    """Lines through pairs of points, the normal to the right of the way from start to end.

    Parameters
    ----------
    starts_xy, ends_xy : array_like, shape (..., 2)
        Two points on each line [m].

    Returns
    -------
    ndarray of float64, shape (..., 2)
        ``(normal_angle, offset)`` [rad, m].

    Examples
    --------
    >>> lines_through([0.0, 2.0], [1.0, 2.0]).round(6)
    array([-1.570796, -2.      ])
    """
    starts = np.asarray(starts_xy, dtype=np.float64)
    along_xy = np.asarray(ends_xy, dtype=np.float64) - starts
    angles = np.arctan2(-along_xy[..., 0], along_xy[..., 1])
    offsets = np.sum(directions(angles) * starts, axis=-1)
    return np.stack([angles, offsets], axis=-1)


def signed_distances(lines: ArrayLike, points_xy: ArrayLike) -> FloatArray:
    """Distance of points from lines, positive on the side to which the normal points.

    Parameters
    ----------
    lines : array_like, shape (..., 2)
        ``(normal_angle, offset)`` [rad, m].
    points_xy : array_like, shape (..., 2)
        Points [m]; leading axes broadcast against the lines.

    Returns
    -------
    ndarray of float64, shape (...)
        ``n . p - offset`` [m].

    Examples
    --------
    >>> float(signed_distances([0.0, 2.0], [3.0, 7.0]))
    1.0
    """
    lines = np.asarray(lines, dtype=np.float64)
    distances: FloatArray = np.sum(directions(lines[..., 0]) * np.asarray(points_xy), axis=-1) - lines[..., 1]
    return distances


def along(lines: ArrayLike, points_xy: ArrayLike) -> FloatArray:
    """Coordinate of points along lines, counted from the foot of the origin.

    Parameters
    ----------
    lines : array_like, shape (..., 2)
        ``(normal_angle, offset)`` [rad, m].
    points_xy : array_like, shape (..., 2)
        Points [m]; leading axes broadcast against the lines.

    Returns
    -------
    ndarray of float64, shape (...)
        ``t . p`` with t a quarter turn counter-clockwise of the normal [m].

    Examples
    --------
    >>> float(along([0.0, 2.0], [3.0, 7.0]))
    7.0
    """
    normals = directions(np.asarray(lines, dtype=np.float64)[..., 0])
    points = np.asarray(points_xy, dtype=np.float64)
    coordinates: FloatArray = normals[..., 0] * points[..., 1] - normals[..., 1] * points[..., 0]
    return coordinates


def feet(lines: ArrayLike, points_xy: ArrayLike) -> FloatArray:
    """Nearest points of lines: the feet of the perpendiculars.

    Parameters
    ----------
    lines : array_like, shape (..., 2)
        ``(normal_angle, offset)`` [rad, m].
    points_xy : array_like, shape (..., 2)
        Points [m]; leading axes broadcast against the lines.

    Returns
    -------
    ndarray of float64, shape (..., 2)
        The feet [m].

    Examples
    --------
    >>> feet([0.0, 2.0], [3.0, 7.0])
    array([2., 7.])
    """
    lines = np.asarray(lines, dtype=np.float64)
    points = np.asarray(points_xy, dtype=np.float64)
    nearest: FloatArray = points - signed_distances(lines, points)[..., None] * directions(lines[..., 0])
    return nearest


def intersections(first: ArrayLike, second: ArrayLike) -> FloatArray:
    """Points in which pairs of lines cross.

    Parameters
    ----------
    first, second : array_like, shape (..., 2)
        Lines ``(normal_angle, offset)`` [rad, m]; leading axes broadcast.

    Returns
    -------
    ndarray of float64, shape (..., 2)
        Crossings [m]; nan where two lines are parallel.

    Examples
    --------
    >>> intersections([0.0, 2.0], [np.pi / 2, 3.0]).round(6)
    array([2., 3.])
    """
    first = np.asarray(first, dtype=np.float64)
    second = np.asarray(second, dtype=np.float64)
    sines = np.sin(second[..., 0] - first[..., 0])
    sines = np.where(np.abs(sines) < PARALLEL, np.nan, sines)
    n, m = directions(first[..., 0]), directions(second[..., 0])
    p, q = first[..., 1], second[..., 1]
    x = (p * m[..., 1] - q * n[..., 1]) / sines
    y = (q * n[..., 0] - p * m[..., 0]) / sines
    return np.stack([x, y], axis=-1)


def path_crossings(line: FloatArray, path_xy: FloatArray) -> FloatArray:
    """Places along a line where a path crosses it.

    Parameters
    ----------
    line : ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m].
    path_xy : ndarray, shape (p, 2)
        Points of the path, straight from each to the next [m]; a row of NaN interrupts it.

    Returns
    -------
    ndarray, shape (k,)
        Coordinates as of ``along`` [m], in the order of the path.

    Examples
    --------
    >>> path_crossings(np.array([0.0, 2.0]), np.array([[1.0, 0.0], [3.0, 1.0], [3.0, 5.0]]))
    array([0.5])
    """
    depths, places = line[1] - path_xy @ directions(line[0]), path_xy @ directions(line[0] + math.pi / 2)
    crossed = (depths[:-1] > 0.0) != (depths[1:] > 0.0)
    before, after = depths[:-1][crossed], depths[1:][crossed]
    crossings: FloatArray = places[:-1][crossed] + np.diff(places)[crossed] * before / (before - after)
    return crossings[np.isfinite(crossings)]
