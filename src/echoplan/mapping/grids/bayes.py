"""Bayesian occupancy grid: an inverse sensor model, added up as log odds (Elfes 1989; Probabilistic Robotics, 9.2).

A cell of the cone that is nearer than the echo is probably free, one as far away as the echo probably occupied, and
about one behind it nothing is known.  Cells are taken to be independent of each other, and so are the pings.
"""

import math

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray
from echoplan.compiled import compiled
from echoplan.mapping.grids.canvas import Canvas, CanvasSettings
from echoplan.mapping.grids.cones import Cones, boxes_of
from echoplan.mapping.grids.sectors import Raster, chord_of, columns_of, rows_of, sector_of
from echoplan.model import OccupancyGrid

__all__ = ["BayesRule", "BayesSettings"]


class BayesSettings(BaseModel, frozen=True, extra="forbid"):
    """The inverse sensor model of Table 9.2 of Thrun, Burgard and Fox (2005)."""

    occupied: float = Field(
        default=0.7, gt=0.5, lt=1.0, description="how likely a cell at the distance of the echo is to be occupied"
    )
    free: float = Field(default=0.3, gt=0.0, lt=0.5, description="how likely a nearer cell is to be occupied")
    thickness: float = Field(default=0.1, gt=0.0, description="thickness of obstacles [m]: two cells of 5 cm")
    clear_without_echo: bool = Field(
        default=False,
        description="whether the cone of a ping without an echo is free, as in the book; smooth walls are silent too",
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
        self._canvas = Canvas(canvas)

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
        self._canvas.cover(boxes_of(cones, radii))
        evidence = (_log_odds(settings.occupied), _log_odds(settings.free))
        add_log_odds(self._canvas.layers[0], self._canvas.raster, cones, radii, settings.thickness, evidence)

    @property
    def grid(self) -> OccupancyGrid:
        """The map of all cones so far."""
        return self._canvas.grid(1.0 / (1.0 + np.exp(-self._canvas.layers[0])))


@compiled
def add_log_odds(
    layer: FloatArray, raster: Raster, cones: Cones, radii: FloatArray, thickness: float, evidence: tuple[float, float]
) -> None:
    """Add the log odds of occupied and free cells of cones to a layer."""
    occupied, free = evidence
    for ping in range(len(radii)):
        sector = sector_of(cones, ping, radii[ping])
        inner = radii[ping] - thickness
        rim = free if math.isinf(cones.readings[ping]) else occupied
        first_row, end_row = rows_of(sector, raster)
        for row in range(first_row, end_row):
            first, end = columns_of(sector, raster, row)
            near, beyond = chord_of(sector, raster, row, inner)
            near = min(max(near, first), end)
            beyond = min(max(beyond, near), end)
            shift(layer[row, first:near], rim)
            shift(layer[row, near:beyond], free)
            shift(layer[row, beyond:end], rim)


@compiled
def shift(cells: FloatArray, amount: float) -> None:
    """Add an amount to cells in a row."""
    for place in range(len(cells)):
        cells[place] += amount


def _log_odds(probability: float) -> float:
    return float(np.log(probability / (1.0 - probability)))
