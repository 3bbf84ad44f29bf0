"""Round walls: the inside of a circular wall, drawn as chords."""

import math
from collections.abc import Iterator, Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import crosses_segments, directions, wrap
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.map_extraction.segment import CELL, Segment
from echoplan.model import Wall

__all__ = ["chords", "lies_on"]

# Greatest angle of a chord; greatest gap between neighbouring specular points that is drawn through [rad].
_LONGEST_CHORD, _WIDEST_GAP = math.radians(15.0), math.radians(45.0)
# A segment whose ends are nearer to a round wall than this is a part of it [m].
_ON_WALL = 0.04


def lies_on(segment: Segment, walls: Sequence[Hypothesis]) -> bool:
    """Return True if both ends of a segment lie on a round wall: then it is a flat part of it, or a second landmark."""
    ends = np.stack([segment.point(segment.low), segment.point(segment.high)])
    off = (np.hypot(*(ends - each.reflector[1:3]).T) - each.reflector[3] for each in walls)
    return any((np.abs(each) < _ON_WALL).all() for each in off)


def chords(feature: Hypothesis, covariance: FloatArray, *, path_xy: FloatArray) -> Iterator[Wall]:
    """Yield a round wall as chords of at most 15 degrees, where it was detected and the robot did not drive through.

    ``covariance`` is that of centre and radius, shape (3, 3) [m^2]; ``path_xy`` is the path of the robot, shape (p, 2)
    [m]. In the mean a chord lies on the wall. Within a chord the wall turns by the angle that the chord spans, and lies
    off it by up to its sagitta: both are part of the covariance of the chord, as uniform distributions. A single
    specular point makes no chord.
    """
    center_xy, radius, history = feature.reflector[1:3], float(feature.reflector[3]), feature.history
    for first, last in _stretches(history.feet):
        if radius * (last - first) < CELL:
            continue
        count = max(math.ceil((last - first) / _LONGEST_CHORD - 1e-9), 1)
        half = 0.5 * (last - first) / count
        # In the mean over its angle, a chord at this distance from the centre is as far from it as the wall.
        depth = radius * math.sin(half) / half
        for normal_angle in first + half * (2 * np.arange(count) + 1):
            normal, along = directions(normal_angle), directions(normal_angle + math.pi / 2)
            middle = center_xy + depth * normal
            ends = middle + depth * math.tan(half) * np.array([[-1.0], [1.0]]) * along
            if crosses_segments(path_xy[:-1], path_xy[1:], ends[None]).any():
                continue
            by_circle, by_turn = np.array([*normal, depth / radius]), np.array([1.0, middle @ along])
            sagitta = radius * (1.0 - math.cos(half))
            variance = by_circle @ covariance @ by_circle + sagitta**2 / 12.0
            share = np.mean(np.abs(wrap(history.feet - normal_angle)) <= half)
            yield Wall(
                normal_angle=float(wrap(normal_angle)),
                offset=float(middle @ normal),
                endpoints_xy=ends,
                covariance=half**2 / 3.0 * np.outer(by_turn, by_turn) + np.diag([0.0, variance]),
                class_probabilities=history.probabilities,
                pings=round(history.pings * share),
                stations=history.supporting,
            )


def _stretches(bearings: FloatArray) -> Iterator[tuple[float, float]]:
    """Yield the first and the last bearing of each stretch without a wide gap, or one whole turn [rad]."""
    ordered = np.sort(bearings)
    after = np.append(ordered[1:], ordered[:1] + 2.0 * math.pi)
    ends = np.flatnonzero(after - ordered > _WIDEST_GAP)
    if len(ordered) and not len(ends):
        yield float(ordered[0]), float(ordered[0]) + 2.0 * math.pi
    for before, end in zip(np.roll(ends, 1), ends, strict=True):
        first = float(after[before])
        yield first, first + float(np.mod(ordered[end] - first, 2.0 * math.pi))
