"""Occupancy grids against the truth, cell by cell (Murphy 2000, Section 11.16)."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import ceil, inf, nan

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.errors import InvalidValueError
from echoplan.evaluation.outlines import Outline
from echoplan.geometry import is_blocked
from echoplan.model import OccupancyGrid, Truth

__all__ = ["GridScore", "pool_grid_scores", "score_grid", "true_grid"]

# So many cells are looked at from a pose at once: a whole building would fill the memory.
_BLOCK = 4096
# What rounding may take from or add to a length, as a share of it.
_TOLERANCE = 1e-9
# A truth that covers more cells is refused: 200 m by 200 m at 5 cm.
_CELLS_AT_MOST = 16_000_000


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
    """Compare a grid with ground truth.

    Parameters
    ----------
    grid : OccupancyGrid
        The grid, in the frame of the truth.
    truth : Truth
        What is there, and from where it was looked at.
    reach : float, optional
        Maximum range of the sensors [m].

    Returns
    -------
    GridScore
        Over the cells that hold what is true and whence it was looked at, however far the grid goes: those that the
        grid lacks are unknown.  Free cells that no pose can see, behind walls, in cylinders or beyond reach, do not
        count.

    Examples
    --------
    >>> poses = [[1.5, 0.5, 0]]
    >>> truth = Truth(walls_xy=[[[0.5, 1.5], [2.5, 1.5]]], walls_detected_by=[1], poses=poses, given=poses)
    >>> grid = OccupancyGrid(origin_xy=[0, 0], resolution=1.0, values=[[0.1, 0.2, 0.1], [0.8, 0.9, 0.4], [0.5] * 3])
    >>> score = score_grid(grid, truth)
    >>> round(score.occupied, 3), round(score.free, 3), score.free_cells
    (0.3, 0.133, 3)
    """
    whole = _about(truth, grid)
    wanted = true_grid(truth, whole, reach=reach).values
    off = np.abs(wanted - whole.values)
    occupied, free = off[wanted == 1.0], off[wanted == 0.0]
    return GridScore(
        occupied=float(occupied.mean()) if occupied.size else nan,
        free=float(free.mean()) if free.size else nan,
        occupied_cells=occupied.size,
        free_cells=free.size,
    )


def pool_grid_scores(scores: Sequence[GridScore]) -> GridScore:
    """Pool scores of several grids, cell by cell.

    Parameters
    ----------
    scores : sequence of GridScore
        One a grid.

    Returns
    -------
    GridScore
        As of one grid of all their cells; nan where there is no cell.

    Examples
    --------
    >>> half, all_right = (GridScore(occupied=error, free=0.0, occupied_cells=10, free_cells=5) for error in (0.5, 0.0))
    >>> pool_grid_scores([half, all_right]).occupied
    0.25
    """
    occupied = [(score.occupied, score.occupied_cells) for score in scores if score.occupied_cells]
    free = [(score.free, score.free_cells) for score in scores if score.free_cells]
    return GridScore(
        occupied=_weighted(occupied),
        free=_weighted(free),
        occupied_cells=sum(cells for _, cells in occupied),
        free_cells=sum(cells for _, cells in free),
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
    occupied = outline.distances(centers) <= like.resolution / 2 * (1 + _TOLERANCE)
    blocks = np.array_split(centers, max(ceil(len(centers) / _BLOCK), 1))
    visible = np.concatenate([_visible(block, truth, reach) for block in blocks])
    values = np.where(occupied, 1.0, np.where(visible, 0.0, 0.5))
    return OccupancyGrid(
        origin_xy=like.origin_xy,
        resolution=like.resolution,
        values=values.reshape(like.values.shape),
        frame=like.frame,
    )


def _weighted(errors: Sequence[tuple[float, int]]) -> float:
    cells = sum(count for _, count in errors)
    return sum(error * count for error, count in errors) / cells if cells else nan


def _about(truth: Truth, grid: OccupancyGrid) -> OccupancyGrid:
    """Cut a grid, or fill it up with unknown cells, so that it holds the truth and no more."""
    outlines = (truth.cylinders[:, :2] + side * truth.cylinders[:, 2:] for side in (-1, 1))
    true_xy = np.concatenate([truth.walls_xy.reshape(-1, 2), truth.poses[:, :2], *outlines])
    if not len(true_xy):
        return grid
    # A face along the border of two cells is in both.
    rim = _TOLERANCE * grid.resolution
    first, end = grid.cells_of(true_xy.min(axis=0) - rim), grid.cells_of(true_xy.max(axis=0) + rim) + 1
    height, width = (end - first).tolist()
    if height * width > _CELLS_AT_MOST:
        raise InvalidValueError(
            f"a grid of {width} by {height} cells, which the truth covers, has more than {_CELLS_AT_MOST} cells; "
            "check the truth or choose a greater resolution"
        )
    low, high = np.clip([first, end], 0, grid.values.shape)
    values = np.full(end - first, 0.5)
    values[_window(low - first, high - first)] = grid.values[_window(low, high)]
    origin = grid.origin_xy + grid.resolution * first[::-1]
    return OccupancyGrid(origin_xy=origin, resolution=grid.resolution, values=values, frame=grid.frame)


def _window(low: IntArray, high: IntArray) -> tuple[slice, slice]:
    (row, end_row), (column, end_column) = np.transpose([low, high]).tolist()
    return slice(row, end_row), slice(column, end_column)


def _visible(points_xy: FloatArray, truth: Truth, reach: float) -> BoolArray:
    """Return which points some pose sees."""
    visible = np.zeros(len(points_xy), dtype=bool)
    for pose in truth.poses:
        near = np.flatnonzero(~visible & (np.hypot(*(points_xy - pose[:2]).T) <= reach * (1 + _TOLERANCE)))
        origins = np.broadcast_to(pose[:2], (len(near), 2))
        visible[near] = ~is_blocked(origins, points_xy[near], segments_xy=truth.walls_xy, discs=truth.cylinders)
    return visible
