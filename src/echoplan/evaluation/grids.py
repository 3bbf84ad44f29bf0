"""Occupancy grids against the truth, cell by cell (Murphy 2000, Section 11.16)."""

from dataclasses import dataclass
from math import ceil, inf, nan

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.evaluation.outlines import Outline
from echoplan.geometry import is_blocked
from echoplan.model import OccupancyGrid, Truth

__all__ = ["GridScore", "score_grid", "true_grid"]

# So many cells are looked at from a pose at once: a whole building would fill the memory.
_BLOCK = 4096


@dataclass(frozen=True, slots=True, kw_only=True)
class GridScore:
    """How far a grid is from the truth: the mean of abs(truth - grid) over its cells.

    A grid that knows nothing has errors of 1/2, one that is right 0, one that is always wrong 1.

    Parameters
    ----------
    occupied : float
        Over cells through which a face goes; nan if there is none.
    free : float
        Over free cells that can be seen from where the robot was; nan if there is none.
    occupied_cells, free_cells : int
        How many there are.
    """

    occupied: float
    free: float
    occupied_cells: int
    free_cells: int

    @property
    def error(self) -> float:
        """Over both, cell by cell: Murphy's sum, divided by the number of cells; nan if there is none."""
        cells = self.occupied_cells + self.free_cells
        return (
            float(np.nansum([self.occupied * self.occupied_cells, self.free * self.free_cells]) / cells)
            if cells
            else nan
        )

    @property
    def balanced_error(self) -> float:
        """Mean of both: free cells are many and easy, occupied ones few and what a map is for."""
        return (self.occupied + self.free) / 2


def score_grid(grid: OccupancyGrid, truth: Truth, *, reach: float = inf) -> GridScore:
    """Hold a grid against the truth.

    Parameters
    ----------
    grid : OccupancyGrid
        The grid, in the frame of the truth.
    truth : Truth
        What is there, and from where it was looked at.
    reach : float, optional
        How far the sensors hear [m].

    Returns
    -------
    GridScore
        Free cells that no pose of the truth can see, behind walls, in cylinders or beyond reach, do not count.

    Examples
    --------
    >>> truth = Truth(walls_xy=[[[0, 1.5], [3, 1.5]]], walls_heard=[1], poses=[[1.5, 0.5, 0]], given=[[1.5, 0.5, 0]])
    >>> grid = OccupancyGrid(origin_xy=[0, 0], resolution=1.0, values=[[0.1, 0.2, 0.1], [0.8, 0.9, 0.4], [0.5] * 3])
    >>> score = score_grid(grid, truth)
    >>> round(score.occupied, 3), round(score.free, 3), score.free_cells
    (0.3, 0.133, 3)
    """
    wanted = true_grid(truth, grid, reach=reach).values
    off = np.abs(wanted - grid.values)
    occupied, free = off[wanted == 1.0], off[wanted == 0.0]
    return GridScore(
        occupied=float(occupied.mean()) if occupied.size else nan,
        free=float(free.mean()) if free.size else nan,
        occupied_cells=occupied.size,
        free_cells=free.size,
    )


def true_grid(truth: Truth, like: OccupancyGrid, *, reach: float = inf) -> OccupancyGrid:
    """Draw the truth on cells.

    Parameters
    ----------
    truth : Truth
        What is there, and from where it was looked at.
    like : OccupancyGrid
        Where the cells are.
    reach : float, optional
        How far the poses see [m].

    Returns
    -------
    OccupancyGrid
        1 where the nearest face is not farther from the centre than half a cell, 0 where else a pose of the truth
        sees the centre, 1/2 where none does.
    """
    outline = Outline(segments_xy=truth.walls_xy, circles=truth.cylinders)
    centers = like.centers_xy.reshape(-1, 2)
    # A face along the border of two cells is in both, however it is rounded.
    occupied = outline.distances(centers) <= like.resolution / 2 * (1 + 1e-9)
    values = np.where(occupied, 1.0, np.where(_visible(centers, truth, reach), 0.0, 0.5))
    return OccupancyGrid(
        origin_xy=like.origin_xy,
        resolution=like.resolution,
        values=values.reshape(like.values.shape),
        frame=like.frame,
    )


def _visible(points_xy: FloatArray, truth: Truth, reach: float) -> BoolArray:
    """Tell which points some pose sees."""
    blocks = np.array_split(points_xy, max(ceil(len(points_xy) / _BLOCK), 1))
    return np.concatenate([_visible_at_once(block, truth, reach) for block in blocks])


def _visible_at_once(points_xy: FloatArray, truth: Truth, reach: float) -> BoolArray:
    visible = np.zeros(len(points_xy), dtype=bool)
    for pose in truth.poses:
        near = np.flatnonzero(~visible & (np.hypot(*(points_xy - pose[:2]).T) <= reach))
        origins = np.broadcast_to(pose[:2], (len(near), 2))
        visible[near] = ~is_blocked(origins, points_xy[near], segments_xy=truth.walls_xy, discs=truth.cylinders)
    return visible
