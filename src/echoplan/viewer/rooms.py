"""Rooms: areas that walls and openings enclose."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import distances_to_segments
from echoplan.model import FeatureMap, Opening, Wall

if TYPE_CHECKING:
    from shapely import Polygon

__all__ = ["Room", "closed_rooms"]

# Ends of walls that miss each other by less than this meet [m]: nothing passes there, and the ends of walls are known
# to some centimetres.
_MEETS = 0.05
# The jambs of an opening lie between the two faces of a partition, which are hardly farther from each other [m].
_PARTITION = 0.4
# Where nothing says from where a map was recorded, smaller areas are taken for furniture and shafts [m²].
_SMALLEST = 1.0
# Lines are noded on a grid of this size [m], so that ends that only rounding separates still meet.
_GRID = 1e-6


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Room:
    """An area that walls and openings enclose.

    Parameters
    ----------
    polygon : shapely.Polygon
        Its outline; closed bodies inside, such as a shaft, are holes [m].
    is_inferred : bool
        Whether a part of its walls was inferred and not detected.
    """

    polygon: Polygon
    is_inferred: bool

    @property
    def area(self) -> float:
        """Floor area [m²]."""
        return float(self.polygon.area)


def closed_rooms(feature_map: FeatureMap) -> tuple[Room, ...]:
    """Find the rooms of a map in which the robot was, the largest first.

    Only what walls and openings enclose is a room: an unobserved stretch leaves it open.  Of a map without poses
    every enclosed area of at least a square metre is one.
    """
    import shapely  # noqa: PLC0415 - a tenth of a second of import

    strokes = [*(wall.endpoints_xy for wall in feature_map.walls), *_bridges(feature_map)]
    if not strokes:
        return ()
    # Near the origin, so that coordinates of surveyors keep their digits on the grid.
    origin = np.min(strokes, axis=(0, 1))
    lines = shapely.union_all(shapely.linestrings(np.array(strokes) - origin), grid_size=_GRID)
    enclosed = shapely.get_parts(shapely.polygonize(shapely.get_parts(lines)))
    stations = shapely.points(feature_map.poses[:, :2] - origin)
    inferred = shapely.union_all([shapely.LineString(piece - origin) for piece in _inferred(feature_map.walls)])
    rooms = [
        Room(
            polygon=shapely.transform(area, lambda points: points + origin),
            is_inferred=bool(shapely.length(shapely.intersection(inferred, area.boundary.buffer(_GRID * 10))) > _MEETS),
        )
        for area in enclosed
        if (shapely.contains(area, stations).any() if len(stations) else area.area >= _SMALLEST)
    ]
    return tuple(sorted(rooms, key=lambda room: -room.area))


def _bridges(feature_map: FeatureMap) -> Iterator[FloatArray]:
    """Close small gaps between walls, and openings: strokes of shape (2, 2) [m]."""
    faces = np.array([wall.endpoints_xy for wall in feature_map.walls]).reshape(-1, 2, 2)
    for number, face in enumerate(faces):
        others = np.delete(faces, number, axis=0)
        if not len(others):
            continue
        distances = distances_to_segments(face, others)
        for end, nearest, distance in zip(face, distances.argmin(axis=1), distances.min(axis=1), strict=True):
            if distance <= _MEETS:
                yield np.stack([end, _nearest(end, others[nearest])])
    for opening in feature_map.openings:
        yield from _thresholds(opening, feature_map.walls)


def _thresholds(opening: Opening, walls: Sequence[Wall]) -> Iterator[FloatArray]:
    """Close an opening along each face of its walls; along its own line where it has no walls on both sides."""
    jambs = opening.endpoints_xy
    along = (jambs[1] - jambs[0]) / opening.width
    ends = []
    for wall in dict.fromkeys(opening.walls):
        away = np.hypot(*np.moveaxis(walls[wall].endpoints_xy[:, None] - jambs, -1, 0))
        end, jamb = np.unravel_index(away.argmin(), away.shape)
        if away[end, jamb] <= _PARTITION:
            ends.append((int(jamb), walls[wall].endpoints_xy[end]))
    across = [
        np.stack([one, other])
        for (jamb, one), (opposite, other) in combinations(ends, 2)
        if jamb != opposite and abs(along[0] * (other - one)[1] - along[1] * (other - one)[0]) <= _MEETS
    ]
    yield from across
    if not across:
        yield jambs
        yield from (np.stack([end, jambs[jamb]]) for jamb, end in ends)


def _nearest(point_xy: FloatArray, segment: FloatArray) -> FloatArray:
    """Nearest point of a segment, shape (2, 2)."""
    way = segment[1] - segment[0]
    share = np.clip((point_xy - segment[0]) @ way / (way @ way), 0.0, 1.0)
    nearest: FloatArray = segment[0] + share * way
    return nearest


def _inferred(walls: Sequence[Wall]) -> Iterator[FloatArray]:
    """List the pieces of walls that were inferred: strokes of shape (2, 2) [m]."""
    for wall in walls:
        start, end = wall.endpoints_xy
        way = (end - start) / wall.length
        first, last = np.minimum(wall.inferred, wall.length)
        if first > 0.0:
            yield np.stack([start, start + first * way])
        if last > 0.0:
            yield np.stack([end - last * way, end])
