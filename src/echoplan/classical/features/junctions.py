"""Junctions: where neighbouring walls meet, and so how far they go."""

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import along, directions, intersections, signed_distances
from echoplan.model import CornerKind

__all__ = ["Junction", "Span", "junctions", "settle"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Span:
    """A stretch of a line.

    Parameters
    ----------
    line : ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m], the normal away from the side from which it was observed.
    low, high : float
        Coordinates along the line [m].
    """

    line: FloatArray
    low: float
    high: float

    @property
    def middle_xy(self) -> FloatArray:
        """Point halfway [m], shape (2,)."""
        return self.point_xy((self.low + self.high) / 2)

    def point_xy(self, coordinate: float) -> FloatArray:
        """Point at a coordinate along the line.

        Parameters
        ----------
        coordinate : float
            Coordinate along the line [m].

        Returns
        -------
        ndarray, shape (2,)
            The point [m].
        """
        normal, tangent = directions(self.line[0]), directions(self.line[0] + np.pi / 2)
        point: FloatArray = self.line[1] * normal + coordinate * tangent
        return point


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Junction:
    """Two spans that meet at their ends.

    Parameters
    ----------
    first, second : int
        Numbers of the spans.
    first_at_high, second_at_high : bool
        At which end of each.
    position_xy : ndarray, shape (2,)
        Where their lines cross [m].
    extension, longest : float
        By how much both together, and the one that is farther off, must be lengthened to meet [m].
    kind : CornerKind
        Whether the corner is concave or convex as seen by the sonar.
    """

    first: int
    second: int
    first_at_high: bool
    second_at_high: bool
    position_xy: FloatArray
    extension: float
    longest: float
    kind: CornerKind

    @property
    def ends(self) -> tuple[tuple[int, bool], tuple[int, bool]]:
        """Which ends meet: number of the span, and whether it is the high end."""
        return (self.first, self.first_at_high), (self.second, self.second_at_high)


def junctions(spans: list[Span], *, max_extension: float, min_turn: float = np.radians(20)) -> list[Junction]:
    """Find where spans can meet.

    Parameters
    ----------
    spans : list of Span
        Walls as far as they were detected.
    max_extension : float
        How far an end may be from the crossing [m].
    min_turn : float, optional
        Least angle between two lines that meet [rad]: flatter crossings are ill-determined.

    Returns
    -------
    list of Junction
        The nearest meetings first; an end may occur in several.
    """
    pairs = combinations(range(len(spans)), 2)
    found = (_meeting(pair, spans, max_extension=max_extension, min_turn=min_turn) for pair in pairs)
    return sorted((each for each in found if each is not None), key=lambda each: each.extension)


def settle(meetings: list[Junction]) -> list[Junction]:
    """Let each end of a wall meet one other.

    Parameters
    ----------
    meetings : list of Junction
        Possible meetings, the more trusted first.

    Returns
    -------
    list of Junction
        Those whose ends none of the earlier ones took.
    """
    chosen: list[Junction] = []
    taken: set[tuple[int, bool]] = set()
    for meeting in meetings:
        if not taken & set(meeting.ends):
            taken |= set(meeting.ends)
            chosen.append(meeting)
    return chosen


def _meeting(pair: tuple[int, int], spans: list[Span], *, max_extension: float, min_turn: float) -> Junction | None:
    first, second = spans[pair[0]], spans[pair[1]]
    if abs(np.sin(first.line[0] - second.line[0])) < np.sin(min_turn):
        return None
    position = intersections(first.line, second.line)
    places = [float(along(span.line, position)) for span in (first, second)]
    # How far beyond the nearer end of each span the crossing lies [m]; negative inside.
    gaps = [max(span.low - place, place - span.high) for span, place in zip((first, second), places, strict=True)]
    # A crossing may also lie inside a span, because ends are uncertain: by a tenth of the shorter span.
    max_overlap = 0.1 * min(first.high - first.low, second.high - second.low)
    kind = _kind(first, second)
    if kind is None or max(gaps) > max_extension or min(gaps) < -max_overlap:
        return None
    return Junction(
        first=pair[0],
        second=pair[1],
        first_at_high=places[0] > (first.low + first.high) / 2,
        second_at_high=places[1] > (second.low + second.high) / 2,
        position_xy=position,
        extension=sum(max(gap, 0.0) for gap in gaps),
        longest=max(*gaps, 0.0),
        kind=kind,
    )


def _kind(first: Span, second: Span) -> CornerKind | None:
    """Concave if each wall lies on the side from which the other was observed, convex if on the far side of it."""
    sides = (
        float(signed_distances(first.line, second.middle_xy)),
        float(signed_distances(second.line, first.middle_xy)),
    )
    if max(sides) <= 0:
        return CornerKind.CONCAVE
    return CornerKind.CONVEX if min(sides) >= 0 else None
