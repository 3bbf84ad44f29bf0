"""Arc maps: how many arcs pass through each cell, and the densest cells along many directions (Barshan 2007)."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.loci.loci import Loci
from echoplan.geometry import directions

__all__ = ["ArcMap", "arc_map", "directional_maxima"]

# So many arcs are drawn at a time: what fits into some megabytes.
_CHUNK = 512


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ArcMap:
    """The cells through which arcs pass.

    Parameters
    ----------
    points_xy : ndarray, shape (c, 2)
        Centres of the cells [m].
    counts : ndarray of int, shape (c,)
        How many arcs pass through each.
    """

    points_xy: FloatArray
    counts: IntArray


def arc_map(loci: Loci, *, resolution: float) -> ArcMap:
    """Draw arcs on a grid of cells.

    Parameters
    ----------
    loci : Loci
        The arcs.
    resolution : float
        Side of a cell [m].

    Returns
    -------
    ArcMap
        The cells with at least one arc, row by row; an arc counts once in a cell.
    """
    parts = [_cells(loci[start : start + _CHUNK], resolution) for start in range(0, len(loci), _CHUNK)]
    cells, counts = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *parts]), return_counts=True)
    rows, columns = cells >> 32, (cells & (2**32 - 1)) - 2**31
    centers = resolution * (np.column_stack([columns, rows]).astype(np.float64) + 0.5)
    return ArcMap(points_xy=centers, counts=counts)


def directional_maxima(cells: ArcMap, *, count: int, resolution: float) -> IntArray:
    """Count in how many directions each cell is the densest on its line.

    Barshan (2007), as recalled: along each direction the map falls into lines one cell wide, and of each line only
    the cell with most arcs is kept; the thinned map is the union over all directions.

    Parameters
    ----------
    cells : ArcMap
        The cells.
    count : int
        Into how many directions half a turn is divided.
    resolution : float
        Width of a line [m].

    Returns
    -------
    ndarray of int, shape (c,)
        In how many directions each cell leads; 0 for those that are thinned out.
    """
    leads = np.zeros(len(cells.counts), dtype=np.int64)
    for angle in np.pi * np.arange(count) / count:
        lines = np.floor(cells.points_xy @ directions(angle + np.pi / 2) / resolution)
        order = np.lexsort((-cells.counts, lines))
        _, first = np.unique(lines[order], return_index=True)
        leads[order[first]] += 1
    return leads


def _cells(loci: Loci, resolution: float) -> IntArray:
    """Cells of each arc, each once, as one number (row << 32) + column + 2**31: a map is never 2**31 cells wide."""
    longest = float((2 * loci.ranges * loci.half_apertures).max())
    turns = loci.half_apertures[:, None] * np.linspace(-1, 1, 2 * int(np.ceil(longest / resolution)) + 2)
    columns, rows = np.floor(np.moveaxis(loci.points_xy(turns), -1, 0) / resolution).astype(np.int64)
    packed = np.sort((rows << 32) + (columns + 2**31), axis=1)
    once = np.diff(packed, axis=1, prepend=packed[:, :1] - 1) > 0
    return packed[once]
