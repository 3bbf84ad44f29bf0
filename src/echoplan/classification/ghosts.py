"""Ghosts: echoes of second order and of other sensors' bursts, which look like reflectors that are not there.

Sound that went from one wall to another comes as from the image of the image; a sensor that fires together with others
hears their bursts by way of the walls, too.  Ghosts explain readings for nothing, but are never missed.
"""

import math
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.expectation import Hearing, Shape, Sight, lobe_excess_of, shape_of, walk_of
from echoplan.arrays import FloatArray
from echoplan.classification.evidence import UNHEARD, audibility
from echoplan.compiled import compiled
from echoplan.preprocessing.soundings import Soundings

__all__ = ["ghosts_of_cylinder", "ghosts_of_volley", "ghosts_of_walls"]

# Readings this far from the geometric depth are no echo on that path [m]: the walk is less.
_CLOSE = 0.1
# Paths of second order are known less well than reflectors, so their readings scatter more, by these factors.
_OF_WALLS, _OF_CYLINDER, _OF_VOLLEY = 1.5, 2.0, 2.0
_CUT = 6.0
_ROOT_TAU = math.sqrt(2.0 * math.pi)

# Depth, and angles at departure and at arrival as (cosine, sine).
_Path: TypeAlias = tuple[float, float, float, float, float]
_Point: TypeAlias = tuple[float, float]


@compiled
def ghosts_of_walls(
    soundings: Soundings,
    hearing: Hearing,
    walls: tuple[FloatArray, FloatArray],
    extents: tuple[FloatArray, FloatArray],
    noise: float,
) -> FloatArray:
    """Explain readings by echoes of one wall in another.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    walls : tuple of ndarray, shape (4,)
        The two walls.
    extents : tuple of ndarray, shape (2,)
        Between which places along it each wall may reflect [m].
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    ndarray, shape (n,)
        Logarithm of the density of each reading if it is such an echo [log 1/m].
    """
    levels = np.full(len(soundings.readings), UNHEARD)
    first, second = shape_of(walls[0]), shape_of(walls[1])
    for ping in range(len(levels)):
        reading = soundings.readings[ping] * hearing.scale
        if not math.isfinite(reading):
            continue
        place = (soundings.x[ping], soundings.y[ping])
        axis = (soundings.ux[ping], soundings.uy[ping])
        found, path = _by_two_walls(place, axis, (first, second), extents, reading)
        if found:
            levels[ping] = _level(hearing, path, reading, 0.0, _OF_WALLS * noise)
    return levels


@compiled
def ghosts_of_cylinder(
    soundings: Soundings, hearing: Hearing, wall: FloatArray, cylinder: FloatArray, noise: float
) -> FloatArray:
    """Explain readings by echoes of a cylinder in a wall.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    wall, cylinder : ndarray, shape (4,)
        The reflectors.
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    ndarray, shape (n,)
        Logarithm of the density of each reading if it is such an echo [log 1/m].
    """
    levels = np.full(len(soundings.readings), UNHEARD)
    mirror, screen = shape_of(wall), shape_of(cylinder)
    image = _mirrored(mirror, (screen[1], screen[2]))
    for ping in range(len(levels)):
        reading = soundings.readings[ping] * hearing.scale
        place = (soundings.x[ping], soundings.y[ping])
        if not math.isfinite(reading) or _depth(mirror, place) <= 0.0:
            continue
        axis = (soundings.ux[ping], soundings.uy[ping])
        direct, from_image = (screen[1] - place[0], screen[2] - place[1]), (image[0] - place[0], image[1] - place[1])
        near, far = math.hypot(direct[0], direct[1]), math.hypot(from_image[0], from_image[1])
        if near < 0.02 or abs(reading + screen[3] - 0.5 * (near + far)) > 2.0 * _CLOSE:
            continue
        unfolded = _mirrored(mirror, place)
        back = (screen[1] - unfolded[0], screen[2] - unfolded[1])
        # The way over a cylinder turns at its surface, where the directions to both ends are halved.
        half = math.sqrt(max(0.5 * (1.0 + (direct[0] * back[0] + direct[1] * back[1]) / (near * far)), 0.0))
        depth = 0.5 * (near + far) - screen[3] * half
        departure, arrival = _turned(axis, direct), _turned(axis, from_image)
        path = (depth, departure[0], departure[1], arrival[0], arrival[1])
        strength = 10.0 * math.log10(max(screen[3], 0.001) / far)
        levels[ping] = _level(hearing, path, reading, strength, _OF_CYLINDER * noise)
    return levels


