"""Corners: points where two segments meet and end."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.geometry import directions, intersections
from echoplan.joint.map_extraction.segment import Segment
from echoplan.joint.search.corner_echoes import CornerEcho, Echoes, returns_sound
from echoplan.model import CornerKind
from echoplan.settings import Settings

__all__ = ["CornerSettings", "Vertex", "find_vertices"]


class CornerSettings(Settings):
    """Criteria for two segments to meet."""

    former_keys: ClassVar = {
        "least_turn": "min_angle",
        "overlap": "max_overlap",
        "extension": "max_extension",
        "silent_extension": "max_silent_extension",
        "oblique_extension": "max_oblique_extension",
        "unheard_extension": "max_undetected_extension",
        "unheard_stretch": "max_undetected_ratio",
        "right_angle": "right_angle_tolerance",
        "reach": "max_distance",
        "echoes": "min_echoes",
        "certain": "min_log_odds",
    }

    # Smallest angle between two segments that meet [rad].
    min_angle: ClassVar[float] = math.radians(20)
    # Largest length by which a segment may reach beyond a corner [m].
    max_overlap: ClassVar[float] = 0.08
    max_extension: float = Field(default=3.0, gt=0.0, description="Largest extension of a segment to a corner [m].")
    # Largest extension of a segment to a corner that returns no sound [m].
    max_silent_extension: ClassVar[float] = 2.0
    # Largest extension of a segment to the echo of an oblique corner [m].
    max_oblique_extension: ClassVar[float] = 1.0
    # Largest extension of a segment to a concave corner without echo [m].
    max_undetected_extension: ClassVar[float] = 0.5
    # Largest extension to a concave corner without echo over the observed length.
    max_undetected_ratio: ClassVar[float] = 2.0
    # Largest deviation of a right angle from 90 degrees [rad].
    right_angle_tolerance: ClassVar[float] = math.radians(5)
    # Largest distance of a detected corner from the crossing of its walls [m].
    max_distance: ClassVar[float] = 0.03
    # Smallest number of pings that detect one wall in the other.
    min_echoes: ClassVar[int] = 5
    # Smallest log odds that a corner exists, or does not exist [nats].
    min_log_odds: ClassVar[float] = 5.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Vertex:
    """Point where two segments meet."""

    segments: tuple[int, int]
    # Whether each segment has its upper end there.
    upper: tuple[bool, bool]
    # Position [m], shape (2,).
    position_xy: FloatArray
    # Concave or convex, as seen from the stations.
    kind: CornerKind
    detected: bool
    # Echoes over both of its walls.
    echo: CornerEcho
    # Length by which both segments are extended [m], 10 m less for a detected vertex: the least cost comes first.
    cost: float


def find_vertices(segments: Sequence[Segment], echoes: Echoes, settings: CornerSettings) -> list[Vertex]:
    """Find where segments meet; each end of a segment belongs to one vertex at most, that of the least cost."""
    pairs = ((one, other) for one in range(len(segments)) for other in range(one + 1, len(segments)))
    found = [_vertex(segments, pair, echoes, settings) for pair in pairs]
    vertices: list[Vertex] = []
    taken: set[tuple[int, bool]] = set()
    for vertex in sorted((each for each in found if each is not None), key=lambda each: each.cost):
        ends = set(zip(vertex.segments, vertex.upper, strict=True))
        if not ends & taken:
            vertices.append(vertex)
            taken |= ends
    return vertices


def _vertex(
    segments: Sequence[Segment], pair: tuple[int, int], echoes: Echoes, settings: CornerSettings
) -> Vertex | None:
    one, other = (segments[each] for each in pair)
    if abs(math.sin(one.wall.line[0] - other.wall.line[0])) < math.sin(settings.min_angle):
        return None
    point, kind = intersections(one.wall.line, other.wall.line), _kind(one, other)
    extensions = (one.extension(point), other.extension(point))
    if kind is None or not _reachable((one, other), point, extensions, echoes, settings=settings):
        return None
    echo, detected = echoes.between(one.owner, other.owner), echoes.is_detected_at(point, within=settings.max_distance)
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
    if min(extensions) < -settings.max_overlap or max(extensions) > settings.max_extension:
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
    not exist. The echo of an oblique concave corner is hard to predict, so it may be missed, but it must be near to
    segments that were themselves detected over some length. A convex corner returns hardly any sound.
    """
    if kind is CornerKind.CONCAVE and returns_sound(segments[0].wall.line, segments[1].wall.line):
        return max(extensions) > settings.max_undetected_extension and echo.gain < -settings.min_log_odds
    if max(extensions) > settings.max_silent_extension:
        return True
    if kind is CornerKind.CONVEX:
        return False
    most = [
        max(settings.max_undetected_extension, settings.max_undetected_ratio * (each.high - each.low))
        for each in segments
    ]
    return any(extension > limit for extension, limit in zip(extensions, most, strict=True))


def _ends_before(segment: Segment, point_xy: FloatArray, corners_xy: FloatArray, settings: CornerSettings) -> bool:
    """Return True if a corner was detected on the line of a segment on the way to a point, where the segment ends."""
    on_line = np.abs(corners_xy @ directions(segment.wall.line[0]) - segment.wall.line[1]) < settings.max_distance
    sign = 1.0 if segment.is_upper(point_xy) else -1.0
    start, stop = max(sign * segment.low, sign * segment.high), sign * float(point_xy @ segment.along)
    places = sign * (corners_xy[on_line] @ segment.along)
    return bool(((places > start - settings.max_overlap) & (places < stop - settings.max_distance)).any())


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
    square = abs(math.cos(one.wall.line[0] - other.wall.line[0])) < math.sin(settings.right_angle_tolerance)
    near = square or extension < settings.max_oblique_extension
    return near and (echo.pings >= settings.min_echoes or echo.gain > settings.min_log_odds)
