"""Corners: points where two segments meet and end."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray
from echoplan.geometry import directions, intersections
from echoplan.joint.map_extraction.segment import Segment
from echoplan.joint.search.specular_points import CornerEcho, Echoes, returns_sound
from echoplan.model import CornerKind

__all__ = ["CornerSettings", "Vertex", "find_vertices"]


class CornerSettings(BaseModel, frozen=True, extra="forbid"):
    """Criteria for two segments to meet."""

    least_turn: float = Field(default=math.radians(20), gt=0.0, description="between two segments that meet [rad]")
    overlap: float = Field(default=0.08, ge=0.0, description="that a segment may reach past its end [m]")
    extension: float = Field(default=3.0, gt=0.0, description="of a segment beyond what was heard of it [m]")
    silent_extension: float = Field(default=2.0, gt=0.0, description="likewise, to a corner that returns no sound [m]")
    oblique_extension: float = Field(default=1.0, gt=0.0, description="to the echo of a corner of no right angle [m]")
    unheard_extension: float = Field(default=0.5, gt=0.0, description="to a concave corner that nobody heard [m]")
    unheard_stretch: float = Field(default=2.0, gt=0.0, description="or as far as so many times what was heard of it")
    right_angle: float = Field(default=math.radians(5), gt=0.0, description="what counts as one [rad]")
    reach: float = Field(default=0.03, gt=0.0, description="of a heard corner from the crossing of its walls [m]")
    echoes: int = Field(default=5, ge=1, description="pings that hear one wall in the other")
    certain: float = Field(default=5.0, gt=0.0, description="evidence that a corner is there, or is not [nats]")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Vertex:
    """Point where two segments meet.

    Parameters
    ----------
    segments : tuple of int
        Indices of both segments.
    upper : tuple of bool
        Whether each segment has its upper end there.
    position_xy : ndarray, shape (2,)
        Position [m].
    kind : CornerKind
        Concave or convex, as seen from the stations.
    detected : bool
        Whether it was detected.
    echo : CornerEcho
        Echoes over both of its walls.
    cost : float
        Length by which both segments are extended [m], 10 m less for a detected vertex: the least cost comes first.
    """

    segments: tuple[int, int]
    upper: tuple[bool, bool]
    position_xy: FloatArray
    kind: CornerKind
    detected: bool
    echo: CornerEcho
    cost: float


def find_vertices(segments: Sequence[Segment], echoes: Echoes, settings: CornerSettings) -> list[Vertex]:
    """Find where segments meet; each end of a segment belongs to one vertex at most, that of the least cost."""
    pairs = ((one, other) for one in range(len(segments)) for other in range(one + 1, len(segments)))
    found = [_vertex(segments, pair, echoes, settings) for pair in pairs]
    vertices: list[Vertex] = []
    taken: set[tuple[int, bool]] = set()
    apart = [each for each in found if each is not None and not _goes_over_another(segments, each)]
    for vertex in sorted(apart, key=lambda each: each.cost):
        ends = set(zip(vertex.segments, vertex.upper, strict=True))
        if not ends & taken:
            vertices.append(vertex)
            taken |= ends
    return vertices


def _vertex(
    segments: Sequence[Segment], pair: tuple[int, int], echoes: Echoes, settings: CornerSettings
) -> Vertex | None:
    one, other = (segments[each] for each in pair)
    if abs(math.sin(one.wall.line[0] - other.wall.line[0])) < math.sin(settings.least_turn):
        return None
    point, kind = intersections(one.wall.line, other.wall.line), _kind(one, other)
    extensions = (one.extension(point), other.extension(point))
    if kind is None or not _reachable((one, other), point, extensions, echoes, settings=settings):
        return None
    echo, detected = echoes.between(one.owner, other.owner), echoes.is_detected_at(point, within=settings.reach)
    if kind is CornerKind.CONCAVE:
        detected |= _is_detected(one, other, max(extensions), echo, settings)
    if not detected and _is_far_fetched((one, other), extensions, kind, echo, settings):
        return None
    return Vertex(
        segments=pair,
        upper=(one.is_upper(point), other.is_upper(point)),
        position_xy=point,
        kind=kind,
        detected=detected,
        echo=echo,
        cost=_cost(extensions, detected=detected),
    )


def _goes_over_another(segments: Sequence[Segment], vertex: Vertex) -> bool:
    """Return True if a segment would be extended across another one of its line."""
    for segment in (segments[each] for each in vertex.segments):
        place = float(vertex.position_xy @ segment.along)
        others = [each for each in segments if each.owner == segment.owner and each is not segment]
        if any(segment.high <= each.low < place or place < each.high <= segment.low for each in others):
            return True
    return False


def _cost(extensions: Sequence[float], *, detected: bool) -> float:
    return sum(max(each, 0.0) for each in extensions) - (10.0 if detected else 0.0)


def _reachable(
    segments: tuple[Segment, Segment],
    point_xy: FloatArray,
    extensions: Sequence[float],
    echoes: Echoes,
    *,
    settings: CornerSettings,
) -> bool:
    """Return True if a crossing is near an end of both segments and the stretches between may be wall."""
    if min(extensions) < -settings.overlap or max(extensions) > settings.extension:
        return False
    return not any(
        segment.is_open_toward(point_xy) or _ends_before(segment, point_xy, echoes.corners_xy, settings)
        for segment in segments
    )


def _is_far_fetched(
    segments: tuple[Segment, Segment],
    extensions: Sequence[float],
    kind: CornerKind,
    echo: CornerEcho,
    settings: CornerSettings,
) -> bool:
    """Return True if segments would be extended too far to a vertex that was not detected.

    A concave right angle returns sound to wherever it comes from. If it should have been detected and was not, it does
    not
    exist. The echo of an oblique concave corner is hard to predict, so it may be missed, but it must be near to
    segments
    that were themselves detected over some length. A convex corner returns hardly any sound.
    """
    if kind is CornerKind.CONCAVE and returns_sound(segments[0].wall.line, segments[1].wall.line):
        return max(extensions) > settings.unheard_extension and echo.gain < -settings.certain
    if max(extensions) > settings.silent_extension:
        return True
    if kind is CornerKind.CONVEX:
        return False
    most = [max(settings.unheard_extension, settings.unheard_stretch * (each.high - each.low)) for each in segments]
    return any(extension > limit for extension, limit in zip(extensions, most, strict=True))


def _ends_before(segment: Segment, point_xy: FloatArray, corners_xy: FloatArray, settings: CornerSettings) -> bool:
    """Return True if a corner was detected on the line of a segment on the way to a point, where the segment ends."""
    on_line = np.abs(corners_xy @ directions(segment.wall.line[0]) - segment.wall.line[1]) < settings.reach
    sign = 1.0 if segment.is_upper(point_xy) else -1.0
    start, stop = max(sign * segment.low, sign * segment.high), sign * float(point_xy @ segment.along)
    places = sign * (corners_xy[on_line] @ segment.along)
    return bool(((places > start - settings.overlap) & (places < stop - settings.reach)).any())


def _kind(one: Segment, other: Segment) -> CornerKind | None:
    """Return concave if each segment lies before the other, convex if behind, None if they cannot be of one body."""
    before = [
        first.wall.line[1] - float(directions(first.wall.line[0]) @ second.middle_xy)
        for first, second in ((one, other), (other, one))
    ]
    if before[0] * before[1] < 0.0 and min(abs(each) for each in before) > 0.05:
        return None
    return CornerKind.CONCAVE if before[0] > 0.0 else CornerKind.CONVEX


def _is_detected(one: Segment, other: Segment, extension: float, echo: CornerEcho, settings: CornerSettings) -> bool:
    square = abs(math.cos(one.wall.line[0] - other.wall.line[0])) < math.sin(settings.right_angle)
    near = square or extension < settings.oblique_extension
    return near and (echo.pings >= settings.echoes or echo.gain > settings.certain)
