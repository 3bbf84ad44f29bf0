"""Rays through the cells of a grid: they end where the first blocked cell begins."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.compiled import compiled, inlined

__all__ = ["Fans", "cells_on_segments", "fans_of", "join_fans", "rays_per_cell"]


class Fans(NamedTuple):
    """Sectors of n circles.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Centres [m].
    bearings : ndarray, shape (n,)
        Directions of their middle [rad].
    half_angles : ndarray, shape (n,)
        Half the opening [rad]; 0 for a single ray, pi for a full circle.
    reaches : ndarray, shape (n,)
        Radii [m].
    horizons : ndarray, shape (n,)
        Length within which a ray must meet a blocked cell, or it does not count [m]; 0 if it need not.
    """

    x: FloatArray
    y: FloatArray
    bearings: FloatArray
    half_angles: FloatArray
    reaches: FloatArray
    horizons: FloatArray


def fans_of(
    centers_xy: ArrayLike,
    *,
    reaches: ArrayLike,
    bearings: ArrayLike = 0.0,
    half_angles: ArrayLike = math.pi,
    horizons: ArrayLike = 0.0,
) -> Fans:
    """Make sectors about centres, shape (n, 2) [m]; the other arguments broadcast to shape (n,)."""
    x, y = np.reshape(np.asarray(centers_xy, dtype=np.float64), (-1, 2)).T
    columns = np.broadcast_arrays(x, y, bearings, half_angles, reaches, horizons)
    return Fans(*(np.array(column, dtype=np.float64, order="C") for column in columns))


def join_fans(parts: list[Fans]) -> Fans:
    """Put sectors together, in order; of an empty list, none."""
    fields = zip(*parts, strict=True) if parts else ((),) * len(Fans._fields)
    return Fans(*(np.concatenate([np.zeros(0), *arrays]) for arrays in fields))


def cells_on_segments(segments: ArrayLike, *, shape: tuple[int, int]) -> BoolArray:
    """Mark the cells that segments touch.

    Consecutive cells of a segment share a side.  A ray, whose cells do so too, cannot pass between them.

    Parameters
    ----------
    segments : array_like, shape (m, 2, 2)
        Start and end, x before y, in cells from the lower left corner of the grid.
    shape : tuple of int
        Rows and columns of the grid.

    Returns
    -------
    ndarray of bool, shape (rows, columns)
        True where a segment touches a cell.
    """
    ends = np.asarray(segments, dtype=np.float64).reshape(-1, 2, 2)
    spans = ends[:, 1] - ends[:, 0]
    bearings, lengths = np.arctan2(spans[:, 1], spans[:, 0]), np.hypot(*spans.T)
    lines = fans_of(ends[:, 0], bearings=bearings, half_angles=0.0, reaches=lengths)
    return rays_per_cell(lines, np.zeros(shape, dtype=np.bool_)) > 0


def rays_per_cell(fans: Fans, blocked: BoolArray) -> IntArray:
    """Count the sectors that reach each cell before a blocked cell.

    Parameters
    ----------
    fans : Fans
        Sectors, in cells from the lower left corner of the grid.
    blocked : ndarray of bool, shape (rows, columns)
        Cells at which rays end.

    Returns
    -------
    ndarray of int, shape (rows, columns)
        Number of sectors with a ray through the cell; 0 in blocked cells.
    """
    counts, latest = np.zeros(blocked.shape, dtype=np.int64), np.full(blocked.shape, -1, dtype=np.int64)
    _count_fans(*fans, np.ascontiguousarray(blocked), counts, latest)
    return counts


@compiled
def _count_fans(
    x: FloatArray,
    y: FloatArray,
    bearings: FloatArray,
    half_angles: FloatArray,
    reaches: FloatArray,
    horizons: FloatArray,
    blocked: BoolArray,
    counts: IntArray,
    latest: IntArray,
) -> None:
    for fan in range(len(x)):
        # At most one cell apart at their far ends, so that no cell lies between two rays.
        steps = math.ceil(2.0 * half_angles[fan] * reaches[fan])
        for step in range(steps + 1):
            angle = bearings[fan] + half_angles[fan] * (2.0 * step / steps - 1.0 if steps > 0 else 0.0)
            ux, uy = math.cos(angle), math.sin(angle)
            horizon = horizons[fan]
            if horizon <= 0.0 or _cast(x[fan], y[fan], ux, uy, horizon, blocked, counts, latest, -1):
                _cast(x[fan], y[fan], ux, uy, reaches[fan], blocked, counts, latest, fan)


@inlined
def _cast(
    x: float,
    y: float,
    ux: float,
    uy: float,
    reach: float,
    blocked: BoolArray,
    counts: IntArray,
    latest: IntArray,
    fan: int,
) -> bool:
    """Count a sector in the cells of one ray, unless its number is -1; return whether the ray ends at a blocked cell.

    The traversal of Amanatides and Woo (1987): from cell to cell through the side that is crossed first.
    """
    rows, columns = blocked.shape
    row, column = math.floor(y), math.floor(x)
    along_x, next_x, step_x = _sides(x, ux)
    along_y, next_y, step_y = _sides(y, uy)
    while 0 <= row < rows and 0 <= column < columns:
        if blocked[row, column]:
            return True
        if fan >= 0 and latest[row, column] != fan:
            latest[row, column] = fan
            counts[row, column] += 1
        if min(next_x, next_y) > reach:
            return False
        if next_x < next_y:
            column += along_x
            next_x += step_x
        else:
            row += along_y
            next_y += step_y
    return False


@inlined
def _sides(start: float, direction: float) -> tuple[int, float, float]:
    """Return the step along an axis from cell to cell, and the lengths of the ray at the next side and between sides.

    The lengths are infinite for a ray that is parallel to the sides.
    """
    length = abs(1.0 / direction)
    if direction > 0.0:
        return 1, (math.floor(start) + 1 - start) * length, length
    if direction < 0.0:
        return -1, (start - math.floor(start)) * length, length
    return 0, math.inf, math.inf
