"""Certainty grid of Moravec and Elfes (1985; profiles and order of the steps as recalled): empty and occupied apart.

Two certainties are kept for each cell.  Empty ones of all pings reinforce each other; an occupied one is first
cancelled where the cell is known to be empty, then made to sum to one over the cone, since one echo has one cause.
"""

import math
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.grids.canvas import Canvas, CanvasSettings
from echoplan.classical.grids.cones import Cones, chosen_cones
from echoplan.classical.grids.sectors import Raster, Trace, box_about, trace_for, trace_sector
from echoplan.compiled import compiled
from echoplan.model import OccupancyGrid
from echoplan.settings import Settings

__all__ = ["ElfesRule", "ElfesSettings"]


class ElfesSettings(Settings):
    """The profiles of Moravec and Elfes."""

    former_keys: ClassVar = {"error": "range_error"}

    range_error: float = Field(
        default=0.05, gt=0.0, description="Largest error of a range [m]: any obstacle so near to an echo may cause it."
    )
    max_range: float | None = Field(
        default=None,
        gt=0.0,
        description="Range beyond which readings are discarded [m]; the maximum range of the sensor if it is missing.",
    )


class ElfesRule:
    """Lets empty and occupied certainties accumulate.

    Parameters
    ----------
    settings : ElfesSettings
        The profiles.
    canvas : CanvasSettings
        How the map is cut into cells.
    """

    def __init__(self, settings: ElfesSettings, canvas: CanvasSettings) -> None:
        self.settings = settings
        self._canvas = Canvas(canvas, fills=(0.0, 0.0))

    def add(self, cones: Cones) -> None:
        """Superpose the empty cells of more pings, then the occupied ones.

        Parameters
        ----------
        cones : Cones
            The pings of one sweep; those without an echo are discarded.

        Raises
        ------
        InvalidValueError
            If the map grows too large.
        """
        farthest = math.inf if self.settings.max_range is None else self.settings.max_range
        detected = chosen_cones(cones, np.isfinite(cones.readings) & (cones.readings <= farthest))
        radii = detected.readings + self.settings.range_error
        self._canvas.cover(box_about(detected, radii))
        trace = trace_for(detected, radii, self._canvas.settings.resolution)
        for superpose in (superpose_empty, superpose_occupied):
            superpose(self._canvas.layers, self._canvas.raster, detected, trace, self.settings.range_error)

    @property
    def grid(self) -> OccupancyGrid:
        """The map of all cones so far: from the more certain of the two, half a probability to either side of 1/2."""
        empty, occupied = self._canvas.layers
        stronger = np.where(occupied > empty, occupied, np.where(occupied < empty, -empty, 0.0))
        return self._canvas.grid(0.5 + 0.5 * stronger)


@compiled
def superpose_empty(layers: FloatArray, raster: Raster, cones: Cones, trace: Trace, error: float) -> None:
    """Emp := Emp + E - Emp E, with E = (1 - ((d - R_min) / (R - eps - R_min))^2) (1 - (theta / beta)^2)."""
    empty = layers[0]
    for ping in range(len(cones.x)):
        blank, depth = cones.blanks[ping], cones.readings[ping] - error - cones.blanks[ping]
        for cell in range(trace_sector(trace, raster, cones, ping, blank + depth)):
            beyond = (trace.distances[cell] - blank) / depth
            if beyond >= 0.0:
                share = (1.0 - beyond**2) * (1.0 - trace.turns[cell] ** 2)
                row, column = trace.rows[cell], trace.columns[cell]
                empty[row, column] += share - empty[row, column] * share


@compiled
def superpose_occupied(layers: FloatArray, raster: Raster, cones: Cones, trace: Trace, error: float) -> None:
    """Occ := Occ + O - Occ O, with O = (1 - ((d - R) / eps)^2) (1 - (theta / beta)^2) (1 - Emp), normalised."""
    empty, occupied = layers
    for ping in range(len(cones.x)):
        count = trace_sector(trace, raster, cones, ping, cones.readings[ping] + error)
        total = 0.0
        for cell in range(count):
            off = (trace.distances[cell] - cones.readings[ping]) / error
            # The distances make room for what the cells deserve.
            share = max(1.0 - off**2, 0.0) * (1.0 - trace.turns[cell] ** 2)
            trace.distances[cell] = share * (1.0 - empty[trace.rows[cell], trace.columns[cell]])
            total += trace.distances[cell]
        for cell in range(count if total > 0.0 else 0):
            share = trace.distances[cell] / total
            row, column = trace.rows[cell], trace.columns[cell]
            occupied[row, column] += share - occupied[row, column] * share
