"""Surroundings of a wall line: obstacles before it, corners on it, and walls beside it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import directions, intersections, is_blocked
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.map_extraction.segment import CELL, PARALLEL, Segment
from echoplan.joint.search.corner_echoes import Echoes

__all__ = [
    "Beside",
    "CornerOnLine",
    "Obstacles",
    "before_corners",
    "corners_on",
    "fronts_of",
    "is_across",
    "is_copy",
    "is_filled",
    "points_on",
]

# Distance from a line within which a segment belongs to it, and distance from which an object does not stand against
# it [m].
_BEFORE, _DEEPEST = 0.05, 1.0
# Cosine between normals above which walls are more than 5 degrees off a right angle: their corner returns no echo.
_OBLIQUE = math.sin(math.radians(5.0))
# Least number of pings that detect a corner; greatest distance of the corner from the detected part of its wall [m].
_LEAST_PINGS, _AWAY = 5, 1.0
# Distance from a line up to which a corner lies on it [m].
_CORNER_REACH = 0.03


class CornerOnLine(NamedTuple):
    """A detected corner on a line."""

    # Place along the line [m].
    place: float
    # Ends of the wall that may lie there (0 lower, 1 upper): one if the other wall of the corner is known.
    sides: tuple[int, ...]
    # Log-likelihood ratio of the corner against none [nats].
    evidence: float


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Obstacles:
    """Obstacles to the view: wall segments, shape (n, 2, 2), and discs (x, y, radius), shape (c, 3) [m]."""

    segments_xy: FloatArray
    discs: FloatArray

    @classmethod
    def of(cls, segments: Sequence[Segment], discs: FloatArray | None = None, margin: float = 0.0) -> "Obstacles":
        """Return segments and cylinders as obstacles, each extended by a margin [m]."""
        ends = [[each.point(each.low - margin), each.point(each.high + margin)] for each in segments]
        wide = np.zeros((0, 3)) if discs is None else discs + np.array([0.0, 0.0, margin])
        return cls(segments_xy=np.array(ends).reshape(-1, 2, 2), discs=wide)

    def block(self, origins_xy: FloatArray, targets_xy: FloatArray) -> BoolArray:
        """Return which targets are occluded from the origin of the same row, ignoring the last 5 cm."""
        way = targets_xy - origins_xy
        length = np.hypot(*way.T)[:, None]
        ends = origins_xy + way * np.maximum(1.0 - 0.05 / np.maximum(length, 1e-9), 0.0)
        return is_blocked(origins_xy, ends, segments_xy=self.segments_xy, discs=self.discs)


def points_on(line: FloatArray, places: FloatArray) -> FloatArray:
    """Return the points at places along a line [m], shape (n, 2)."""
    points: FloatArray = line[1] * directions(line[0]) + places[:, None] * directions(line[0] + math.pi / 2)
    return points


def fronts_of(line: FloatArray, others: Sequence[Segment]) -> list[tuple[float, float]]:
    """Return stretches along a line [m] before which a wall of an object stands whose back was not detected."""
    near = [each for each in _parallel(line, others) if _BEFORE < each.depth < _DEEPEST]
    backs = [each for each in near if not each.faces_alike]
    return [
        (each.first, each.last)
        for each in near
        if each.faces_alike and not any(back.depth < each.depth and back.overlaps(each) for back in backs)
    ]


def backs_of(line: FloatArray, others: Sequence[Segment]) -> list[tuple[float, float]]:
    """Return stretches along a line [m] behind which a wall stands that faces the same way: the back of a recess."""
    near = [each for each in _parallel(line, others) if -_DEEPEST < each.depth < -_BEFORE]
    return [(each.first, each.last) for each in near if each.faces_alike]


def is_filled(line: FloatArray, low: float, high: float, others: Sequence[Segment]) -> bool:
    """Return True if a wall that faces the same way lies in the line over most of the length between two places [m]."""
    beside = [each for each in _parallel(line, others) if each.faces_alike and abs(each.depth) < _BEFORE]
    return any(min(each.last, high) - max(each.first, low) > 0.5 * (high - low) for each in beside)


def _parallel(line: FloatArray, others: Sequence[Segment]) -> list["Beside"]:
    return [Beside.of(line, each) for each in others if abs(math.cos(each.wall.line[0] - line[0])) > PARALLEL]


class Beside(NamedTuple):
    """A segment parallel to a line."""

    # Distance before the line [m]; negative behind it.
    depth: float
    # Places of its ends along the line [m].
    first: float
    last: float
    # Whether its normal points the same way.
    faces_alike: bool

    @classmethod
    def of(cls, line: FloatArray, other: Segment) -> "Beside":
        """Project a segment onto a line."""
        along = directions(line[0] + math.pi / 2)
        first, last = sorted(float(other.point(each) @ along) for each in (other.low, other.high))
        depth = line[1] - float(other.middle_xy @ directions(line[0]))
        return cls(float(depth), first, last, bool(math.cos(other.wall.line[0] - line[0]) > PARALLEL))

    def overlaps(self, other: "Beside") -> bool:
        """Return True if both share places along the line."""
        return self.first < other.last and other.first < self.last


def is_copy(segment: Segment, other: Segment) -> bool:
    """Return True if at least half of a segment lies beside another one that faces the same way, less than 5 cm off."""
    beside = Beside.of(other.wall.line, segment)
    shared = min(beside.last, other.high) - max(beside.first, other.low)
    return beside.faces_alike and abs(beside.depth) < _BEFORE and shared >= 0.5 * (beside.last - beside.first)


def is_across(segment: Segment, other: Segment) -> bool:
    """Return True if a segment lies across the line of another one where that may be wall.

    The multipath of a corner between a wall and an unmapped object looks like that from two stations.
    """
    if abs(math.cos(segment.wall.line[0] - other.wall.line[0])) > PARALLEL:
        return False
    ends = np.array([segment.point(segment.low), segment.point(segment.high)])
    depths = ends @ directions(other.wall.line[0]) - other.wall.line[1]
    low, high = sorted((ends @ other.along).tolist())
    is_at_wall = np.abs(depths).max() < _BEFORE and other.extension(segment.middle_xy) <= _AWAY
    return bool(is_at_wall and not other.is_free(low - CELL, high + CELL))


def corners_on(number: int, wall: Hypothesis, segments: Sequence[Segment], echoes: Echoes) -> list[CornerOnLine]:
    """Find the detected corners on a line: with known walls that abut on it, and lone corner landmarks."""
    along, normal = directions(wall.line[0] + math.pi / 2), directions(wall.line[0])
    corners = [
        # The wall lies before the other one, whose normal therefore points toward the end at the corner.
        CornerOnLine(
            float(intersections(wall.line, other.wall.line) @ along),
            (int(directions(other.wall.line[0]) @ along > 0.0),),
            echoes.between(number, other.owner).evidence,
        )
        for other in segments
        if other.owner != number and _is_corner(number, wall, other, echoes)
    ]
    places = echoes.corners_xy[np.abs(echoes.corners_xy @ normal - wall.line[1]) < _CORNER_REACH] @ along
    alone = [each for each in places if all(abs(each - known.place) > 2.0 * _CORNER_REACH for known in corners)]
    return [*corners, *(CornerOnLine(float(place), (0, 1), math.inf) for place in alone)]


def _is_corner(number: int, wall: Hypothesis, other: Segment, echoes: Echoes) -> bool:
    """Return True if the corner of a wall and a segment was detected, and the segment may extend to it."""
    if abs(math.cos(wall.line[0] - other.wall.line[0])) > _OBLIQUE:
        return False
    point, echo = intersections(wall.line, other.wall.line), echoes.between(number, other.owner)
    is_detected = echo.evidence >= 0.0 and echo.pings >= _LEAST_PINGS
    return is_detected and other.extension(point) <= _AWAY and not other.is_open_toward(point)


def before_corners(corners: Sequence[CornerOnLine]) -> FloatArray:
    """Return places one cell before corners of two known walls, which are wall [m]."""
    known = [(each.place, each.sides[0]) for each in corners if len(each.sides) == 1]
    return np.array([place + (CELL if side == 0 else -CELL) for place, side in known])
