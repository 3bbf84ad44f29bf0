"""Volleys: bursts of other sensors, or of the firing before, that come by way of one wall or two.

Sensors that fire together hear each other's bursts; and sound of the firing before that comes back late is taken for an
early echo of this one: by half of what it travels between the two firings too near.
"""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics import Air
from echoplan.acoustics.expectation import Hearing, Shape, shape_of
from echoplan.arrays import FloatArray, IntArray
from echoplan.classification.evidence import UNHEARD
from echoplan.classification.images import Lateness, Point, depth_of, echo_level, lateness, mirrored, strikes, turned
from echoplan.compiled import compiled
from echoplan.preprocessing.soundings import Soundings

__all__ = ["Volleys", "volleys_over"]

# Such readings scatter more than those of reflectors, by this factor.
_SCATTER = 2.0
# Half of the speed of sound that modules assume, as the range scale is told against it [m/s].
_HALF_SPEED = 0.5 * Air().speed_of_sound
_ENDLESS = np.array([-np.inf, np.inf])


class Volleys(NamedTuple):
    """Readings that may be such bursts, wherever they struck the walls.

    Attributes
    ----------
    pings : ndarray of int, shape (h,)
        Which pings; one may have heard several.
    levels : ndarray, shape (h,)
        Logarithm of the density of the reading if it is such an echo [log 1/m].
    places : ndarray, shape (h, w)
        Where along each wall the sound struck it [m].
    """

    pings: IntArray
    levels: FloatArray
    places: FloatArray

    def within(self, extents: FloatArray, count: int) -> FloatArray:
        """Explain readings by those bursts that struck the walls where these are.

        Parameters
        ----------
        extents : ndarray, shape (w, 2)
            Between which places along it each wall may reflect [m].
        count : int
            How many pings there are.

        Returns
        -------
        ndarray, shape (count,)
            Logarithm of the density of each reading [log 1/m]; ``UNHEARD`` where there is no such echo.
        """
        levels = np.full(count, UNHEARD)
        struck = ((extents[:, 0] < self.places) & (self.places < extents[:, 1])).all(axis=1)
        np.maximum.at(levels, self.pings[struck], self.levels[struck])
        return levels


@compiled
def volleys_over(soundings: Soundings, hearing: Hearing, walls: FloatArray, noise: float) -> Volleys:
    """Find the readings that may be bursts not meant for them.

    Parameters
    ----------
    soundings : Soundings
        The pings, with the mates of each.
    hearing : Hearing
        The sonar.
    walls : ndarray, shape (w, 4)
        One wall, or two in the order in which the sound strikes them.
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    Volleys
        The readings.
    """
    walls_in_order = (shape_of(walls[0]), shape_of(walls[-1]), len(walls) > 1)
    near = _nearby(soundings, hearing.scale, walls_in_order, lateness(hearing, _SCATTER * noise))
    levels, places, spots = np.full(len(near), UNHEARD), np.empty((len(near), len(walls))), np.zeros(2)
    for number in range(len(near)):
        ping, beside = near[number]
        ends, travelled = (soundings.mates[ping, beside], ping), _travelled(soundings, hearing.scale, (ping, beside))
        levels[number] = _level(soundings, hearing, ends, walls_in_order, (travelled, noise), spots)
        places[number] = spots[: len(walls)]
    heard = levels > UNHEARD
    return Volleys(near[heard, 0], levels[heard], places[heard])


