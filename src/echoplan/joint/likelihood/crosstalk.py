"""Volleys: bursts of other sensors, or of the firing before, that come by way of one wall or two.

Sensors that fire together hear each other's bursts; and sound of the firing before that comes back late is taken for an
early echo of this one: by half of what it travels between the two firings too near.
"""

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics import Air
from echoplan.acoustics.predicted_echo import Hearing, Shape, shape_of
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
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

# Such readings scatter more than those of reflectors, by this factor.
_SCATTER = 2.0
# Half of the speed of sound that modules assume, as the range scale is told against it [m/s].
_HALF_SPEED = 0.5 * Air().speed_of_sound

# The first wall and the last, whether they are two, and how they move the image of where sound comes from.
Route: TypeAlias = tuple[Shape, Shape, bool, Motion]


class Emissions(NamedTuple):
    """Emissions that pings may hear though they are not theirs.

    Attributes
    ----------
    pings, crosstalk_sources : ndarray of int, shape (b,)
        Which ping may hear the burst of which.
    travelled : ndarray, shape (b,)
        Half of the way of the burst until the ping's reading [m], in order at each station.
    bounds : ndarray of int, shape (s + 1,)
        Where the bursts of each station begin, and where the last end.
    spread : ndarray, shape (s,)
        How far sensors are from where each station is taken to be [m].
    """

    pings: IntArray
    crosstalk_sources: IntArray
    travelled: FloatArray
    bounds: IntArray
    spread: FloatArray


@compiled
def emissions_of(measurements: Measurements, hearing: Hearing) -> Emissions:
    """List the bursts that pings may hear by way of walls.

    Parameters
    ----------
    measurements : Measurements
        The pings, with the mates of each.
    hearing : Hearing
        The sonar.

    Returns
    -------
    Emissions
        Those of mates, unless they came from too far to be heard.
    """
    size, count, stations = measurements.crosstalk_sources.size, 0, len(measurements.centers)
    pings, crosstalk_sources, travelled = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size)
    bounds, spread, farthest = np.zeros(stations + 1, np.int64), np.zeros(stations), farthest_audible(hearing)
    for ping in range(len(measurements.readings)):
        station, reading = measurements.stations[ping], measurements.readings[ping] * hearing.scale
        x, y = measurements.centers[station]
        spread[station] = max(spread[station], math.hypot(measurements.x[ping] - x, measurements.y[ping] - y))
        for beside in range(measurements.crosstalk_sources.shape[1] if math.isfinite(reading) else 0):
            mate = measurements.crosstalk_sources[ping, beside]
            depth = reading + _HALF_SPEED * hearing.scale * measurements.lags[ping, beside]
            if mate >= 0 and depth < farthest:
                pings[count], crosstalk_sources[count], travelled[count] = ping, mate, depth
                count += 1
        bounds[station + 1] = count
    for station in range(stations):
        bounds[station + 1] = max(bounds[station + 1], bounds[station])
        here = slice(bounds[station], bounds[station + 1])
        order = np.argsort(travelled[here])
        pings[here], crosstalk_sources[here], travelled[here] = (
            pings[here][order],
            crosstalk_sources[here][order],
            travelled[here][order],
        )
    return Emissions(pings[:count].copy(), crosstalk_sources[:count].copy(), travelled[:count].copy(), bounds, spread)


@compiled
def add_crosstalk(
    log_densities: FloatArray,
    detected: tuple[Measurements, Hearing, Emissions],
    walls: tuple[FloatArray, FloatArray],
    extents: tuple[Extent, Extent],
    noise: float,
) -> None:
    """Explain readings by bursts not meant for them.

    Parameters
    ----------
    log_densities : ndarray, shape (n,)
        Logarithm of the density of each reading by what explains it so far [log 1/m]; raised in place where such an
        echo explains it better.
    detected : tuple of Measurements, Hearing and Emissions
        The pings, the sonar, and the bursts that may be heard.
    walls : tuple of ndarray, shape (4,)
        Two walls in the order in which the sound strikes them; twice the same for one alone.
    extents : tuple of Extent
        Between which places along it each wall may reflect [m].
    noise : float
        Standard deviation of readings [m].
    """
    measurements, hearing, emissions = detected
    first, last = shape_of(walls[0]), shape_of(walls[1])
    double = first != last
    motion = after(mirroring(first), last) if double else mirroring(first)
    route, scatter = (first, last, double, motion), _SCATTER * noise
    for emission in _nearby(measurements, emissions, motion, lateness(hearing, scatter)):
        ping, mate = emissions.pings[emission], emissions.crosstalk_sources[emission]
        ends = (measurements.x[mate], measurements.y[mate]), (measurements.x[ping], measurements.y[ping])
        axes = (measurements.ux[mate], measurements.uy[mate]), (measurements.ux[ping], measurements.uy[ping])
        found, path = _over_walls(ends, axes, route, extents)
        if found:
            level = echo_level(hearing, path, emissions.travelled[emission], 0.0, scatter)
            log_densities[ping] = max(log_densities[ping], level)


@compiled
def _nearby(measurements: Measurements, emissions: Emissions, motion: Motion, late: Lateness) -> IntArray:
    """Find the bursts that are read about as far as the way over the walls is long, and come from ahead.

    From sensor to sensor that way differs from the station's own by no more than these are away from it.
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


@compiled
def _first_from(values: FloatArray, bounds: tuple[int, int], least: float) -> int:
    """Find the first of the values in order between two places that is not less: ``searchsorted`` without a slice."""
    low, high = bounds
    while low < high:
        middle = (low + high) // 2
        if values[middle] < least:
            low = middle + 1
        else:
            high = middle
    return low


@compiled
def _over_walls(
    ends: tuple[Point, Point], axes: tuple[Point, Point], route: Route, extents: tuple[Extent, Extent]
) -> tuple[bool, Path]:
    """Follow sound from one sensor over the walls to another."""
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


@compiled
def _first_spot(
    route: Route, extents: tuple[Extent, Extent], ends: tuple[Point, Point], way: Point
) -> tuple[bool, Point]:
    """Go back from where sound was heard to where it struck first, if it struck the walls where these are."""
    first, last, double, _ = route
    origin, place = ends
    struck, spot = strike(last, extents[1], place, way)
    if not struck or not double:
        return struck, spot
    nearer = mirrored(first, origin)
    return strike(first, extents[0], spot, (nearer[0] - spot[0], nearer[1] - spot[1]))
