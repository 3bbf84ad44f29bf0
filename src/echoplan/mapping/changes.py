"""What has changed in a place between the recordings of an earlier map and another recording.

A wall, or a piece of one, counts as new if the earlier map has none there although the robot had measured through it
when it detected another wall.  Where it had not, the wall is merely mapped for the first time.  By the same rule, with
both maps exchanged, a wall is gone.
"""

from collections.abc import Iterable
from typing import Any, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray

from echoplan.arrays import FloatArray
from echoplan.model import Changes, Cylinder, FeatureMap, Wall

__all__ = ["contradicts", "find_changes", "later_views"]

# Shapes of shapely.
_Shapes: TypeAlias = NDArray[Any]

# Distance up to which two walls or cylinders are the same one [m]: maps are right to a few millimetres, and what moves
# less is hardly worth a word.
_SAME = 0.05
# Shortest piece of a wall that counts as changed [m]: the ends of walls are less certain than their lines.
_SHORTEST = 0.2
# What a view must extend beyond a piece on both sides, so that the robot surely measured through it [m].
_BEYOND = 0.1


def later_views(views_before: FloatArray, views_after: FloatArray) -> FloatArray:
    """Return the lines of sight of the last recording, shape (v, 2, 2) [m].

    Parameters
    ----------
    views_before, views_after : ndarray, shape (n, 2, 2)
        Lines of sight of earlier recordings, and of all: from the station to the wall [m].

    Returns
    -------
    ndarray, shape (v, 2, 2)
        Those that begin at none of the earlier stations.
    """
    is_earlier = (views_after[:, None, 0] == views_before[None, :, 0]).all(axis=-1).any(axis=1)
    later: FloatArray = views_after[~is_earlier]
    return later


def contradicts(before: FeatureMap, later: FloatArray) -> bool:
    """Tell whether a recording measured through more walls of an earlier map than it found in their place.

    Parameters
    ----------
    before : FeatureMap
        The earlier map.
    later : ndarray, shape (v, 2, 2)
        Lines of sight of the recording, from the station to the wall [m].

    Returns
    -------
    bool
        True if the recording is of another place.
    """
    walls = shapely.STRtree(_lines(before.walls))
    through = np.unique(_trimmed(later).query(_lines(before.walls), predicate="intersects")[1])
    found = np.unique(walls.query(shapely.points(later[:, 1]), predicate="dwithin", distance=_SAME)[0])
    return len(through) > len(found)


def find_changes(
    before: FeatureMap, after: FeatureMap, *, recording: str, earlier: FloatArray, later: FloatArray
) -> Changes:
    """Compare the maps before and after a recording.

    Parameters
    ----------
    before, after : FeatureMap
        Both maps, in one frame.
    recording : str
        Name of the recording.
    earlier, later : ndarray, shape (v, 2, 2)
        Lines of sight of earlier recordings and of this one, along which they detected walls, from the station to the
        wall [m].

    Returns
    -------
    Changes
        What is gone, and what is new.
    """
    views_before, views_after = _trimmed(earlier), _trimmed(later)
    return Changes(
        recording=recording,
        # The estimator removed what is gone, because two stations or more missed it.
        gone_walls=_pieces(before, after, views_after, crossings=1),
        gone_cylinders=_cylinders(before, after, views_after),
        new_walls=_pieces(after, before, views_before, crossings=2),
        new_cylinders=_cylinders(after, before, views_before),
    )


def _trimmed(views: FloatArray) -> shapely.STRtree:
    """Return lines of sight without their ends."""
    steps = views[:, 1] - views[:, 0]
    lengths = np.hypot(*steps.T)
    margins = (_BEYOND * steps.T / lengths).T
    lines = np.stack([views[:, 0] + margins, views[:, 1] - margins], axis=1)[lengths > 2.0 * _BEYOND]
    return shapely.STRtree(shapely.linestrings(lines))


def _pieces(there: FeatureMap, other: FeatureMap, views: shapely.STRtree, *, crossings: int) -> tuple[FloatArray, ...]:
    """Return the pieces of walls that only one map has although views of the other cross them, shape (2, 2) [m] each.

    So many ``crossings`` are required: a single view may be an error.
    """
    known = shapely.union_all(shapely.buffer(_lines(other.walls), _SAME))
    pieces = shapely.get_parts(shapely.difference(_lines(there.walls), known))
    pieces = pieces[shapely.length(pieces) >= _SHORTEST]
    counts = np.bincount(views.query(pieces, predicate="intersects")[0], minlength=len(pieces))
    return tuple(shapely.get_coordinates(pieces[counts >= crossings]).reshape(-1, 2, 2))


def _cylinders(there: FeatureMap, other: FeatureMap, views: shapely.STRtree) -> tuple[Cylinder, ...]:
    """Return the cylinders that only one map has although views of the other one cross them."""
    known = shapely.union_all(_discs(other.cylinders, _SAME))
    only = [each for each in there.cylinders if not shapely.intersects(known, shapely.Point(each.center_xy))]
    crossed = np.unique(views.query(_discs(only), predicate="intersects")[0])
    return tuple(only[number] for number in crossed)


def _lines(walls: Iterable[Wall]) -> _Shapes:
    return np.array([shapely.LineString(wall.endpoints_xy) for wall in walls], dtype=object)


def _discs(cylinders: Iterable[Cylinder], radius: float | None = None) -> _Shapes:
    """Return the cylinders as discs, of their own radius or of another one [m]."""
    radii = (each.radius if radius is None else radius for each in cylinders)
    found = [shapely.Point(each.center_xy).buffer(own) for each, own in zip(cylinders, radii, strict=True)]
    return np.array(found, dtype=object)
