"""Occupancy grids: how likely each cell of a map is to be occupied."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import BoolArray, FloatArray, IntArray, checked_floats, checked_number, store
from echoplan.errors import InvalidValueError

__all__ = ["OccupancyGrid"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class OccupancyGrid:
    """A map cut into square cells.

    Parameters
    ----------
    origin_xy : ndarray, shape (2,)
        Lower left corner of the cell of row 0 and column 0 [m].
    resolution : float
        Side of a cell [m].
    values : ndarray, shape (rows, columns)
        Probability that a cell is occupied; rows go up along y, columns right along x.  1/2 is not known.
    frame : str, optional
        Frame of the coordinates (REP 105).

    Raises
    ------
    InvalidValueError
        If the resolution is not positive, there is no cell, or a value is no probability.

    Examples
    --------
    >>> grid = OccupancyGrid(origin_xy=[-1.0, 0.0], resolution=0.5, values=[[0.5, 0.1, 0.9]])
    >>> grid.cells_of([[0.2, 0.3]]).tolist(), grid.centers_xy[0, 2].tolist()
    ([[0, 2]], [0.25, 0.25])
    """

    origin_xy: FloatArray
    resolution: float
    values: FloatArray
    frame: str = "map"

    def __post_init__(self) -> None:
        checked_number(self.resolution, name="resolution", above=0.0)
        values = checked_floats(self.values, name="values", shape=(None, None))
        if not values.size:
            raise InvalidValueError(f"values must have at least one cell, not shape {values.shape}")
        checked_number(float(values.min()), name="values", minimum=0.0)
        checked_number(float(values.max()), name="values", maximum=1.0)
        store(self, values=values, origin_xy=checked_floats(self.origin_xy, name="origin_xy", shape=(2,)))

    @property
    def size_xy(self) -> FloatArray:
        """Width and height [m], shape (2,)."""
        size: FloatArray = self.resolution * np.array(self.values.shape[::-1], dtype=np.float64)
        return size

    @property
    def centers_xy(self) -> FloatArray:
        """Centres of all cells [m], shape (rows, columns, 2)."""
        rows, columns = np.indices(self.values.shape)
        centers: FloatArray = self.origin_xy + self.resolution * (np.stack([columns, rows], axis=-1) + 0.5)
        return centers

    def cells_of(self, points_xy: ArrayLike) -> IntArray:
        """Find the cells in which points lie.

        Parameters
        ----------
        points_xy : array_like, shape (..., 2)
            Points [m].

        Returns
        -------
        ndarray of int, shape (..., 2)
            Row and column of each, beyond the grid too; a point on a border belongs to the cell above and right of it.
        """
        steps = (np.asarray(points_xy, dtype=np.float64) - self.origin_xy) / self.resolution
        cells: IntArray = np.floor(steps).astype(np.int64)[..., ::-1]
        return cells

    def contains(self, points_xy: ArrayLike) -> BoolArray:
        """Return a mask of the points that lie on the grid.

        Parameters
        ----------
        points_xy : array_like, shape (..., 2)
            Points [m].

        Returns
        -------
        ndarray of bool, shape (...)
            True for the points that have a cell.
        """
        cells = self.cells_of(points_xy)
        return np.asarray(((cells >= 0) & (cells < self.values.shape)).all(axis=-1))
