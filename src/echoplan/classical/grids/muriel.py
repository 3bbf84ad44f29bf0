"""MURIEL (Konolige 1997; as recalled): the evidence of each place counts once, and sound may be reflected away.

A forward model gives the likelihood ratio of a reading D for a cell at distance d that is a surface facing the sensor
against a free cell.  With the detection probability q of the cell, which falls with distance and with the angle from
the axis, and the density f of readings that it does not cause::

    LR(D) = 1 - q Phi((D - d) / sigma) + q N(D - d; sigma) / f

Pings of one place detect the same reflections and are not independent: of each place a cell keeps the strongest
evidence for a surface and the strongest against it.  A smooth surface reflects sound away unless it faces the sensor to
within half the aperture beta.  A surface of unknown direction does so with probability F = 2 beta / pi, for all pings
of a place or for none.  So the evidence of one place against a cell is bounded by the chance that it does not face it::

    LR(place) = F LR(strongest for) LR(strongest against) + 1 - F

Pose buckets and a forward model with specular terms are Konolige's; the forms of q and F are this module's own.
"""

import math
from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.grids.canvas import Canvas, CanvasSettings
from echoplan.classical.grids.cones import Cones, chosen_cones, join_cones
from echoplan.classical.grids.sectors import Raster, Trace, box_about, trace_for, trace_sector
from echoplan.compiled import compiled, inlined
from echoplan.model import OccupancyGrid
from echoplan.settings import Settings

__all__ = ["MurielRule", "MurielSettings"]

# Cells farther behind the echo than this get no evidence [standard deviations].
_TAIL = 3.0
# The density of a reading is negligible this far before the echo [standard deviations].
_FAR = 8.0
_ROOT_TWO, _ROOT_TAU = math.sqrt(2.0), math.sqrt(2.0 * math.pi)


class MurielSettings(Settings):
    """The forward model, and the distance within which pings are of one place."""

    former_keys: ClassVar = {
        "detection": "detection_probability",
        "deviation": "sigma",
        "background": "clutter_density",
    }

    detection_probability: float = Field(
        default=0.95,
        gt=0.0,
        lt=1.0,
        description="Detection probability of a near surface on the axis that faces the sensor.",
    )
    sigma: float = Field(default=0.03, gt=0.0, description="Standard deviation of a range and of a cell [m].")
    clutter_density: float = Field(
        default=1.0,
        gt=0.0,
        description="Density of readings that a cell does not cause [1/m]: one in the width of a room.",
    )
    place: float = Field(default=0.1, gt=0.0, description="Side of a place within which pings are not independent [m].")


class Model(NamedTuple):
    """The forward model for compiled functions: see ``MurielSettings``."""

    detection_probability: float
    sigma: float
    clutter_density: float


class MurielRule:
    """Adds up the evidence of places.

    Parameters
    ----------
    settings : MurielSettings
        The forward model.
    canvas : CanvasSettings
        How the map is cut into cells.
    """

    def __init__(self, settings: MurielSettings, canvas: CanvasSettings) -> None:
        self.settings = settings
        self._lattice = canvas
        self._parts: list[Cones] = []

    def add(self, cones: Cones) -> None:
        """Keep the cones of more pings.

        Parameters
        ----------
        cones : Cones
            The pings; a place may be visited again later.
        """
        self._parts.append(cones)

    @property
    def grid(self) -> OccupancyGrid:
        """The map of all cones so far.

        Raises
        ------
        InvalidValueError
            If the map would be too large.
        """
        cones = join_cones(self._parts)
        radii = np.minimum(cones.readings + _TAIL * self.settings.sigma, cones.reaches)
        canvas = Canvas(self._lattice)
        canvas.cover(box_about(cones, radii))
        trace = trace_for(cones, radii, self._lattice.resolution)
        model = Model(self.settings.detection_probability, self.settings.sigma, self.settings.clutter_density)
        for chosen in _places(cones, self.settings.place):
            own = chosen_cones(cones, chosen)
            place = Canvas(self._lattice, fills=(0.0, 0.0))
            place.cover(box_about(own, radii[chosen]))
            keep_strongest(place.layers, place.raster, own, radii[chosen], trace, model)
            # Probability that a surface faces the sensors of this place: F above.
            faces = own.half_apertures.max() / (np.pi / 2)
            canvas.add(place, np.log(faces * np.exp(place.layers.sum(axis=0)) + 1.0 - faces))
        return canvas.grid(0.5 + 0.5 * np.tanh(0.5 * canvas.layers[0]))


def _places(cones: Cones, side: float) -> list[IntArray]:
    """Sort pings by place, that is by where the turret stood: the indices of each."""
    squares = np.floor(np.column_stack([cones.hub_x, cones.hub_y]) / side)
    _, numbers = np.unique(squares, axis=0, return_inverse=True)
    order = np.argsort(numbers, kind="stable")
    return np.split(order, np.flatnonzero(np.diff(numbers[order])) + 1) if len(order) else []


@compiled
def keep_strongest(
    layers: FloatArray, raster: Raster, cones: Cones, radii: FloatArray, trace: Trace, model: Model
) -> None:
    """Keep the strongest evidence for and against a surface in each cell of the cones of a place."""
    for ping in range(len(radii)):
        for cell in range(trace_sector(trace, raster, cones, ping, radii[ping])):
            row, column = trace.rows[cell], trace.columns[cell]
            distance = trace.distances[cell]
            detection = detection_probability(distance / cones.reaches[ping], trace.turns[cell], model)
            evidence = math.log(likelihood_ratio(cones.readings[ping] - distance, detection, model))
            layers[0, row, column] = max(layers[0, row, column], evidence)
            layers[1, row, column] = min(layers[1, row, column], evidence)


@inlined
def detection_probability(share: float, turn: float, model: Model) -> float:
    """Return that of a surface facing the sensor; distance relative to its reach, angle to its half aperture."""
    return model.detection_probability * max(1.0 - share**2, 0.0) * (1.0 - turn**2)


@inlined
def likelihood_ratio(excess: float, detection: float, model: Model) -> float:
    """How much likelier a reading is that is so much longer than the distance of a cell if the cell is occupied."""
    away = excess / model.sigma
    if away > _FAR:
        return 1.0 - detection
    passed = 0.5 * math.erfc(-away / _ROOT_TWO)
    density = math.exp(-0.5 * away**2) / (_ROOT_TAU * model.sigma)
    return 1.0 - detection * passed + detection * density / model.clutter_density
