"""Sectors of circles on a raster: which cells have their centre in the cone of a ping."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.grids.cones import Cones
from echoplan.compiled import compiled, inlined

__all__ = [
    "Raster",
    "Sector",
    "Trace",
    "box_about",
    "chord_of",
    "columns_of",
    "rows_of",
    "sector_of",
    "trace_for",
    "trace_sector",
]


class Raster(NamedTuple):
    """Where the cells of an array lie.

    Attributes
    ----------
    x, y : float
        Lower left corner of the cell of row 0 and column 0 [m].
    resolution : float
        Side of a cell [m].
    rows, columns : int
        How many cells there are.
    """

    x: float
    y: float
    resolution: float
    rows: int
    columns: int


class Sector(NamedTuple):
    """A sector of a circle, half a circle at most.

    Attributes
    ----------
    x, y : float
        Its centre [m].
    left_x, left_y, right_x, right_y : float
        Unit vectors of its edges: counter-clockwise from the right one to the left one.
    radius : float
        Its radius [m].
    """

    x: float
    y: float
    left_x: float
    left_y: float
    right_x: float
    right_y: float
    radius: float


class Trace(NamedTuple):
    """Room for the cells of one sector.

    Attributes
    ----------
    rows, columns : ndarray of int, shape (m,)
        The cells.
    distances : ndarray, shape (m,)
        Of their centres from the centre of the sector [m].
    turns : ndarray, shape (m,)
        Angles between their centres and the axis, as a share of half the aperture: 0 on the axis, 1 on an edge.
    """

    rows: IntArray
    columns: IntArray
    distances: FloatArray
    turns: FloatArray


def trace_for(cones: Cones, radii: FloatArray, resolution: float) -> Trace:
    """Make room for the largest of sectors.

    A convex set holds at most A + P / 2 + 1 points of the unit lattice (Nosarzewska 1948), with its area A and its
    perimeter P.

    Parameters
    ----------
    cones : Cones
        n cones.
    radii : ndarray, shape (n,)
        Where each is cut off [m].
    resolution : float
        Side of a cell [m].

    Returns
    -------
    Trace
        Empty.
    """
    steps = np.maximum(radii, 0.0) / resolution
    most = int((cones.half_apertures * steps**2 + (1.0 + cones.half_apertures) * steps).max(initial=0.0)) + 2
    cells = np.zeros((2, most), dtype=np.int64)
    return Trace(rows=cells[0], columns=cells[1], distances=np.zeros(most), turns=np.zeros(most))


@inlined
def sector_of(cones: Cones, ping: int, radius: float) -> Sector:
    """Cut the cone of a ping off at a radius."""
    cosine, sine = math.cos(cones.half_apertures[ping]), math.sin(cones.half_apertures[ping])
    ux, uy = cones.ux[ping], cones.uy[ping]
    return Sector(
        cones.x[ping],
        cones.y[ping],
        ux * cosine - uy * sine,
        uy * cosine + ux * sine,
        ux * cosine + uy * sine,
        uy * cosine - ux * sine,
        radius,
    )


@inlined
def heights_of(sector: Sector) -> tuple[float, float]:
    """Find how far a sector goes down and up from its centre [m]."""
    faces_up = sector.right_x >= 0.0 >= sector.left_x
    faces_down = sector.right_x <= 0.0 <= sector.left_x
    high = 1.0 if faces_up else max(sector.left_y, sector.right_y, 0.0)
    low = -1.0 if faces_down else min(sector.left_y, sector.right_y, 0.0)
    return sector.radius * low, sector.radius * high


@inlined
def widths_of(sector: Sector) -> tuple[float, float]:
    """Find how far a sector goes to the left and to the right from its centre [m]."""
    faces_right = sector.right_y <= 0.0 <= sector.left_y
    faces_left = sector.right_y >= 0.0 >= sector.left_y
    high = 1.0 if faces_right else max(sector.left_x, sector.right_x, 0.0)
    low = -1.0 if faces_left else min(sector.left_x, sector.right_x, 0.0)
    return sector.radius * low, sector.radius * high


@compiled
def box_about(cones: Cones, radii: FloatArray) -> FloatArray:
    """Find the upright box about cones: lower left and upper right corner [m], infinite if there is none."""
    low_x = low_y = math.inf
    high_x = high_y = -math.inf
    for ping in range(len(radii)):
        sector = sector_of(cones, ping, max(radii[ping], 0.0))
        left, right = widths_of(sector)
        down, up = heights_of(sector)
        low_x, low_y = min(low_x, sector.x + left), min(low_y, sector.y + down)
        high_x, high_y = max(high_x, sector.x + right), max(high_y, sector.y + up)
    return np.array([[low_x, low_y], [high_x, high_y]])


@inlined
def rows_of(sector: Sector, raster: Raster) -> tuple[int, int]:
    """Find the first row that has a centre within a sector's height, and the one after the last."""
    low, high = heights_of(sector)
    start = (sector.y - raster.y) / raster.resolution - 0.5
    first, last = math.ceil(start + low / raster.resolution), math.floor(start + high / raster.resolution)
    return max(first, 0), min(last + 1, raster.rows)


