"""What Nav2's range_sensor_layer computes, with its defects (nav2_costmap_2d, ``range_sensor_layer.cpp``).

The model has no published source.  What is known to go wrong is kept: the side of a cell is used as a relative error
of the range; cells farther than ``phi`` from the sensor hardly count; all cells of the rectangle about a triangle are
updated, which for wide beams does not even reach the echo; the cell on the axis is marked whatever was known of it;
costs are whole numbers, cut off and not rounded, so that the faintest hint of free space lowers them and none of an
obstacle raises them; a cell that fell to 0 stays there.
"""

import math

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.grids.canvas import Canvas, CanvasSettings
from echoplan.classical.grids.cones import Cones, chosen_cones
from echoplan.classical.grids.sectors import Raster
from echoplan.compiled import compiled, inlined
from echoplan.model import OccupancyGrid
from echoplan.settings import Settings

__all__ = ["RangeLayerRule", "RangeLayerSettings"]

# Costs of nav2_costmap_2d: an obstacle, what is written into the cell on the axis, and nothing known.
_LETHAL, _TARGET, _UNKNOWN = 254.0, 233.0, 127.0
# The triangle reaches so much farther than the reading.
_STRETCH = 1.2


class RangeLayerSettings(Settings):
    """The parameters of the layer, with its own defaults."""

    phi: float = Field(default=1.2, gt=0.0, description="Distance at which a cell has half its weight [m].")
    clear_on_max_reading: bool = Field(
        default=False, description="Whether a ping without an echo clears its whole rectangle."
    )


class RangeLayerRule:
    """Does as the layer does, on a map that does not roll along.

    Parameters
    ----------
    settings : RangeLayerSettings
        The parameters.
    canvas : CanvasSettings
        How the map is cut into cells.
    """

    def __init__(self, settings: RangeLayerSettings, canvas: CanvasSettings) -> None:
        self.settings = settings
        self._canvas = Canvas(canvas, fills=(_UNKNOWN,))

    def add(self, cones: Cones) -> None:
        """Update the costs with more pings, one after the other.

        Parameters
        ----------
        cones : Cones
            The pings.

        Raises
        ------
        InvalidValueError
            If the map grows too large.
        """
        used = cones
        if not self.settings.clear_on_max_reading:
            used = chosen_cones(cones, np.isfinite(cones.readings))
        boxes = _rectangles(used)
        if len(boxes):
            self._canvas.cover(np.stack([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)]))
        update_costs(self._canvas.layers[0], self._canvas.raster, used, boxes, self.settings.phi)

    @property
    def grid(self) -> OccupancyGrid:
        """The costs so far, as probabilities."""
        return self._canvas.grid(self._canvas.layers[0] / _LETHAL)


def _rectangles(cones: Cones) -> FloatArray:
    """Rectangles about the triangles of sensor and both edges of the cone; the echo on the axis may lie outside."""
    depths = np.minimum(cones.readings, cones.reaches)
    angles = np.arctan2(cones.uy, cones.ux)[:, None] + cones.half_apertures[:, None] * [-1.0, 1.0]
    sides = _STRETCH * depths[:, None, None] * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    triangles = np.concatenate([np.zeros((len(depths), 1, 2)), sides], axis=1)
    centers = np.column_stack([cones.x, cones.y])
    boxes: FloatArray = centers[:, None] + np.stack([triangles.min(axis=1), triangles.max(axis=1)], axis=1)
    return boxes


@compiled
def update_costs(layer: FloatArray, raster: Raster, cones: Cones, boxes: FloatArray, phi: float) -> None:
    """Update the cells of the rectangle of each ping, the cell on the axis marked before."""
    for ping in range(len(cones.x)):
        reading = cones.readings[ping]
        if math.isfinite(reading):
            mark_target(layer, raster, cones, ping)
        low, high = boxes[ping]
        first_row, end_row = cell_of(low[1], raster.y, raster), cell_of(high[1], raster.y, raster) + 1
        first, end = cell_of(low[0], raster.x, raster), cell_of(high[0], raster.x, raster) + 1
        for row in range(first_row, min(end_row, raster.rows)):
            up = raster.y + (row + 0.5) * raster.resolution - cones.y[ping]
            for column in range(first, min(end, raster.columns)):
                along = raster.x + (column + 0.5) * raster.resolution - cones.x[ping]
                sensor = 0.0
                if math.isfinite(reading):
                    turn = math.atan2(
                        cones.ux[ping] * up - cones.uy[ping] * along, cones.ux[ping] * along + cones.uy[ping] * up
                    )
                    weight = weight_of(math.hypot(along, up), turn / cones.half_apertures[ping], phi)
                    sensor = sensor_model(reading, math.hypot(along, up), weight, raster.resolution)
                layer[row, column] = cost_after(layer[row, column], sensor)


@inlined
def mark_target(layer: FloatArray, raster: Raster, cones: Cones, ping: int) -> None:
    """Mark the cell on the axis, at the distance of the echo, if it lies on the map."""
    row = cell_of(cones.y[ping] + cones.readings[ping] * cones.uy[ping], raster.y, raster)
    column = cell_of(cones.x[ping] + cones.readings[ping] * cones.ux[ping], raster.x, raster)
    if 0 <= row < raster.rows and 0 <= column < raster.columns:
        layer[row, column] = _TARGET


@inlined
def cell_of(coordinate: float, origin: float, raster: Raster) -> int:
    """Find the row or the column of a coordinate."""
    return math.floor((coordinate - origin) / raster.resolution)


@inlined
def weight_of(distance: float, turn: float, phi: float) -> float:
    """How much a cell counts: less, the farther from the sensor and from the axis it is."""
    if abs(turn) > 1.0:
        return 0.0
    return (1.0 - (1.0 + math.tanh(2.0 * (distance - phi))) / 2.0) * (1.0 - turn**2)


@inlined
def sensor_model(reading: float, distance: float, weight: float, resolution: float) -> float:
    """Probability that a cell is occupied, by one reading; the error is the reading times the side of a cell."""
    error = resolution * reading
    if distance < reading - 2.0 * error:
        return 0.5 * (1.0 - weight)
    if distance < reading - error:
        return weight * 0.5 * ((distance - (reading - 2.0 * error)) / error) ** 2 + 0.5 * (1.0 - weight)
    if distance < reading + error:
        return weight * (0.5 - 0.5 * ((reading - distance) / error) ** 2) + 0.5
    return 0.5


@inlined
def cost_after(cost: float, sensor: float) -> float:
    """Update a cost by Bayes' rule, and cut it off to a whole number."""
    prior = cost / _LETHAL
    occupied, free = sensor * prior, (1.0 - sensor) * (1.0 - prior)
    if occupied + free == 0.0:
        return 0.0
    return math.floor(occupied / (occupied + free) * _LETHAL)
