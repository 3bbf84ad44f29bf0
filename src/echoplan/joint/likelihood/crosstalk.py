"""Crosstalk: a ping detects the burst of another sensor, or of the previous firing, over one wall or two.

Sensors that fire together detect each other's bursts. A late echo of the previous firing is taken for an early echo of
this one: it reads too near by half of the distance that sound travels between the two firings.
"""

from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics import Air
from echoplan.acoustics.predicted_echo import Shape, SonarTables, shape_of
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import inlined
from echoplan.joint.likelihood.image_sources import (
    Extent,
    Lateness,
    Motion,
    Path,
    Point,
    after,
    depth_of,
    echo_level,
    farthest_audible,
    image_of,
    is_near,
    lateness,
    length_of,
    mirrored,
    mirroring,
    strike,
    turned,
)
from echoplan.preprocessing.measurements import Measurements

__all__ = ["Emissions", "add_crosstalk", "emissions_of"]

# Ratio of the standard deviation of crosstalk readings to that of direct echoes.
_SCATTER = 2.0
# Half of the speed of sound that range modules assume; the range scale is relative to it [m/s].
_HALF_SPEED = 0.5 * Air().speed_of_sound

# First and last wall, whether they differ, and the motion that takes a source to its image.
Route: TypeAlias = tuple[Shape, Shape, bool, Motion]


class Emissions(NamedTuple):
    """Bursts that pings may detect as crosstalk: b pairs of a ping and a source."""

    # The ping that detects, and the ping that emitted the burst, shape (b,).
    pings: IntArray
    crosstalk_sources: IntArray
    # Half of the path length of the burst at the reading [m], sorted within each station, shape (b,).
    travelled: FloatArray
    # Index of the first burst of each station, and the end of the last, shape (s + 1,).
    bounds: IntArray
    # Greatest distance of an acoustic center from the center of its station [m], shape (s,).
    spread: FloatArray


def emissions_of(measurements: Measurements, tables: SonarTables) -> Emissions:
    """List the pairs of a ping and a crosstalk source whose path is short enough for a detectable echo."""
    stations, centers = measurements.stations, measurements.centers
    away = np.hypot(measurements.x - centers[stations, 0], measurements.y - centers[stations, 1])
    spread = np.zeros(len(centers))
    np.maximum.at(spread, stations, away)
    depths = tables.scale * (measurements.readings[:, None] + _HALF_SPEED * measurements.crosstalk_delays)
    # A ping without an echo has a reading of infinity.
    pings, beside = np.nonzero((measurements.crosstalk_sources >= 0) & (depths < farthest_audible(tables)))
    travelled = depths[pings, beside]
    order = np.lexsort((travelled, stations[pings]))
    pings, beside, travelled = pings[order], beside[order], travelled[order]
    bounds = np.searchsorted(stations[pings], np.arange(len(centers) + 1))
    return Emissions(pings, measurements.crosstalk_sources[pings, beside], travelled, bounds, spread)


@inlined
def add_crosstalk(
    log_densities: FloatArray,
    inputs: tuple[Measurements, SonarTables, Emissions],
    walls: tuple[FloatArray, FloatArray],
    extents: tuple[Extent, Extent],
    noise: float,
) -> None:
    """Raise ``log_densities`` [log 1/m], shape (n,), in place where crosstalk over walls explains a reading better.

    ``walls`` are in the order of reflection; the same wall twice stands for a single reflection. ``extents`` are the
    parts of the walls that may reflect [m].
    """
    measurements, tables, emissions = inputs
    first, last = shape_of(walls[0]), shape_of(walls[1])
    double = first != last
    loss = first[4] + last[4] if double else first[4]
    motion = after(mirroring(first), last) if double else mirroring(first)
    route, scatter = (first, last, double, motion), _SCATTER * noise
    for emission in _nearby(measurements, emissions, motion, lateness(tables, scatter)):
        ping, mate = emissions.pings[emission], emissions.crosstalk_sources[emission]
        ends = (measurements.x[mate], measurements.y[mate]), (measurements.x[ping], measurements.y[ping])
        axes = (measurements.ux[mate], measurements.uy[mate]), (measurements.ux[ping], measurements.uy[ping])
        found, path = _over_walls(ends, axes, route, extents)
        if found:
            level = echo_level(tables, path, emissions.travelled[emission], -loss, scatter)
            log_densities[ping] = max(log_densities[ping], level)


@inlined
def _nearby(measurements: Measurements, emissions: Emissions, motion: Motion, late: Lateness) -> IntArray:
    """Find the bursts whose path is about as long as that over the walls, and whose image is in front of the sensor.

    Half of the path between two sensors differs from that of the station center by at most ``spread``.
    """
    near, count = np.empty(len(emissions.pings), np.int64), 0
    for station in range(len(emissions.spread)):
        center = (measurements.centers[station, 0], measurements.centers[station, 1])
        image, spread = image_of(motion, center), emissions.spread[station]
        depth = 0.5 * length_of((image[0] - center[0], image[1] - center[1]))
        first, last = emissions.bounds[station], emissions.bounds[station + 1]
        low = _first_from(emissions.travelled, (first, last), depth + late[0] - spread)
        high = _first_from(emissions.travelled, (low, last), depth + late[1] + spread)
        for emission in range(low, high):
            ping, mate = emissions.pings[emission], emissions.crosstalk_sources[emission]
            place = (measurements.x[ping], measurements.y[ping])
            image = image_of(motion, (measurements.x[mate], measurements.y[mate]))
            ahead = (image[0] - place[0]) * measurements.ux[ping] + (image[1] - place[1]) * measurements.uy[ping] > 0.0
            if ahead and is_near(image, place, emissions.travelled[emission], late):
                near[count] = emission
                count += 1
    return near[:count]


@inlined
def _first_from(values: FloatArray, bounds: tuple[int, int], least: float) -> int:
    """Return the index of the first sorted value within ``bounds`` that is at least ``least``.

    Unlike ``searchsorted`` it needs no slice of the array.
    """
    low, high = bounds
    while low < high:
        middle = (low + high) // 2
        if values[middle] < least:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def _over_walls(
    ends: tuple[Point, Point], axes: tuple[Point, Point], route: Route, extents: tuple[Extent, Extent]
) -> tuple[bool, Path]:
    """Trace the path from one sensor over the walls to another; return whether it exists, and the path."""
    nothing, (origin, place) = (0.0, 0.0, 0.0, 0.0, 0.0), ends
    image = image_of(route[3], origin)
    way = (image[0] - place[0], image[1] - place[1])
    if min(depth_of(route[0], origin), depth_of(route[1], place)) <= 0.0:
        return False, nothing
    found, spot = _first_spot(route, extents, ends, way)
    if not found:
        return False, nothing
    out, back = turned(axes[0], (spot[0] - origin[0], spot[1] - origin[1])), turned(axes[1], way)
    return True, (0.5 * length_of(way), out[0], out[1], back[0], back[1])


@inlined
def _first_spot(
    route: Route, extents: tuple[Extent, Extent], ends: tuple[Point, Point], way: Point
) -> tuple[bool, Point]:
    """Return whether a path traced back from the sensor meets both walls, and its first reflection point [m]."""
    first, last, double, _ = route
    origin, place = ends
    struck, spot = strike(last, extents[1], place, way)
    if not struck or not double:
        return struck, spot
    nearer = mirrored(first, origin)
    return strike(first, extents[0], spot, (nearer[0] - spot[0], nearer[1] - spot[1]))
