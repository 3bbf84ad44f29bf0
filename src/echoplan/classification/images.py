"""Images: where sound seems to come from that walls reflected, how loud it is and which reading it explains."""

import math
from typing import TypeAlias

from echoplan.acoustics.expectation import Hearing, Shape, Sight, lobe_excess_of, walk_of
from echoplan.arrays import FloatArray
from echoplan.classification.evidence import UNHEARD
from echoplan.compiled import compiled

__all__ = ["Lateness", "Path", "Point", "depth_of", "echo_level", "lateness", "mirrored", "strikes", "turned"]

# Readings farther off than so many deviations are no echo on that path.
_CUT = 6.0
# How loud such sound is, is known less well than that of reflectors: humidity alone makes 4 dB on a way of 9 m.  So
# it fades into silence over more decibels (logistic).
_FADING = 3.0
_ROOT_TAU = math.sqrt(2.0 * math.pi)

# Depth, and angles at departure and at arrival as (cosine, sine).
Path: TypeAlias = tuple[float, float, float, float, float]
Point: TypeAlias = tuple[float, float]
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
    leaving: Sight = (depth, path[1], path[2], depth, strength)
    coming: Sight = (depth, path[3], path[4], depth, strength)
    excess = 0.5 * (lobe_excess_of(hearing, leaving) + lobe_excess_of(hearing, coming))
    late = reading - depth - walk_of(hearing, excess)
    if abs(late) > _CUT * scatter:
        return UNHEARD
    heard = 1.0 / (1.0 + math.exp(-min(max(excess / _FADING, -30.0), 30.0)))
    return math.log(heard / (_ROOT_TAU * scatter)) - 0.5 * (late / scatter) ** 2


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
    return hearing.walk.min() - _CUT * scatter, hearing.walk.max() + _CUT * scatter


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
def strikes(wall: Shape, extent: FloatArray, place: Point, way: Point) -> bool:
    """Whether the way from a place goes through a wall between two places along it.

    Parameters
    ----------
    wall : Shape
        The wall.
    extent : ndarray, shape (2,)
        Places along it [m].
    place, way : Point
        Where the way begins, and how far it goes [m].

    Returns
    -------
    bool
        Whether it does.
    """
    slope = wall[1] * way[0] + wall[2] * way[1]
    if abs(slope) < 1e-9:
        return False
    share = depth_of(wall, place) / slope
    along = wall[1] * (place[1] + share * way[1]) - wall[2] * (place[0] + share * way[0])
    return 0.0 < share < 1.0 and extent[0] < along < extent[1]


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
    length = math.hypot(way[0], way[1]) + 1e-12
    return (axis[0] * way[0] + axis[1] * way[1]) / length, (axis[0] * way[1] - axis[1] * way[0]) / length