@compiled
def _nearby(soundings: Soundings, scale: float, walls: tuple[Shape, Shape, bool], late: Lateness) -> IntArray:
    """Find pings, and which of their mates, whose readings are about as long as the way over the walls ahead of them.

    Images are the same motion of every place: one look at three of them saves looking at the walls for each ping.
    """
    zero, east, north = _image(walls, (0.0, 0.0)), _image(walls, (1.0, 0.0)), _image(walls, (0.0, 1.0))
    right, up = (east[0] - zero[0], east[1] - zero[1]), (north[0] - zero[0], north[1] - zero[1])
    near, count = np.empty((soundings.mates.size, 2), np.int64), 0
    for ping in range(len(soundings.readings)):
        if not math.isfinite(soundings.readings[ping]):
            continue
        for beside in range(soundings.mates.shape[1]):
            mate = soundings.mates[ping, beside]
            if mate < 0:
                continue
            x, y, travelled = soundings.x[mate], soundings.y[mate], _travelled(soundings, scale, (ping, beside))
            way_x = zero[0] + right[0] * x + up[0] * y - soundings.x[ping]
            way_y = zero[1] + right[1] * x + up[1] * y - soundings.y[ping]
            ahead = way_x * soundings.ux[ping] + way_y * soundings.uy[ping] > 0.0
            depth_squared = 0.25 * (way_x * way_x + way_y * way_y)
            if ahead and max(travelled - late[1], 0.0) ** 2 < depth_squared < (travelled - late[0]) ** 2:
                near[count, 0], near[count, 1] = ping, beside
                count += 1
    return near[:count]


@compiled
def _travelled(soundings: Soundings, scale: float, heard: tuple[int, int]) -> float:
    """How far a burst of a mate came until the ping's echo: half the way, as readings tell it [m]."""
    reading: float = soundings.readings[heard[0]] * scale
    before: float = soundings.lags[heard[0], heard[1]]
    return reading + _HALF_SPEED * scale * before


@compiled
def _level(
    soundings: Soundings,
    hearing: Hearing,
    ends: tuple[int, int],
    walls: tuple[Shape, Shape, bool],
    heard: tuple[float, float],
    spots: FloatArray,
) -> float:
    """Follow sound from one ping's sensor over the walls to another's; fill in where it strikes them."""
    origin = (soundings.x[ends[0]], soundings.y[ends[0]])
    place = (soundings.x[ends[1]], soundings.y[ends[1]])
    image = _image(walls, origin)
    way = (image[0] - place[0], image[1] - place[1])
    depth = 0.5 * math.hypot(way[0], way[1])
    if min(depth_of(walls[0], origin), depth_of(walls[1], place)) <= 0.0:
        return UNHEARD
    found, spot = _first_spot(walls, origin, place, spots)
    if not found:
        return UNHEARD
    out = turned((soundings.ux[ends[0]], soundings.uy[ends[0]]), (spot[0] - origin[0], spot[1] - origin[1]))
    back = turned((soundings.ux[ends[1]], soundings.uy[ends[1]]), way)
    path = (depth, out[0], out[1], back[0], back[1])
    return echo_level(hearing, path, heard[0], 0.0, _SCATTER * heard[1])


@compiled
def _first_spot(walls: tuple[Shape, Shape, bool], origin: Point, place: Point, spots: FloatArray) -> tuple[bool, Point]:
    """Go back from where sound was heard to where it struck first; fill in where along each wall it did."""
    first, last, double = walls
    image, nearer = _image(walls, origin), mirrored(first, origin)
    way = (image[0] - place[0], image[1] - place[1])
    if not strikes(last, _ENDLESS, place, way):
        return False, place
    spot = _spot(last, place, way)
    spots[1 if double else 0] = last[1] * spot[1] - last[2] * spot[0]
    if not double:
        return True, spot
    onward = (nearer[0] - spot[0], nearer[1] - spot[1])
    if not strikes(first, _ENDLESS, spot, onward):
        return False, spot
    spot = _spot(first, spot, onward)
    spots[0] = first[1] * spot[1] - first[2] * spot[0]
    return True, spot


@compiled
def _image(walls: tuple[Shape, Shape, bool], place: Point) -> Point:
    """Where sound seems to come from after one wall or both."""
    image = mirrored(walls[0], place)
    return mirrored(walls[1], image) if walls[2] else image


@compiled
def _spot(wall: Shape, place: Point, way: Point) -> Point:
    """Where a way from a place meets a wall."""
    share = depth_of(wall, place) / (wall[1] * way[0] + wall[2] * way[1])
    return place[0] + share * way[0], place[1] + share * way[1]
