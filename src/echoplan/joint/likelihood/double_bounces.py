"""Double bounces: echoes over two landmarks, which look like landmarks that do not exist.

Sound that two walls reflect seems to come from the image of the image of the sensor. It also travels the same path
backward, and both waves add coherently at the sensor: 6 dB. Where both paths would pass beside the vertex of a corner a
little wider than a right angle, the vertex still returns part of the sound by diffraction. Double bounces explain
readings, but their absence is no evidence against a landmark.
"""

import math

import numpy as np

from echoplan.acoustics.predicted_echo import Shape, SonarTables, shape_of
from echoplan.arrays import FloatArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.likelihood.image_sources import (
    Extent,
    Path,
    Point,
    after,
    depth_of,
    echo_level,
    image_of,
    is_near,
    lateness,
    length_of,
    mirrored,
    mirroring,
    strike,
    turned,
)
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.preprocessing.measurements import Measurements

__all__ = ["add_ghosts_of_cylinder", "add_ghosts_of_walls", "ghosts_of_walls"]

# Ratio of the standard deviation of readings to that of direct echoes, since these paths are known less well.
_OF_WALLS, _OF_CYLINDER = 1.5, 2.0
# Coherent sum of both directions of a path [dB].
_TWOFOLD = 20.0 * math.log10(2.0)
# Term of the knife-edge formula of ITU-R P.526 at grazing incidence (v = 0).
_GRAZING = math.sqrt(1.01) - 0.1
# A wall whose extent was enlarged reaches less than this beyond its true end [m].
_BEYOND = 0.5
# Iterations that find the reflection point on a cylinder to a millimetre.
_ITERATIONS = 4


@compiled
def ghosts_of_walls(
    measurements: Measurements,
    tables: SonarTables,
    walls: tuple[FloatArray, FloatArray],
    extents: tuple[Extent, Extent],
    noise: float,
) -> FloatArray:
    """Return the log density of each reading by double bounces between two walls [log 1/m]; ``NO_ECHO`` elsewhere."""
    log_densities = np.full(len(measurements.readings), NO_ECHO)
    add_ghosts_of_walls(log_densities, (measurements, tables), walls, extents, noise)
    return log_densities


@inlined
def add_ghosts_of_walls(
    log_densities: FloatArray,
    inputs: tuple[Measurements, SonarTables],
    walls: tuple[FloatArray, FloatArray],
    extents: tuple[Extent, Extent],
    noise: float,
) -> None:
    """Raise ``log_densities`` [log 1/m], shape (n,), in place where double bounces of walls explain a reading better.

    ``extents`` are the parts of the walls that may reflect, along their lines [m].
    """
    measurements, tables = inputs
    shapes, scatter = (shape_of(walls[0]), shape_of(walls[1])), _OF_WALLS * noise
    # In a corner wider than a right angle no path over both walls returns to its origin.
    if shapes[0][1] * shapes[1][1] + shapes[0][2] * shapes[1][2] > 0.0:
        _add_vertex(log_densities, measurements, tables, shapes, extents, scatter)
    else:
        _add_images(log_densities, measurements, tables, shapes, extents, scatter)


