"""Images: where sound seems to come from that walls reflected, how loud it is and which reading it explains."""

import math
from typing import TypeAlias

from echoplan.acoustics.predicted_echo import SILENCE, Hearing, Shape, bistatic_excess_of, walk_of
from echoplan.compiled import compiled
from echoplan.joint.likelihood.ping_scores import UNHEARD

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

# Readings farther off than so many deviations are no echo on that path.
_CUT = 6.0
# How loud such sound is, is known less well than that of reflectors: humidity alone makes 4 dB on a way of 9 m.  So
# it fades into silence over more decibels (logistic).
_FADING = 3.0
# Of sound that stays this far below the threshold even along the axes, nothing is heard [dB].
_INAUDIBLE = -15.0
_AHEAD = (1.0, 0.0)
# No airborne sonar hears farther [m]; to how far it hears is told to a centimetre.
_HORIZON, _HALVINGS = 40.0, 12
_ROOT_TAU = math.sqrt(2.0 * math.pi)

# Depth, and angles at departure and at arrival as (cosine, sine).
Path: TypeAlias = tuple[float, float, float, float, float]
Point: TypeAlias = tuple[float, float]
# Between which places along it a wall reflects [m].
Extent: TypeAlias = tuple[float, float]
# Image of the origin, and how it moves with x and with y: images are the same motion of every place.
Motion: TypeAlias = tuple[Point, Point, Point]
# How much less and how much more than the depth of its path an echo may be read as [m].
Lateness: TypeAlias = tuple[float, float]


@compiled
def echo_level(hearing: Hearing, path: Path, reading: float, strength: float, scatter: float) -> float:
    """Explain a reading as an echo that left and came back at different angles.

    Parameters
    ----------
    hearing : Hearing
        The sonar.
    path : Path
        Half its length [m], and the angles at both ends.
    reading : float
        The reading, scaled [m].
    strength : float
        Of the echo against that of planes [dB].
    scatter : float
        Standard deviation of such readings [m].

    Returns
    -------
    float
        Logarithm of the density of the reading [log 1/m].
    """
    depth = path[0]
    excess = bistatic_excess_of(hearing, depth, (path[1], path[2]), (path[3], path[4]), strength)
    if excess == SILENCE:
        return UNHEARD
    late = reading - depth - walk_of(hearing, excess)
    if abs(late) > _CUT * scatter:
        return UNHEARD
    detected = 1.0 / (1.0 + math.exp(-min(max(excess / _FADING, -30.0), 30.0)))
    return math.log(detected / (_ROOT_TAU * scatter)) - 0.5 * (late / scatter) ** 2


@compiled
def lateness(hearing: Hearing, scatter: float) -> Lateness:
    """Tell how far readings may be off the depth of a path, whatever their loudness.

    Parameters
    ----------
    hearing : Hearing
        The sonar.
    scatter : float
        Standard deviation of such readings [m].

    Returns
    -------
    Lateness
        The least and the greatest difference of reading and depth [m].
    """
    return hearing.walks[0] - _CUT * scatter, hearing.walks[1] + _CUT * scatter


@compiled
def farthest_audible(hearing: Hearing) -> float:
    """Tell from how deep reflected sound may be heard at all.

    Parameters
    ----------
    hearing : Hearing
        The sonar.

    Returns
    -------
    float
        Half of the way after which even that of a plane along the axes is too faint [m].
    """
    low, high = 0.0, _HORIZON
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        audible = bistatic_excess_of(hearing, middle, _AHEAD, _AHEAD, 0.0) > _INAUDIBLE
        low, high = (middle, high) if audible else (low, middle)
    return high


@compiled
def depth_of(wall: Shape, place: Point) -> float:
    """How far a place lies before a wall; negative behind it.

    Parameters
    ----------
    wall : Shape
        The wall.
    place : Point
        The place [m].

    Returns
    -------
    float
        Distance from its line [m].
    """
    return wall[3] - wall[1] * place[0] - wall[2] * place[1]


