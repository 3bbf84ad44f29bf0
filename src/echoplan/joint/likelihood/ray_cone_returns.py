"""Flanks: what a cone of rays reads of features that it meets aslant.

Sound glances off what it meets aslant; a ray does not.  So a robot simulator, which returns the least range of all rays
of a cone, reads a wall at its depth as long as the perpendicular is in the cone, and farther and farther from then on:
as far as the outermost ray goes.  Flanks explain readings for nothing, but are never missed.
"""

import math

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing, Kind, Shape, shape_of
from echoplan.arrays import FloatArray
from echoplan.compiled import compiled
from echoplan.joint.likelihood.image_sources import Extent, Point, depth_of
from echoplan.joint.likelihood.ping_scores import UNHEARD
from echoplan.preprocessing.measurements import Measurements

__all__ = ["flanks_of"]

_WALL = int(Kind.WALL)
# Where the outermost ray goes is known less well than where a feature stands, by this factor.
_SCATTER = 1.5
# Readings farther off than so many deviations are of something else.
_CUT = 6.0
# Rays that graze a surface more than this tell nothing (cosine of incidence).
_GRAZING = 0.1
_ROOT_TAU = math.sqrt(2.0 * math.pi)


@compiled
def flanks_of(
    measurements: Measurements, hearing: Hearing, reflector: FloatArray, extent: Extent, noise: float
) -> FloatArray:
    """Explain readings by the outermost rays of a cone.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    hearing : Hearing
        The sonar: rays in a cone.
    reflector : ndarray, shape (4,)
        A wall or a cylinder.
    extent : Extent
        Between which places along it a wall may be met [m].
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    ndarray, shape (n,)
        Logarithm of the density of each reading if it is that of such a ray [log 1/m].
    """
    log_densities, shape = np.full(len(measurements.readings), UNHEARD), shape_of(reflector)
    cosine, sine = math.cos(hearing.cone), math.sin(hearing.cone)
    for ping in range(len(log_densities)):
        reading = measurements.readings[ping] * hearing.scale
        if not math.isfinite(reading):
            continue
        place, axis = (measurements.x[ping], measurements.y[ping]), (measurements.ux[ping], measurements.uy[ping])
        for side in (sine, -sine):
            ray = (cosine * axis[0] - side * axis[1], side * axis[0] + cosine * axis[1])
            way, incidence = _met(shape, extent, place, ray)
            scatter = _SCATTER * noise / max(incidence, _GRAZING)
            late = reading - way
            if abs(late) < _CUT * scatter:
                log_densities[ping] = max(
                    log_densities[ping], -math.log(_ROOT_TAU * scatter) - 0.5 * (late / scatter) ** 2
                )
    return log_densities


@compiled
def _met(shape: Shape, extent: Extent, place: Point, ray: Point) -> tuple[float, float]:
    """Follow a ray to a feature: how far it goes, if it meets it at all, and the cosine of its incidence."""
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