@inlined
def add_ghosts_of_cylinder(
    log_densities: FloatArray,
    inputs: tuple[Measurements, SonarTables],
    wall: FloatArray,
    cylinder: FloatArray,
    noise: float,
) -> None:
    """Raise ``log_densities`` [log 1/m] in place where a path over a wall and a cylinder explains a reading better."""
    measurements, tables = inputs
    mirror, screen, late = shape_of(wall), shape_of(cylinder), lateness(tables, _OF_CYLINDER * noise)
    center = (screen[1], screen[2])
    for ping in range(len(log_densities)):
        reading = measurements.readings[ping] * tables.scale
        place = (measurements.x[ping], measurements.y[ping])
        if not math.isfinite(reading) or depth_of(mirror, place) <= 0.0:
            continue
        unfolded = mirrored(mirror, place)
        near = length_of((center[0] - place[0], center[1] - place[1]))
        # Gate by the path over the center: the path over the surface is shorter by at most the radius.
        shorter = (late[0] - screen[3], late[1])
        if near < screen[3] + 0.02 or not is_near(center, unfolded, reading - 0.5 * near, shorter):
            continue
        spot = _reflection_point(center, screen[3], place, unfolded)
        direct, onward = (spot[0] - place[0], spot[1] - place[1]), (spot[0] - unfolded[0], spot[1] - unfolded[1])
        depth = 0.5 * (length_of(direct) + length_of(onward))
        if not late[0] < reading - depth < late[1]:
            continue
        image, axis = mirrored(mirror, spot), (measurements.ux[ping], measurements.uy[ping])
        departure, arrival = turned(axis, direct), turned(axis, (image[0] - place[0], image[1] - place[1]))
        path = (depth, departure[0], departure[1], arrival[0], arrival[1])
        far = length_of((center[0] - unfolded[0], center[1] - unfolded[1]))
        strength = _TWOFOLD + 10.0 * math.log10(max(screen[3], 0.001) / far) - mirror[4]
        log_densities[ping] = max(
            log_densities[ping], echo_level(tables, path, reading, strength, _OF_CYLINDER * noise)
        )


@inlined
def _add_images(
    log_densities: FloatArray,
    measurements: Measurements,
    tables: SonarTables,
    walls: tuple[Shape, Shape],
    extents: tuple[Extent, Extent],
    scatter: float,
) -> None:
    """Raise log densities in place by double bounces that come from the image of the image."""
    motion, (crossing, vertex) = after(mirroring(walls[0]), walls[1]), _crossing(walls)
    late, loss = lateness(tables, scatter), walls[0][4] + walls[1][4]
    for ping in range(len(log_densities)):
        reading = measurements.readings[ping] * tables.scale
        place = (measurements.x[ping], measurements.y[ping])
        image = image_of(motion, place)
        if not is_near(image, place, reading, late) or not _faces(walls, place):
            continue
        axis = (measurements.ux[ping], measurements.uy[ping])
        found, path = _by_two_walls((place, image), axis, walls, extents)
        if found:
            passing = _passing(vertex, place, image, tables.wavelength) if crossing else math.inf
            level = echo_level(tables, path, reading, 20.0 * math.log10(1.0 + min(passing, 1.0)) - loss, scatter)
            log_densities[ping] = max(log_densities[ping], level)


@inlined
def _add_vertex(
    log_densities: FloatArray,
    measurements: Measurements,
    tables: SonarTables,
    walls: tuple[Shape, Shape],
    extents: tuple[Extent, Extent],
    scatter: float,
) -> None:
    """Raise log densities in place by diffraction at the vertex of two walls."""
    motion, (crossing, vertex) = after(mirroring(walls[0]), walls[1]), _crossing(walls)
    if not crossing or not _is_concave(walls, extents, vertex):
        return
    late, loss = lateness(tables, scatter), walls[0][4] + walls[1][4]
    for ping in range(len(log_densities)):
        reading = measurements.readings[ping] * tables.scale
        place = (measurements.x[ping], measurements.y[ping])
        beyond = (2.0 * vertex[0] - place[0], 2.0 * vertex[1] - place[1])
        if is_near(beyond, place, reading, late) and _faces(walls, place):
            path = _straight((measurements.ux[ping], measurements.uy[ping]), place, vertex)
            passing = _passing(vertex, place, image_of(motion, place), tables.wavelength)
            level = echo_level(tables, path, reading, -_faded(passing) - loss, scatter)
            log_densities[ping] = max(log_densities[ping], level)


@inlined
def _faces(walls: tuple[Shape, Shape], place: Point) -> bool:
    """Return True if a point lies before both walls."""
    return depth_of(walls[0], place) > 0.0 and depth_of(walls[1], place) > 0.0