@inlined
def columns_of(sector: Sector, raster: Raster, row: int) -> tuple[int, int]:
    """Find the first column of a row that has its centre in a sector, and the one after the last."""
    up = raster.y + (row + 0.5) * raster.resolution - sector.y
    half = math.sqrt(max(sector.radius**2 - up**2, 0.0))
    low, high = -half, half
    # Left of the right edge: right_y x <= right_x y; right of the left edge: left_y x >= left_x y.
    if sector.right_y > 0.0:
        high = min(high, sector.right_x * up / sector.right_y)
    elif sector.right_y < 0.0:
        low = max(low, sector.right_x * up / sector.right_y)
    if sector.left_y > 0.0:
        low = max(low, sector.left_x * up / sector.left_y)
    elif sector.left_y < 0.0:
        high = min(high, sector.left_x * up / sector.left_y)
    start = (sector.x - raster.x) / raster.resolution - 0.5
    first, last = math.ceil(start + low / raster.resolution), math.floor(start + high / raster.resolution)
    return max(first, 0), min(last + 1, raster.columns)


@inlined
def chord_of(sector: Sector, raster: Raster, row: int, radius: float) -> tuple[int, int]:
    """Find the first column of a row that has its centre in a circle about a sector's centre, and the one after."""
    up = raster.y + (row + 0.5) * raster.resolution - sector.y
    start = (sector.x - raster.x) / raster.resolution - 0.5
    if abs(up) > radius:
        return 0, 0
    half = math.sqrt(radius**2 - up**2) / raster.resolution
    return max(math.ceil(start - half), 0), min(math.floor(start + half) + 1, raster.columns)


@inlined
def trace_sector(trace: Trace, raster: Raster, cones: Cones, ping: int, radius: float) -> int:
    """Write down the cells in the cone of a ping up to a radius, row by row, and return how many they are."""
    sector = sector_of(cones, ping, radius)
    ux, uy = cones.ux[ping], cones.uy[ping]
    count = 0
    first_row, end_row = rows_of(sector, raster)
    for row in range(first_row, end_row):
        up = raster.y + (row + 0.5) * raster.resolution - sector.y
        first, end = columns_of(sector, raster, row)
        for column in range(first, end):
            along = raster.x + (column + 0.5) * raster.resolution - sector.x
            trace.rows[count] = row
            trace.columns[count] = column
            trace.distances[count] = math.hypot(along, up)
            turn = math.atan2(abs(ux * up - uy * along), ux * along + uy * up)
            trace.turns[count] = turn / cones.half_apertures[ping]
            count += 1
    return count