@compiled
def length_of(way: Point) -> float:
    """How long a way is.

    Parameters
    ----------
    way : Point
        Along x and y [m].

    Returns
    -------
    float
        Its length [m], without the care that ``hypot`` takes of numbers no room is as large as.
    """
    return math.sqrt(way[0] * way[0] + way[1] * way[1])


@compiled
def mirrored(wall: Shape, place: Point) -> Point:
    """Mirror a place in a wall.

    Parameters
    ----------
    wall : Shape
        The wall.
    place : Point
        The place [m].

    Returns
    -------
    Point
        Its image [m].
    """
    depth = 2.0 * depth_of(wall, place)
    return place[0] + depth * wall[1], place[1] + depth * wall[2]


@compiled
def mirroring(wall: Shape) -> Motion:
    """Mirror every place in a wall.

    Parameters
    ----------
    wall : Shape
        The wall.

    Returns
    -------
    Motion
        From places to their images.
    """
    return after(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)), wall)


@compiled
def after(motion: Motion, wall: Shape) -> Motion:
    """Mirror in a wall what was moved before.

    Parameters
    ----------
    motion : Motion
        What comes first.
    wall : Shape
        The wall.

    Returns
    -------
    Motion
        Both one after the other.
    """
    (x, y), east, north = motion
    zero = mirrored(wall, (x, y))
    right, up = mirrored(wall, (x + east[0], y + east[1])), mirrored(wall, (x + north[0], y + north[1]))
    return zero, (right[0] - zero[0], right[1] - zero[1]), (up[0] - zero[0], up[1] - zero[1])


@compiled
def image_of(motion: Motion, place: Point) -> Point:
    """Move one place.

    Parameters
    ----------
    motion : Motion
        How.
    place : Point
        The place [m].

    Returns
    -------
    Point
        Its image [m].
    """
    zero, right, up = motion
    x = zero[0] + right[0] * place[0] + up[0] * place[1]
    return x, zero[1] + right[1] * place[0] + up[1] * place[1]


@compiled
def is_near(image: Point, place: Point, reading: float, late: Lateness) -> bool:
    """Whether a reading may be of sound that comes from an image; nothing heard is infinitely far.

    Parameters
    ----------
    image, place : Point
        Where the sound seems to come from, and where it is heard [m].
    reading : float
        Half of the way that it has come [m].
    late : Lateness
        How far readings may be off.

    Returns
    -------
    bool
        Whether half of the way from the image is as long, told by squares: no root is taken.
    """
    x, y = image[0] - place[0], image[1] - place[1]
    return max(reading - late[1], 0.0) ** 2 < 0.25 * (x * x + y * y) < (reading - late[0]) ** 2


@compiled
def strike(wall: Shape, extent: Extent, place: Point, way: Point) -> tuple[bool, Point]:
    """Follow the way from a place to a wall.

    Parameters
    ----------
    wall : Shape
        The wall.
    extent : Extent
        Places along it [m].
    place, way : Point
        Where the way begins, and how far it goes [m].

    Returns
    -------
    strikes : bool
        Whether it goes through the wall between two places along it.
    spot : Point
        Where it does [m].
    """
    slope = wall[1] * way[0] + wall[2] * way[1]
    if abs(slope) < 1e-9:
        return False, place
    share = depth_of(wall, place) / slope
    spot = (place[0] + share * way[0], place[1] + share * way[1])
    return 0.0 < share < 1.0 and extent[0] < wall[1] * spot[1] - wall[2] * spot[0] < extent[1], spot


@compiled
def turned(axis: Point, way: Point) -> Point:
    """Turn from an axis to a way.

    Parameters
    ----------
    axis, way : Point
        Unit vector, and any vector.

    Returns
    -------
    Point
        Cosine and sine of the angle between them.
    """
    length = length_of(way) + 1e-12
    return (axis[0] * way[0] + axis[1] * way[1]) / length, (axis[0] * way[1] - axis[1] * way[0]) / length
