"""Ghosts: echoes of second order, which look like reflectors that are not there.

Sound that went from one wall to another comes as from the image of the image.  It also goes the same way backward, and
both come back to the sensor that sent them together: twice as loud.  Ghosts explain readings for nothing, but are never
missed.
"""

import math

import numpy as np

from echoplan.acoustics.expectation import Hearing, Shape, shape_of
from echoplan.arrays import FloatArray
from echoplan.classification.evidence import UNHEARD
from echoplan.classification.images import (
    Path,
    Point,
    after,
    depth_of,
    echo_level,
    image_of,
    is_near,
    lateness,
    mirrored,
    mirroring,
    strikes,
    turned,
)
from echoplan.compiled import compiled
from echoplan.preprocessing.soundings import Soundings

__all__ = ["ghosts_of_cylinder", "ghosts_of_walls"]

# Paths of second order are known less well than reflectors, so their readings scatter more, by these factors.
_OF_WALLS, _OF_CYLINDER = 1.5, 2.0
_TWOFOLD = 20.0 * math.log10(2.0)
# After so many rounds the spot at which sound glances off a cylinder is found to a millimetre.
_GLANCES = 4


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
    first, second, late = shape_of(walls[0]), shape_of(walls[1]), lateness(hearing, _OF_WALLS * noise)
    motion = after(mirroring(first), second)
    for ping in range(len(levels)):
        reading = soundings.readings[ping] * hearing.scale
        place = (soundings.x[ping], soundings.y[ping])
        image = image_of(motion, place)
        if not is_near(image, place, reading, late):
            continue
        axis = (soundings.ux[ping], soundings.uy[ping])
        found, path = _by_two_walls((place, image), axis, (first, second), extents)
        if found:
            strength = _both_ways(first, second, place, path[0], hearing.wavelength)
            levels[ping] = echo_level(hearing, path, reading, strength, _OF_WALLS * noise)
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
    mirror, screen, late = shape_of(wall), shape_of(cylinder), lateness(hearing, _OF_CYLINDER * noise)
    for ping in range(len(levels)):
        reading = soundings.readings[ping] * hearing.scale
        place = (soundings.x[ping], soundings.y[ping])
        if not math.isfinite(reading) or depth_of(mirror, place) <= 0.0:
            continue
        axis = (soundings.ux[ping], soundings.uy[ping])
        center, unfolded = (screen[1], screen[2]), mirrored(mirror, place)
        # As far as the ways to the centre are long, less the radius: the way over the surface is longer.
        near = math.hypot(center[0] - place[0], center[1] - place[1])
        far = math.hypot(center[0] - unfolded[0], center[1] - unfolded[1])
        longer = reading - 0.5 * (near + far) + screen[3]
        if near < screen[3] + 0.02 or not late[0] < longer < late[1] + screen[3]:
            continue
        spot = _glance(center, screen[3], place, unfolded)
        direct, onward = (spot[0] - place[0], spot[1] - place[1]), (spot[0] - unfolded[0], spot[1] - unfolded[1])
        image = mirrored(mirror, spot)
        depth = 0.5 * (math.hypot(direct[0], direct[1]) + math.hypot(onward[0], onward[1]))
        departure, arrival = turned(axis, direct), turned(axis, (image[0] - place[0], image[1] - place[1]))
        path = (depth, departure[0], departure[1], arrival[0], arrival[1])
        strength = _TWOFOLD + 10.0 * math.log10(max(screen[3], 0.001) / far)
        levels[ping] = echo_level(hearing, path, reading, strength, _OF_CYLINDER * noise)
    return levels


@compiled
def _by_two_walls(
    ends: tuple[Point, Point],
    axis: Point,
    walls: tuple[Shape, Shape],
    extents: tuple[FloatArray, FloatArray],
) -> tuple[bool, Path]:
    """Follow sound from a sensor, which has its image in both walls, to the first, the second, and back, and about."""
    nothing, (place, image) = (0.0, 0.0, 0.0, 0.0, 0.0), ends
    if depth_of(walls[0], place) <= 0.0 or depth_of(walls[1], place) <= 0.0:
        return False, nothing
    depth = 0.5 * math.hypot(image[0] - place[0], image[1] - place[1])
    if depth < 0.02:
        return False, nothing
    other = mirrored(walls[0], mirrored(walls[1], place))
    departure, arrival = (image[0] - place[0], image[1] - place[1]), (other[0] - place[0], other[1] - place[1])
    if not strikes(walls[1], extents[1], place, departure) or not strikes(walls[0], extents[0], place, arrival):
        return False, nothing
    out, back = turned(axis, departure), turned(axis, arrival)
    return True, (depth, out[0], out[1], back[0], back[1])


@compiled
def _both_ways(first: Shape, second: Shape, place: Point, depth: float, wavelength: float) -> float:
    """How much louder than one way over two walls both are together [dB].

    They merge where the walls meet at a right angle: each strikes both walls in the vertex, which reflects half of it.
    Beside it the share grows with Fresnel's parameter, twice the root of what the way over the vertex is longer by, in
    wavelengths (to the first order of his integral).
    """
    across = first[1] * second[2] - first[2] * second[1]
    if abs(across) < 1e-9:
        return _TWOFOLD
    x = (first[3] * second[2] - second[3] * first[2]) / across
    y = (second[3] * first[1] - first[3] * second[1]) / across
    longer = 2.0 * max(math.hypot(x - place[0], y - place[1]) - depth, 0.0)
    return 20.0 * math.log10(1.0 + min(2.0 * math.sqrt(longer / wavelength), 1.0))


@compiled
def _glance(center: Point, radius: float, place: Point, other: Point) -> Point:
    """Where sound glances off a cylinder on its way from one place to another: where its ways make equal angles."""
    spot = center
    for _ in range(_GLANCES):
        to_place, to_other = (place[0] - spot[0], place[1] - spot[1]), (other[0] - spot[0], other[1] - spot[1])
        near, far = math.hypot(to_place[0], to_place[1]), math.hypot(to_other[0], to_other[1])
        x, y = to_place[0] / near + to_other[0] / far, to_place[1] / near + to_other[1] / far
        length = math.hypot(x, y) + 1e-12
        spot = (center[0] + radius * x / length, center[1] + radius * y / length)
    return spot
