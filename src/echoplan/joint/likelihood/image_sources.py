"""Image sources: path length, signal excess and density of readings of sound that walls reflect."""

import math
from typing import TypeAlias

from echoplan.acoustics.predicted_echo import SILENCE, Shape, SonarTables, bistatic_excess_of, walk_of
from echoplan.compiled import compiled, inlined
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.kernels import log_gaussian

__all__ = [
    "Extent",
    "Lateness",
    "Motion",
    "Path",
    "Point",
    "after",
    "depth_of",
    "echo_level",
    "farthest_audible",
    "image_of",
    "is_near",
    "lateness",
    "length_of",
    "mirrored",
    "mirroring",
    "strike",
    "turned",
]

# Gate: readings more than this many standard deviations away do not belong to a path.
_CUT = 6.0
# Scale of the logistic detection probability of multipath [dB]. It is greater than that of direct echoes, since the
# signal excess is known less well: humidity alone makes 4 dB over a path of 9 m.
_FADING = 3.0
# Signal excess on the beam axes below which multipath is never detected [dB].
_INAUDIBLE = -15.0
# Direction of the beam axis, as (cosine, sine).
_AHEAD = (1.0, 0.0)
# No airborne sonar detects farther [m]; so many bisections find the greatest depth to a centimetre.
_HORIZON, _HALVINGS = 40.0, 12

# Depth (half of the path length) [m], and angles off the axis at departure and at arrival as (cosine, sine).
Path: TypeAlias = tuple[float, float, float, float, float]
Point: TypeAlias = tuple[float, float]
# Ends of the reflecting part of a wall along its line [m].
Extent: TypeAlias = tuple[float, float]
# Rigid motion: image of the origin, and displacement of an image per unit of x and per unit of y.
Motion: TypeAlias = tuple[Point, Point, Point]
# Least and greatest difference between a reading and the depth of its path [m].
Lateness: TypeAlias = tuple[float, float]


@inlined
def echo_level(tables: SonarTables, path: Path, reading: float, strength: float, scatter: float) -> float:
    """Return the log density of a scaled reading [m] by an echo along a path [log 1/m].

    ``strength`` is that of the echo relative to a plane [dB], ``scatter`` the standard deviation of its readings [m].
    """
    depth = path[0]
    excess = bistatic_excess_of(tables, depth, (path[1], path[2]), (path[3], path[4]), strength)
    if excess == SILENCE:
        return NO_ECHO
    late = reading - depth - walk_of(tables, excess)
    if abs(late) > _CUT * scatter:
        return NO_ECHO
    detected = 1.0 / (1.0 + math.exp(-min(max(excess / _FADING, -30.0), 30.0)))
    return log_gaussian(detected, late, scatter)


@inlined
def lateness(tables: SonarTables, scatter: float) -> Lateness:
    """Return the least and greatest difference of reading and depth for any signal excess: range walk and gate [m]."""
    return tables.walks[0] - _CUT * scatter, tables.walks[1] + _CUT * scatter


@compiled
def farthest_audible(tables: SonarTables) -> float:
    """Return the greatest depth (half of the path length) at which a plane on the axis may be detected [m]."""
    low, high = 0.0, _HORIZON
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        audible = bistatic_excess_of(tables, middle, _AHEAD, _AHEAD, 0.0) > _INAUDIBLE
        low, high = (middle, high) if audible else (low, middle)
    return high


@inlined
def depth_of(wall: Shape, place: Point) -> float:
    """Return the distance of a point before a wall [m]; negative behind it."""
    return wall[3] - wall[1] * place[0] - wall[2] * place[1]


@inlined
def length_of(way: Point) -> float:
    """Return the length of a vector; faster than ``hypot``, which guards against overflow."""
    return math.sqrt(way[0] * way[0] + way[1] * way[1])


@inlined
def mirrored(wall: Shape, place: Point) -> Point:
    """Return the mirror image of a point in a wall [m]."""
    depth = 2.0 * depth_of(wall, place)
    return place[0] + depth * wall[1], place[1] + depth * wall[2]


@inlined
def mirroring(wall: Shape) -> Motion:
    """Return the reflection in a wall as a motion."""
    return after(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), wall)


@inlined
def after(motion: Motion, wall: Shape) -> Motion:
    """Return a motion followed by the reflection in a wall."""
    (x, y), east, north = motion
    zero = mirrored(wall, (x, y))
    right, up = mirrored(wall, (x + east[0], y + east[1])), mirrored(wall, (x + north[0], y + north[1]))
    return zero, (right[0] - zero[0], right[1] - zero[1]), (up[0] - zero[0], up[1] - zero[1])


@inlined
def image_of(motion: Motion, place: Point) -> Point:
    """Apply a motion to a point [m]."""
    zero, right, up = motion
    x = zero[0] + right[0] * place[0] + up[0] * place[1]
    return x, zero[1] + right[1] * place[0] + up[1] * place[1]


@inlined
def is_near(image: Point, place: Point, reading: float, late: Lateness) -> bool:
    """Return True if half the distance from an image to a sensor agrees with a reading [m] within ``late``.

    An infinite reading agrees with none. Squares are compared, which saves the root.
    """
    x, y = image[0] - place[0], image[1] - place[1]
    return max(reading - late[1], 0.0) ** 2 < 0.25 * (x * x + y * y) < (reading - late[0]) ** 2


@inlined
def strike(wall: Shape, extent: Extent, place: Point, way: Point) -> tuple[bool, Point]:
    """Return whether the segment from ``place`` by ``way`` crosses a wall within its extent, and where [m]."""
    slope = wall[1] * way[0] + wall[2] * way[1]
    if abs(slope) < 1e-9:
        return False, place
    share = depth_of(wall, place) / slope
    spot = (place[0] + share * way[0], place[1] + share * way[1])
    return 0.0 < share < 1.0 and extent[0] < wall[1] * spot[1] - wall[2] * spot[0] < extent[1], spot


@inlined
def turned(axis: Point, way: Point) -> Point:
    """Return cosine and sine of the angle from a unit vector to any vector."""
    length = length_of(way) + 1e-12
    return (axis[0] * way[0] + axis[1] * way[1]) / length, (axis[0] * way[1] - axis[1] * way[0]) / length