@inlined
def _by_two_walls(
    ends: tuple[Point, Point],
    axis: Point,
    walls: tuple[Shape, Shape],
    extents: tuple[Extent, Extent],
) -> tuple[bool, Path]:
    """Trace the path from a sensor over both walls back to it; return whether it exists, and the path.

    ``ends`` are the sensor and its image in both walls [m].
    """
    nothing, (place, image) = (0.0, 0.0, 0.0, 0.0, 0.0), ends
    depth = 0.5 * length_of((image[0] - place[0], image[1] - place[1]))
    if depth < 0.02:
        return False, nothing
    other = mirrored(walls[0], mirrored(walls[1], place))
    departure, arrival = (image[0] - place[0], image[1] - place[1]), (other[0] - place[0], other[1] - place[1])
    if not strike(walls[1], extents[1], place, departure)[0] or not strike(walls[0], extents[0], place, arrival)[0]:
        return False, nothing
    out, back = turned(axis, departure), turned(axis, arrival)
    return True, (depth, out[0], out[1], back[0], back[1])


@inlined
def _crossing(walls: tuple[Shape, Shape]) -> tuple[bool, Point]:
    """Return whether two lines cross, and where [m]."""
    first, second = walls
    across = first[1] * second[2] - first[2] * second[1]
    if abs(across) < 1e-9:
        return False, (0.0, 0.0)
    x = (first[3] * second[2] - second[3] * first[2]) / across
    y = (second[3] * first[1] - first[3] * second[1]) / across
    return True, (x, y)


@inlined
def _is_concave(walls: tuple[Shape, Shape], extents: tuple[Extent, Extent], vertex: Point) -> bool:
    """Return True if two walls reach their crossing, and each lies before the other."""
    for own in range(2):
        wall, (low, high), other = walls[own], extents[own], walls[1 - own]
        if not low < wall[1] * vertex[1] - wall[2] * vertex[0] < high:
            return False
        # One line may hold walls on both sides of the other wall: then one of them lies before it.
        farthest = max(depth_of(other, _point(wall, low)), depth_of(other, _point(wall, high)))
        if farthest < _BEYOND and depth_of(other, _point(wall, 0.5 * (low + high))) <= 0.0:
            return False
    return True


@inlined
def _point(wall: Shape, place: float) -> Point:
    """Return the point at a position along a wall [m]."""
    return wall[3] * wall[1] - place * wall[2], wall[3] * wall[2] + place * wall[1]


@inlined
def _passing(vertex: Point, place: Point, image: Point, wavelength: float) -> float:
    """Return Fresnel's parameter v of a double bounce beside a vertex.

    It is twice the root of the excess length of the path over the vertex, in wavelengths. At a right angle both paths
    meet both walls in the vertex, which reflects half of each. Beside it the reflected share grows, or fades where the
    paths would pass beyond the walls.
    """
    over = 2.0 * length_of((vertex[0] - place[0], vertex[1] - place[1]))
    longer = over - length_of((image[0] - place[0], image[1] - place[1]))
    return 2.0 * math.sqrt(max(longer, 0.0) / wavelength)


@inlined
def _faded(passing: float) -> float:
    """Return the loss of sound that passes behind a vertex, relative to the echo of the vertex [dB] (ITU-R P.526)."""
    beyond = passing - 0.1
    return 20.0 * math.log10((math.sqrt(beyond * beyond + 1.0) + beyond) / _GRAZING)


@inlined
def _straight(axis: Point, place: Point, point: Point) -> Path:
    """Return the path to a point and back."""
    way = (point[0] - place[0], point[1] - place[1])
    cosine, sine = turned(axis, way)
    return length_of(way), cosine, sine, cosine, sine


@inlined
def _reflection_point(center: Point, radius: float, place: Point, other: Point) -> Point:
    """Return the reflection point on a cylinder between two points [m], by iteration to equal angles of both paths."""
    spot = center
    for _ in range(_ITERATIONS):
        to_place, to_other = (place[0] - spot[0], place[1] - spot[1]), (other[0] - spot[0], other[1] - spot[1])
        near, far = length_of(to_place), length_of(to_other)
        x, y = to_place[0] / near + to_other[0] / far, to_place[1] / near + to_other[1] / far
        length = length_of((x, y)) + 1e-12
        spot = (center[0] + radius * x / length, center[1] + radius * y / length)
    return spot
