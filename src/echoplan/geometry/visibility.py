"""Sight lines between points among segments and discs: who hides whom.

Segments are arrays of shape (m, 2, 2): item, start or end, x or y.  Discs are (k, 3): x, y, radius.
"""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry.angles import directions
from echoplan.geometry.lines import lines_through, signed_distances

__all__ = ["crosses_discs", "crosses_segments", "distances_to_segments", "is_blocked", "outward_normals"]


def crosses_segments(origins_xy: ArrayLike, targets_xy: ArrayLike, segments_xy: ArrayLike) -> BoolArray:
    """Return a mask of the sight lines that cross segments in a point inside both.

    Parameters
    ----------
    origins_xy, targets_xy : array_like, shape (n, 2)
        Ends of the sight lines [m].
    segments_xy : array_like, shape (m, 2, 2)
        Segments [m].

    Returns
    -------
    ndarray of bool, shape (n, m)
        True where the open sight line meets the closed segment; a common line is no crossing.

    Examples
    --------
    >>> crosses_segments([[0, 0]], [[2, 0]], [[[1, -1], [1, 1]], [[3, -1], [3, 1]]])
    array([[ True, False]])
    """
    origins = np.asarray(origins_xy, dtype=np.float64)[:, None]
    rays = np.asarray(targets_xy, dtype=np.float64)[:, None] - origins
    segments = np.asarray(segments_xy, dtype=np.float64).reshape(-1, 2, 2)
    starts = segments[None, :, 0]
    spans = segments[None, :, 1] - starts
    turn = _cross(rays, spans)
    parallel = turn == 0
    safe = np.where(parallel, 1.0, turn)
    on_ray = _cross(starts - origins, spans) / safe
    on_segment = _cross(starts - origins, rays) / safe
    met: BoolArray = (on_ray > 0) & (on_ray < 1) & (on_segment >= 0) & (on_segment <= 1) & ~parallel
    return met


def crosses_discs(origins_xy: ArrayLike, targets_xy: ArrayLike, discs: ArrayLike) -> BoolArray:
    """Return a mask of the sight lines that pass through discs.

    Parameters
    ----------
    origins_xy, targets_xy : array_like, shape (n, 2)
        Ends of the sight lines [m].
    discs : array_like, shape (k, 3)
        ``(x, y, radius)`` of each disc [m].

    Returns
    -------
    ndarray of bool, shape (n, k)
        True where a point of the sight line lies nearer to the centre than the radius.

    Examples
    --------
    >>> crosses_discs([[0, 0]], [[2, 0]], [[1, 0.1, 0.2], [1, 0.5, 0.2]])
    array([[ True, False]])
    """
    discs = np.asarray(discs, dtype=np.float64).reshape(-1, 3)
    segments = np.stack([np.asarray(origins_xy), np.asarray(targets_xy)], axis=1)
    distances = distances_to_segments(discs[:, :2], segments).T
    near: BoolArray = distances < discs[None, :, 2]
    return near


def distances_to_segments(points_xy: ArrayLike, segments_xy: ArrayLike) -> FloatArray:
    """Distance of every point from every segment.

    Parameters
    ----------
    points_xy : array_like, shape (n, 2)
        Points [m].
    segments_xy : array_like, shape (m, 2, 2)
        Segments [m]; one of no length is a point.

    Returns
    -------
    ndarray of float64, shape (n, m)
        Distances [m].

    Examples
    --------
    >>> distances_to_segments([[3.0, 4.0]], [[[0, 0], [0, 1]], [[0, 0], [9, 0]]]).round(3)
    array([[4.243, 4.   ]])
    """
    points = np.asarray(points_xy, dtype=np.float64)[:, None]
    segments = np.asarray(segments_xy, dtype=np.float64).reshape(-1, 2, 2)
    starts = segments[None, :, 0]
    spans = segments[None, :, 1] - starts
    squares = np.sum(spans**2, axis=-1)
    shares = np.sum((points - starts) * spans, axis=-1) / np.where(squares == 0, 1.0, squares)
    nearest = starts + np.clip(shares, 0.0, 1.0)[..., None] * spans
    distances: FloatArray = np.hypot(*np.moveaxis(points - nearest, -1, 0))
    return distances


def is_blocked(origins_xy: ArrayLike, targets_xy: ArrayLike, *, segments_xy: ArrayLike, discs: ArrayLike) -> BoolArray:
    """Return a mask of the sight lines that are blocked.

    Parameters
    ----------
    origins_xy, targets_xy : array_like, shape (n, 2)
        Ends of the sight lines [m].
    segments_xy : array_like, shape (m, 2, 2)
        Segments that hide what lies behind them [m].
    discs : array_like, shape (k, 3)
        Discs ``(x, y, radius)`` likewise [m].

    Returns
    -------
    ndarray of bool, shape (n,)
        True where the line of sight is cut.

    Examples
    --------
    >>> is_blocked([[0, 0]], [[2, 0]], segments_xy=[[[1, -1], [1, 1]]], discs=[])
    array([ True])
    """
    by_segment = np.any(crosses_segments(origins_xy, targets_xy, segments_xy), axis=1)
    blocked: BoolArray = by_segment | np.any(crosses_discs(origins_xy, targets_xy, discs), axis=1)
    return blocked


def outward_normals(faces_xy: ArrayLike, stations_xy: ArrayLike, *, normals_xy: ArrayLike) -> FloatArray:
    """Find the side of faces that is away from the stations that detected them.

    Stations opposite to a face detected it, unless another face is between: a box is detected from all around.  If
    these disagree or there are none, all stations opposite to the face decide, then all stations.

    Parameters
    ----------
    faces_xy : array_like, shape (w, 2, 2)
        Starts and ends of the faces [m].
    stations_xy : array_like, shape (s, 2)
        Positions from which they were detected [m].
    normals_xy : array_like, shape (w, 2)
        The normals to return, but for their lengths, where no station decides.

    Returns
    -------
    ndarray of float64, shape (w, 2)
        Unit normals that point away from the stations.

    Examples
    --------
    >>> outward_normals([[[0, 0], [4, 0]]], [[1, 2]], normals_xy=[[0, 1]]).round(9) + 0.0
    array([[ 0., -1.]])
    """
    faces = np.asarray(faces_xy, dtype=np.float64).reshape(-1, 2, 2)
    stations = np.asarray(stations_xy, dtype=np.float64).reshape(-1, 2)
    lines = lines_through(faces[:, 0], faces[:, 1])
    normals = directions(lines[:, 0])
    sides = np.ones(len(faces))
    for number, (face, line) in enumerate(zip(faces, lines, strict=True)):
        inside = -np.sign(signed_distances(line, stations))
        start, way = face[0], face[1] - face[0]
        shares = (stations - start) @ way / (way @ way)
        is_opposite = (shares > 0) & (shares < 1)
        others = np.delete(faces, number, axis=0)
        is_hidden = crosses_segments(stations, start + shares[:, None] * way, others).any(axis=1)
        votes = [float(inside[each].sum()) for each in (is_opposite & ~is_hidden, is_opposite, slice(None))]
        votes.append(float(normals[number] @ np.asarray(normals_xy)[number]))
        sides[number] = 1.0 if next((vote for vote in votes if vote), 0.0) >= 0 else -1.0
    return sides[:, None] * normals


def _cross(a: FloatArray, b: FloatArray) -> FloatArray:
    product: FloatArray = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return product
