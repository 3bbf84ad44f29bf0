"""A canvas that grows: layers of cells on one lattice, wide enough for all cones so far."""

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.grids.sectors import Raster
from echoplan.errors import InvalidValueError
from echoplan.model import OccupancyGrid
from echoplan.settings import Settings

__all__ = ["Canvas", "CanvasSettings"]

# A canvas grows by so many cells at a time, so that it seldom has to be copied.
_CHUNK = 32
# Beyond so many cells from the origin a number of 64 bits has no room for the place in a cell.
_FARTHEST = 2**40
_EMPTY = np.zeros((2, 2), dtype=np.int64)


class CanvasSettings(Settings):
    """How a map is cut into cells."""

    resolution: float = Field(default=0.05, gt=0.0, description="Side of a cell [m], as is common for navigation.")
    max_cells: int = Field(
        default=16_000_000, gt=0, description="Largest number of cells of a map: 200 m by 200 m at 5 cm."
    )


class Canvas:
    """Layers of cells that grow with what is drawn on them.

    Parameters
    ----------
    settings : CanvasSettings
        Size of the cells, and how many there may be.
    fills : tuple of float, optional
        What the cells of each layer hold before anything is drawn on them.
    """

    def __init__(self, settings: CanvasSettings, *, fills: tuple[float, ...] = (0.0,)) -> None:
        self.settings = settings
        self._fills = np.array(fills)[:, None, None]
        # Row and column of the first cell, and after the last, on a lattice with a corner of cell 0, 0 in the origin.
        self.box: IntArray = _EMPTY
        self.layers: FloatArray = np.zeros((len(fills), 0, 0))

    @property
    def raster(self) -> Raster:
        """Where the cells of the layers lie."""
        (row, column), (end_row, end_column) = self.box.tolist()
        resolution = self.settings.resolution
        return Raster(column * resolution, row * resolution, resolution, end_row - row, end_column - column)

    def cover(self, box: FloatArray) -> None:
        """Grow until a box lies on the canvas.

        Parameters
        ----------
        box : ndarray, shape (2, 2)
            Lower left and upper right corner, x before y [m]; infinite where there is nothing to cover.

        Raises
        ------
        InvalidValueError
            If the canvas would have more cells than it may.
        """
        if not np.isfinite(box).all():
            return
        steps = box[:, ::-1] / (_CHUNK * self.settings.resolution)
        wanted = _CHUNK * np.stack([np.floor(steps[0]), np.floor(steps[1]) + 1.0])
        if self.layers.size:
            wanted = np.stack([np.minimum(wanted[0], self.box[0]), np.maximum(wanted[1], self.box[1])])
        self._check(wanted)
        self._grow(wanted.astype(np.int64))

    def add(self, other: "Canvas", values: FloatArray) -> None:
        """Add the cells of another canvas to the first layer of this one.

        Parameters
        ----------
        other : Canvas
            One on the same lattice, no wider than this one.
        values : ndarray, shape (rows, columns)
            What to add, cell by cell of the other canvas.
        """
        (row, column), (end_row, end_column) = (other.box - self.box[0]).tolist()
        self.layers[0, row:end_row, column:end_column] += values

    def grid(self, values: FloatArray) -> OccupancyGrid:
        """Make a grid of what was drawn.

        Parameters
        ----------
        values : ndarray, shape (rows, columns)
            Probability of each cell of the canvas.

        Returns
        -------
        OccupancyGrid
            One unknown cell at the origin if nothing was drawn.
        """
        raster = self.raster
        return OccupancyGrid(
            origin_xy=np.array([raster.x, raster.y]),
            resolution=raster.resolution,
            values=values if values.size else np.full((1, 1), 0.5),
        )

    def _check(self, box: FloatArray) -> None:
        (height, width), resolution = (box[1] - box[0]).tolist(), self.settings.resolution
        if height * width <= self.settings.max_cells and np.abs(box).max() <= _FARTHEST:
            return
        raise InvalidValueError(
            f"a grid of {width * resolution:.5g} m by {height * resolution:.5g} m, up to "
            f"{np.abs(box).max() * resolution:.5g} m from the origin, would have more cells than max_cells = "
            f"{self.settings.max_cells}; check the poses or choose a greater resolution"
        )

    def _grow(self, box: IntArray) -> None:
        if np.array_equal(box, self.box):
            return
        (rows, columns), (row, column) = box[1] - box[0], self.box[0] - box[0]
        grown = np.broadcast_to(self._fills, (len(self._fills), rows, columns)).copy()
        _, height, width = self.layers.shape
        grown[:, row : row + height, column : column + width] = self.layers
        self.layers, self.box = grown, box
