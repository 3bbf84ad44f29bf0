"""Oblique returns of ray cones.

An oblique surface reflects sound away from the sensor, but it stops a ray. A robot simulator that returns the least
range of all rays in a cone reads a wall at its depth as long as the perpendicular lies in the cone, and at the range of
the outermost ray beyond that. Oblique returns explain readings, but their absence is no evidence against a landmark.
"""

import math

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, Shape, SonarTables, shape_of
from echoplan.arrays import FloatArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.likelihood.image_sources import Extent, Point, depth_of
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.kernels import log_gaussian
from echoplan.preprocessing.measurements import Measurements

__all__ = ["flanks_of"]

_WALL = int(Kind.WALL)
# Ratio of the standard deviation to that of direct readings: the direction of the outermost ray is known less well.
_SCATTER = 1.5
# Gate in standard deviations.
_CUT = 6.0
# Least cosine of incidence: more oblique rays are not informative.
_GRAZING = 0.1


@compiled
def flanks_of(
    measurements: Measurements, tables: SonarTables, reflector: FloatArray, extent: Extent, noise: float
) -> FloatArray:
    """Return the log density of each reading by an outermost ray on a wall or cylinder [log 1/m], shape (n,).

    ``extent`` is that of a wall along its line [m].
    """
    log_densities, shape = np.full(len(measurements.readings), NO_ECHO), shape_of(reflector)
    cosine, sine = math.cos(tables.cone), math.sin(tables.cone)
    for ping in range(len(log_densities)):
        reading = measurements.readings[ping] * tables.scale
        if not math.isfinite(reading):
            continue
        place, axis = (measurements.x[ping], measurements.y[ping]), (measurements.ux[ping], measurements.uy[ping])
        for side in (sine, -sine):
            ray = (cosine * axis[0] - side * axis[1], side * axis[0] + cosine * axis[1])
            way, incidence = _met(shape, extent, place, ray)
            scatter = _SCATTER * noise / max(incidence, _GRAZING)
            late = reading - way
            if abs(late) < _CUT * scatter:
                log_densities[ping] = max(log_densities[ping], log_gaussian(1.0, late, scatter))
    return log_densities


@inlined
def _met(shape: Shape, extent: Extent, place: Point, ray: Point) -> tuple[float, float]:
    """Return the length of a ray to a landmark [m], ``inf`` if it misses, and the cosine of its incidence."""
    if shape[0] == _WALL:
        incidence = shape[1] * ray[0] + shape[2] * ray[1]
        if incidence < _GRAZING:
            return math.inf, 1.0
        way = depth_of(shape, place) / incidence
        along = shape[1] * (place[1] + way * ray[1]) - shape[2] * (place[0] + way * ray[0])
        return (way if way > 0.0 and extent[0] < along < extent[1] else math.inf), incidence
    x, y = shape[1] - place[0], shape[2] - place[1]
    ahead, aside = x * ray[0] + y * ray[1], x * ray[1] - y * ray[0]
    square = shape[3] * shape[3] - aside * aside
    if ahead < 0.0 or square <= 0.0:
        return math.inf, 1.0
    return ahead - math.sqrt(square), math.sqrt(square) / shape[3]
