"""The true openings of a floor plan: doorways, derived from the true walls."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from echoplan.arrays import FloatArray, IntArray, checked_floats, store
from echoplan.geometry import along, crosses_segments, distances_to_segments, feet, is_blocked, lines_through
from echoplan.model import EVERYWHERE, Truth

__all__ = ["Doorway", "count_stations", "true_doorways"]

# Two walls are on one line if they differ by less than this [m, rad]: files round, and rooms are built to a centimetre.
_OFFSET, _ANGLE = 0.01, np.radians(1.0)
# A door of a cupboard is narrower, the side of a room that is open altogether wider [m].
_WIDTHS = (0.4, 3.0)
# The faces of a wall are at most so far apart [m].
_THICKNESS = 0.4
# So far to both sides of the gap there is free space, beyond the thickest wall [m], and it is so much wider [m].
_BEHIND, _WIDER = 0.5, 0.1
# Walls that come so near to each other are connected [m]: corners of a surveyed plan may be open by some centimetres.
_CONNECTED = 0.05
# The ends of the gap, where jambs begin, are left out of the test whether it is free [m].
_JAMB = 2 * _OFFSET


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Doorway:
    """A true opening.

    Parameters
    ----------
    faces_xy : ndarray, shape (f, 2, 2)
        Gap in each face of the wall: face, start or end, x or y [m]; all run the same way.
    """

    faces_xy: FloatArray

    def __post_init__(self) -> None:
        store(self, faces_xy=checked_floats(self.faces_xy, name="faces_xy", shape=(None, 2, 2)))

    @property
    def endpoints_xy(self) -> FloatArray:
        """The two jambs, midway between the faces, shape (2, 2) [m]."""
        ends: FloatArray = self.faces_xy.mean(axis=0)
        return ends

    @property
    def width(self) -> float:
        """Distance between the jambs [m]."""
        return float(np.hypot(*(self.endpoints_xy[1] - self.endpoints_xy[0])))

    @property
    def middles_xy(self) -> FloatArray:
        """Midpoints of the doorway and of each face, shape (1 + f, 2) [m]."""
        return np.vstack([self.endpoints_xy.mean(axis=0), self.faces_xy.mean(axis=1)])


def true_doorways(truth: Truth) -> tuple[Doorway, ...]:
    """Find the doorways of a floor plan.

    A doorway is a gap of 0.4 to 3 m between the facing ends of two walls on one line.  No wall stands in it or up to
    0.5 m before and behind its middle, and on both sides the free space there is wider than the gap: a niche or a pier
    does not count.  Closing it would divide the floor: walls connect its ends another way, directly or across other
    gaps, so the gap beside a free-standing box does not count.  Gaps in two faces of one wall, at most 0.4 m apart, are
    one doorway.

    Parameters
    ----------
    truth : Truth
        The true walls.

    Returns
    -------
    tuple of Doorway
        In the order of their walls.
    """
    walls = truth.walls_xy[np.hypot(*(truth.walls_xy[:, 1] - truth.walls_xy[:, 0]).T) > _OFFSET]
    gaps = [_gap(first, second) for first, second in combinations(walls, 2)]
    doorways = _joined([gap for gap in gaps if gap is not None and _leads_through(gap, walls)])
    return tuple(
        doorway
        for doorway in doorways
        if _is_connected(doorway, [walls, *(other.faces_xy for other in doorways if other is not doorway)])
    )


def count_stations(doorways: Sequence[Doorway], truth: Truth, *, reach: float) -> IntArray:
    """Count the stations that face each doorway.

    A station faces a doorway if the perpendicular from it onto the line of the doorway is no longer than the reach,
    ends between the jambs, and crosses no wall.

    Parameters
    ----------
    doorways : sequence of Doorway
        The doorways.
    truth : Truth
        The true walls and poses.
    reach : float
        How far the sonar measures [m].

    Returns
    -------
    ndarray of int, shape (n,)
        ``EVERYWHERE`` if the path leads through the doorway, or if the truth has no poses.
    """
    counts = [_stations(doorway.endpoints_xy, truth, reach=reach) for doorway in doorways]
    return np.array(counts, dtype=np.int64)


def _stations(ends_xy: FloatArray, truth: Truth, *, reach: float) -> int:
    stations = truth.poses[:, :2]
    if not len(stations):
        return EVERYWHERE
    is_crossed = crosses_segments(stations[:-1], stations[1:], ends_xy).any()
    is_inside = (distances_to_segments(stations, ends_xy) < _OFFSET).any()
    if is_crossed or is_inside:
        return EVERYWHERE
    line = lines_through(*ends_xy)
    feet_xy = feet(line, stations)
    low, high = np.sort(along(line, ends_xy))
    places = along(line, feet_xy)
    faced = (low < places) & (places < high) & (np.hypot(*(stations - feet_xy).T) <= reach)
    seen = ~is_blocked(stations, feet_xy, segments_xy=truth.walls_xy, discs=[])
    return int(np.sum(faced & seen))


def _gap(first: FloatArray, second: FloatArray) -> FloatArray | None:
    """Gap between the facing ends of two walls on one line, shape (2, 2)."""
    between = np.hypot(*np.moveaxis(first[:, None] - second[None], -1, 0))
    i, j = np.unravel_index(between.argmin(), between.shape)
    near, other = first[i], second[j]
    outwards, inwards = _unit(first[[1 - i, i]]), _unit(second[[j, 1 - j]])
    is_parallel = outwards @ inwards > np.cos(_ANGLE)
    is_on_line = abs(_cross(outwards, other - near)) < _OFFSET
    is_wide = _WIDTHS[0] <= (other - near) @ outwards <= _WIDTHS[1]
    return np.array([near, other]) if is_parallel and is_on_line and is_wide else None


def _leads_through(gap: FloatArray, walls: FloatArray) -> bool:
    """Whether a gap is free and leads from one wider space into another."""
    unit = _unit(gap)
    across = _BEHIND * np.array([-unit[1], unit[0]])
    middle, half = gap.mean(axis=0), 0.5 * np.hypot(*(gap[1] - gap[0]))
    within, beyond = (half - _JAMB) * unit, (half + _WIDER) * unit
    is_free = _is_clear(middle - within, middle + within, walls) and _is_clear(middle - across, middle + across, walls)
    return is_free and all(
        _is_clear(place, place - beyond, walls) or _is_clear(place, place + beyond, walls)
        for place in (middle - across, middle + across)
    )


def _is_clear(start: FloatArray, end: FloatArray, walls: FloatArray) -> bool:
    """Whether no wall comes nearer to a stretch than a centimetre."""
    crossed = crosses_segments([start], [end], walls).any()
    from_walls = distances_to_segments(walls.reshape(-1, 2), [[start, end]])
    from_stretch = distances_to_segments([start, end], walls)
    return bool(not crossed and from_walls.min() > _OFFSET and from_stretch.min() > _OFFSET)


def _joined(gaps: Sequence[FloatArray]) -> tuple[Doorway, ...]:
    """Join the gaps in both faces of a wall to one doorway."""
    doorways: list[list[FloatArray]] = []
    for gap in gaps:
        faces = next((faces for faces in doorways if _is_other_face(gap, faces[0])), None)
        if faces is None:
            doorways.append([gap])
        else:
            faces.append(gap if _unit(gap) @ _unit(faces[0]) > 0 else gap[::-1])
    return tuple(Doorway(faces_xy=np.array(faces)) for faces in doorways)


def _is_other_face(gap: FloatArray, face: FloatArray) -> bool:
    """Whether two gaps are parallel, no farther apart than a wall is thick, and overlap."""
    unit, apart = _unit(face), gap.mean(axis=0) - face.mean(axis=0)
    is_parallel = abs(_cross(unit, _unit(gap))) < np.sin(_ANGLE)
    widths = np.hypot(*(gap[1] - gap[0])) + np.hypot(*(face[1] - face[0]))
    return bool(is_parallel and abs(_cross(unit, apart)) <= _THICKNESS and abs(unit @ apart) < 0.5 * widths)


def _is_connected(doorway: Doorway, others: Sequence[FloatArray]) -> bool:
    """Whether walls and closed gaps connect the ends of a doorway another way."""
    lines = np.concatenate(others)
    near = (
        (distances_to_segments(lines.reshape(-1, 2), lines) < _CONNECTED).reshape(len(lines), 2, len(lines)).any(axis=1)
    )
    is_touching = near | near.T | crosses_segments(lines[:, 0], lines[:, 1], lines)
    start, end = distances_to_segments(doorway.faces_xy[0], lines) < _CONNECTED
    count = 0
    while start.sum() > count:
        count = start.sum()
        start |= is_touching[start].any(axis=0)
    return bool((start & end).any())


def _unit(segment: FloatArray) -> FloatArray:
    span = segment[1] - segment[0]
    unit: FloatArray = span / np.hypot(*span)
    return unit


def _cross(a: FloatArray, b: FloatArray) -> float:
    return float(a[0] * b[1] - a[1] * b[0])
