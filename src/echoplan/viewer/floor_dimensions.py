"""Which lengths a floor plan states, and where: chains outside the building, the rest inside rooms."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import crosses_segments, directions, lines_through
from echoplan.model import FeatureMap
from echoplan.viewer.floor_marks import Dimension
from echoplan.viewer.floor_sheet import FloorSheet
from echoplan.viewer.wording import decimal

__all__ = ["inner_dimensions", "outer_dimensions"]

# Rows of dimension lines outside the walls, and inside rooms [mm].
_ROWS, _INSIDE = (7.0, 14.0), (5.0, 9.0)
# Sides in one direction (cosine of 2 degrees) whose faces are nearer than half a row [mm] share a row of dimensions.
_PARALLEL, _ALIGNED = 0.9994, 4.0
# Shorter walls inside the building, mostly furniture, have no dimension; longer ones have room for any text [mm].
_SHORTEST = 16.0
# A dimension whose ends lie beside those of another one to this [mm] says the same.
_SAME = 2.5
# Start and end of a side of which nothing is unsure.
_NEITHER = (False, False)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Side:
    """A wall or an opening on paper [mm]: its ends, the normal away from the robot, its depth, and what is unsure."""

    ends: FloatArray
    normal: FloatArray
    depth: float
    length: float
    is_inferred: tuple[bool, bool] = _NEITHER
    is_unobserved: tuple[bool, bool] = _NEITHER


def outer_dimensions(
    feature_map: FeatureMap, sheet: FloorSheet, *, outward: FloatArray, depths: FloatArray
) -> Iterator[list[Dimension]]:
    """List the dimensions outside the building, the most important first; each with its possible places.

    Each wall and opening of the outside has its own, in one row with its neighbours; a second row measures all of a
    side that has several.
    """
    runs = _runs(_outer_sides(feature_map, sheet, outward=outward, depths=depths))
    for run in runs:
        for side in run:
            yield _in_rows(side, run)
    for run in runs:
        overall = _overall(run)
        if overall is not None:
            yield _in_rows(overall, run)[1:]


def inner_dimensions(
    feature_map: FeatureMap, sheet: FloorSheet, *, outward: FloatArray, depths: FloatArray, placed: Sequence[Dimension]
) -> list[list[Dimension]]:
    """List dimensions inside rooms, of long walls that no dimension outside measures, the longest first.

    The two faces of a partition have one dimension, with its possible places on both sides.
    """
    walls = _sides(feature_map, sheet, outward=outward, depths=depths)[: len(feature_map.walls)]
    long = [side for side in walls if np.hypot(*(side.ends[1] - side.ends[0])) >= _SHORTEST]
    groups = [[each] for each in placed]
    for side in sorted(long, key=lambda each: -each.length):
        choices = [_beside(side, -away * side.normal) for away in _INSIDE]
        alike = next((group for group in groups if _says_the_same(side, group[0])), None)
        if alike is None:
            groups.append(choices)
        else:
            alike.extend(choices)
    return groups[len(placed) :]


def _sides(feature_map: FeatureMap, sheet: FloorSheet, *, outward: FloatArray, depths: FloatArray) -> list[_Side]:
    """Take walls, and then openings, to the paper."""
    sides = [
        _Side(
            ends=sheet.on_paper(wall.endpoints_xy),
            normal=normal,
            depth=float(depth) * sheet.millimetres,
            length=wall.length,
            is_inferred=tuple((wall.inferred > 0.0).tolist()),
            is_unobserved=tuple(unobserved.tolist()),
        )
        for wall, normal, depth, unobserved in zip(
            feature_map.walls, outward, depths, feature_map.unobserved_ends, strict=True
        )
    ]
    for opening in feature_map.openings:
        ends = sheet.on_paper(opening.endpoints_xy)
        # Beside the wall that it interrupts.
        wall = sides[opening.walls[0]] if opening.walls else None
        normal, depth = (wall.normal, wall.depth) if wall else (directions(lines_through(*ends)[0]), 0.0)
        sides.append(_Side(ends=ends, normal=normal, depth=depth, length=opening.width))
    return sides


def _outer_sides(feature_map: FeatureMap, sheet: FloorSheet, *, outward: FloatArray, depths: FloatArray) -> list[_Side]:
    """List the walls and openings of the outside of the building."""
    sides = _sides(feature_map, sheet, outward=outward, depths=depths)
    unobserved = np.array([each.endpoints_xy for each in feature_map.unobserved]).reshape(-1, 2, 2)
    is_outer = _is_outer(sides, obstacles=sheet.on_paper(unobserved))
    # Behind an opening inside the building all may be free if there is another one opposite.
    for number, opening in enumerate(feature_map.openings, start=len(feature_map.walls)):
        is_outer[number] &= not opening.walls or is_outer[list(opening.walls)].any()
    return [side for side, outer in zip(sides, is_outer, strict=True) if outer]


def _is_outer(sides: Sequence[_Side], *, obstacles: FloatArray) -> BoolArray:
    """Return a mask of the sides of which most is free behind: no wall, opening or stretch as far as the map goes."""
    segments = np.concatenate([np.array([side.ends for side in sides]).reshape(-1, 2, 2), obstacles])
    farthest = float(np.ptp(segments.reshape(-1, 2), axis=0).sum()) if len(segments) else 0.0
    outer = np.zeros(len(sides), dtype=bool)
    for number, side in enumerate(sides):
        # From three places, since a ray may pass through a gap or meet a stray echo.
        starts = side.ends[0] + np.array([[0.1], [0.5], [0.9]]) * (side.ends[1] - side.ends[0])
        ways = crosses_segments(starts, starts + farthest * side.normal, np.delete(segments, number, axis=0))
        outer[number] = ways.any(axis=1).sum() <= 1
    return outer


def _runs(sides: Sequence[_Side]) -> list[list[_Side]]:
    """Group sides that share a row of dimensions; the longest group first."""
    runs = list[list[_Side]]()
    for side in sides:
        level = float(side.ends.mean(axis=0) @ side.normal)
        for run in runs:
            aligned = abs(float(run[0].ends.mean(axis=0) @ run[0].normal) - level) <= _ALIGNED
            if aligned and run[0].normal @ side.normal > _PARALLEL:
                run.append(side)
                break
        else:
            runs.append([side])
    return sorted(runs, key=lambda run: -sum(side.length for side in run))


def _in_rows(side: _Side, run: Sequence[_Side]) -> list[Dimension]:
    """Dimension of a side in the rows outside its run, the nearest first; none if its text does not fit."""
    outermost = max(float((each.ends @ side.normal).max()) + each.depth for each in run)
    level = float(side.ends.mean(axis=0) @ side.normal)
    rows = [_beside(side, (outermost - level + row) * side.normal) for row in _ROWS]
    return [each for each in rows if each.fits]


def _beside(side: _Side, away: FloatArray) -> Dimension:
    """Dimension of a side at a distance from it.

    Lengths that were partly inferred stand in brackets, and those of which an end was not observed are the least.
    """
    text = decimal(side.length, 2)
    text = f"\N{GREATER-THAN OR EQUAL TO} {text}" if any(side.is_unobserved) else text
    return Dimension(ends=side.ends, line=side.ends + away, text=f"({text})" if any(side.is_inferred) else text)


def _overall(run: Sequence[_Side]) -> _Side | None:
    """Join the sides of a run; None if one of them is as long as all."""
    along = directions(np.arctan2(run[0].normal[1], run[0].normal[0]) + np.pi / 2)
    places = np.array([side.ends @ along for side in run])
    first, last = divmod(int(places.argmin()), 2), divmod(int(places.argmax()), 2)
    extent = float(places[last] - places[first])
    if float(np.ptp(places, axis=1).max()) >= extent - _SAME:
        return None
    (one, start), (other, end) = (run[first[0]], first[1]), (run[last[0]], last[1])
    # Per metre on paper, as of any of its sides.
    scale = run[0].length / float(np.hypot(*(run[0].ends[1] - run[0].ends[0])))
    level = float(np.mean([side.ends.mean(axis=0) @ run[0].normal for side in run]))
    ends = np.outer([places[first], places[last]], along) + level * run[0].normal
    return _Side(
        ends=ends,
        normal=run[0].normal,
        depth=0.0,
        length=extent * scale,
        is_inferred=(one.is_inferred[start], other.is_inferred[end]),
        is_unobserved=(one.is_unobserved[start], other.is_unobserved[end]),
    )


def _says_the_same(side: _Side, dimension: Dimension) -> bool:
    """Whether a dimension measures between points that lie beside the ends of a side."""
    way = (side.ends[1] - side.ends[0]) / np.hypot(*(side.ends[1] - side.ends[0]))
    own, others = np.sort(side.ends @ way), np.sort(dimension.ends @ way)
    along = dimension.ends[1] - dimension.ends[0]
    is_parallel = abs(float(along @ way)) > _PARALLEL * float(np.hypot(*along))
    return is_parallel and bool((np.abs(own - others) <= _SAME).all())