@compiled
def ghosts_of_volley(
    soundings: Soundings, hearing: Hearing, wall: FloatArray, extent: FloatArray, noise: float
) -> FloatArray:
    """Explain readings by a wall's echoes of bursts that other sensors fired at the same time.

    Parameters
    ----------
    soundings : Soundings
        The pings, with the mates of each.
    hearing : Hearing
        The sonar.
    wall : ndarray, shape (4,)
        The wall.
    extent : ndarray, shape (2,)
        Between which places along it the wall may reflect [m].
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    ndarray, shape (n,)
        Logarithm of the density of each reading if it is such an echo [log 1/m].
    """
    levels, mirror = np.full(len(soundings.readings), UNHEARD), shape_of(wall)
    for ping in range(len(levels)):
        reading = soundings.readings[ping] * hearing.scale
        if not math.isfinite(reading):
            continue
        place, axis = (soundings.x[ping], soundings.y[ping]), (soundings.ux[ping], soundings.uy[ping])
        for mate in soundings.mates[ping]:
            if mate < 0:
                continue
            origin = (soundings.x[mate], soundings.y[mate])
            found, path = _by_one_wall(origin, (soundings.ux[mate], soundings.uy[mate]), place, axis, mirror, extent)
            if found and abs(reading - path[0]) < _CLOSE:
                levels[ping] = max(levels[ping], _level(hearing, path, reading, 0.0, _OF_VOLLEY * noise))
    return levels


@compiled
def _by_two_walls(
    place: _Point,
    axis: _Point,
    walls: tuple[Shape, Shape],
    extents: tuple[FloatArray, FloatArray],
    reading: float,
) -> tuple[bool, _Path]:
    """Follow sound from a sensor to the first wall, the second, and back; and the same the other way about."""
    nothing = (0.0, 0.0, 0.0, 0.0, 0.0)
    if _depth(walls[0], place) <= 0.0 or _depth(walls[1], place) <= 0.0:
        return False, nothing
    image = _mirrored(walls[1], _mirrored(walls[0], place))
    depth = 0.5 * math.hypot(image[0] - place[0], image[1] - place[1])
    if depth < 0.02 or abs(reading - depth) > _CLOSE:
        return False, nothing
    other = _mirrored(walls[0], _mirrored(walls[1], place))
    departure, arrival = (image[0] - place[0], image[1] - place[1]), (other[0] - place[0], other[1] - place[1])
    if not _strikes(walls[1], extents[1], place, departure) or not _strikes(walls[0], extents[0], place, arrival):
        return False, nothing
    out, back = _turned(axis, departure), _turned(axis, arrival)
    return True, (depth, out[0], out[1], back[0], back[1])


@compiled
def _by_one_wall(
    origin: _Point, origin_axis: _Point, place: _Point, axis: _Point, wall: Shape, extent: FloatArray
) -> tuple[bool, _Path]:
    """Follow sound from one sensor to a wall and on to another sensor."""
    nothing = (0.0, 0.0, 0.0, 0.0, 0.0)
    if _depth(wall, origin) <= 0.0 or _depth(wall, place) <= 0.0:
        return False, nothing
    image, own = _mirrored(wall, origin), _mirrored(wall, place)
    arrival, departure = (image[0] - place[0], image[1] - place[1]), (own[0] - origin[0], own[1] - origin[1])
    if not _strikes(wall, extent, place, arrival):
        return False, nothing
    out, back = _turned(origin_axis, departure), _turned(axis, arrival)
    return True, (0.5 * math.hypot(arrival[0], arrival[1]), out[0], out[1], back[0], back[1])


@compiled
def _level(hearing: Hearing, path: _Path, reading: float, strength: float, scatter: float) -> float:
    """Logarithm of the density of a reading as an echo that left and came back at different angles [log 1/m]."""
    depth = path[0]
    leaving: Sight = (depth, path[1], path[2], depth, strength)
    coming: Sight = (depth, path[3], path[4], depth, strength)
    excess = 0.5 * (lobe_excess_of(hearing, leaving) + lobe_excess_of(hearing, coming))
    late = reading - depth - walk_of(hearing, excess)
    if abs(late) > _CUT * scatter:
        return UNHEARD
    return math.log(audibility(excess) / (_ROOT_TAU * scatter)) - 0.5 * (late / scatter) ** 2


@compiled
def _depth(wall: Shape, place: _Point) -> float:
    return wall[3] - wall[1] * place[0] - wall[2] * place[1]


@compiled
def _mirrored(wall: Shape, place: _Point) -> _Point:
    depth = 2.0 * _depth(wall, place)
    return place[0] + depth * wall[1], place[1] + depth * wall[2]


@compiled
def _strikes(wall: Shape, extent: FloatArray, place: _Point, way: _Point) -> bool:
    """Whether the way from a place goes through a wall between two places along it."""
    slope = wall[1] * way[0] + wall[2] * way[1]
    if abs(slope) < 1e-9:
        return False
    share = _depth(wall, place) / slope
    along = wall[1] * (place[1] + share * way[1]) - wall[2] * (place[0] + share * way[0])
    return 0.0 < share < 1.0 and extent[0] < along < extent[1]


@compiled
def _turned(axis: _Point, way: _Point) -> _Point:
    """Cosine and sine of the angle from an axis to a way."""
    length = math.hypot(way[0], way[1]) + 1e-12
    return (axis[0] * way[0] + axis[1] * way[1]) / length, (axis[0] * way[1] - axis[1] * way[0]) / length
