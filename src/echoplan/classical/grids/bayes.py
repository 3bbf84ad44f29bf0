"""Bayesian occupancy grid: an inverse sensor model, added up as log odds (Elfes 1989; Probabilistic Robotics, 9.2).

A cell of the cone that is nearer than the echo is probably free, one as far away as the echo probably occupied, and
about one behind it nothing is known.  Cells are taken to be independent of each other, and so are the pings.

All that is needed of a cell is how many pings called it occupied and how many free.  A row of a cone is a run of free
cells between two of occupied ones, so it is enough to keep where runs begin and end and to add up in the end: a ping
costs what it has rows, not what it has cells.
"""

import math

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.grids.canvas import Canvas, CanvasSettings
from echoplan.classical.grids.cones import Cones
from echoplan.classical.grids.sectors import Raster, box_about, chord_of, columns_of, rows_of, sector_of
from echoplan.compiled import compiled, inlined
from echoplan.model import OccupancyGrid
from echoplan.settings import Settings

__all__ = ["BayesRule", "BayesSettings"]


class BayesSettings(Settings):
    """The inverse sensor model of Table 9.2 of Thrun, Burgard and Fox (2005)."""

    occupied: float = Field(
        default=0.7, gt=0.5, lt=1.0, description="Probability that a cell at the distance of the echo is occupied."
    )
    free: float = Field(
        default=0.3, gt=0.0, lt=0.5, description="Probability that a cell nearer than the echo is occupied."
    )
    thickness: float = Field(default=0.1, gt=0.0, description="Thickness of obstacles [m]: two cells of 5 cm.")
    clear_without_echo: bool = Field(
        default=False,
        description="Whether the cone of a ping without an echo is free, as in the book; smooth walls may give "
        "no echo either.",
    )


class BayesRule:
    """Adds the log odds of cones up.

    Parameters
    ----------
    settings : BayesSettings
        The inverse sensor model.
    canvas : CanvasSettings
        How the map is cut into cells.
    """

    def __init__(self, settings: BayesSettings, canvas: CanvasSettings) -> None:
        self.settings = settings
        # Of occupied and free runs of cells, row by row: how many begin in a cell less how many ended before it.
        self._canvas = Canvas(canvas, fills=(0.0, 0.0))

    def add(self, cones: Cones) -> None:
        """Add the cones of more pings.

        Parameters
        ----------
        cones : Cones
            The pings.

        Raises
        ------
        InvalidValueError
            If the map grows too large.
        """
        settings = self.settings
        silent = cones.reaches if settings.clear_without_echo else np.zeros(len(cones.x))
        radii = np.where(np.isinf(cones.readings), silent, cones.readings + settings.thickness / 2)
        # Runs end in the cell after their last.
        self._canvas.cover(box_about(cones, radii + self._canvas.settings.resolution))
        add_runs(self._canvas.layers, self._canvas.raster, cones, radii, settings.thickness)

    @property
    def grid(self) -> OccupancyGrid:
        """The map of all cones so far."""
        occupied, free = np.cumsum(self._canvas.layers, axis=2)
        odds = occupied * _log_odds(self.settings.occupied) + free * _log_odds(self.settings.free)
        return self._canvas.grid(0.5 + 0.5 * np.tanh(0.5 * odds))


@compiled
def add_runs(layers: FloatArray, raster: Raster, cones: Cones, radii: FloatArray, thickness: float) -> None:
    """Add where in each row of a cone its free cells begin and end, and its occupied ones to either side of them."""
    occupied, free = layers
    for ping in range(len(radii)):
        sector = sector_of(cones, ping, radii[ping])
        rim, inner = (free, radii[ping]) if math.isinf(cones.readings[ping]) else (occupied, radii[ping] - thickness)
        first_row, end_row = rows_of(sector, raster)
        for row in range(first_row, end_row):
            first, end = columns_of(sector, raster, row)
            near, beyond = chord_of(sector, raster, row, inner)
            near = min(max(near, first), end)
            beyond = min(max(beyond, near), end)
            add_run(rim, row, first, near)
            add_run(free, row, near, beyond)
            add_run(rim, row, beyond, end)


@inlined
def add_run(layer: FloatArray, row: int, first: int, end: int) -> None:
    """Add one run of cells of a row, nothing if it ends before it begins."""
    if end > first:
        layer[row, first] += 1.0
        layer[row, end] -= 1.0


def _log_odds(probability: float) -> float:
    return float(np.log(probability / (1.0 - probability)))
