"""What has changed in a place between the recordings of an earlier map and another recording.

A wall, or a piece of one, is gone if earlier recordings detected it, it is no longer in the map, and the robot looked
at its place: it measured through it when it detected other walls, it drove through it, or stations that face it clearly
do not detect it. A wall that many earlier stations detected may still be in the map: it is out of date if no later
station detects it, and more of them looked at its place or measured through it, also where it was only inferred. A wall
is new if it is only in the new map, and the earlier recordings looked at its place in the same way. Where nobody
looked, nothing is reported. What a map inferred is neither gone nor new, and neither is a wall that is longer or
shorter than before by less than the 95 % interval of its end. For cylinders, only lines of sight and the path count;
one through which the recordings that show it looked as well is probably false, and not reported. Round walls are never
reported, as no lines of sight to them are kept.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.ops import substring

from echoplan.arrays import BoolArray, FloatArray
from echoplan.joint.likelihood.hypothesis_scores import STRONGEST_MISS
from echoplan.model import HALF_OF_95, Changes, Cylinder, FeatureMap, Wall

__all__ = ["Looks", "contradicts", "find_changes", "outdated"]

# Shapes of shapely.
_Shapes: TypeAlias = NDArray[Any]

# Distance up to which two walls or cylinders are the same one, and size of a place [m]: maps are right to a few
# millimetres, so what moved farther than that is noticed.
_SAME = 0.05
# Least length of a piece that counts as changed if a wall is in both maps [m]: ends are less certain than lines.
_SHORTEST = 0.2
# Half the distance up to which two pieces are joined [m]: corners of walls may be off by that.
_JOINED = 0.1
# A wall is absent if the robot drove through its place, if stations at two places measured through it, as a single one
# may be wrong, or if three stations miss it entirely [nats], as two may have stood behind something that is not in the
# map. Shares of these add up.
_CROSSINGS, _MISSED = 2, -3.0 * STRONGEST_MISS
# Sum of shares from which a wall that is still in the new map is out of date: all recordings together speak for it.
_SURELY = 1.5
# Errors of rounding are smaller [m].
_EXACT = 1e-3
# What a view must extend beyond a piece on both sides, so that the robot surely measured through it [m].
_BEYOND = 0.1


class Looks(NamedTuple):
    """What stations looked at, and where the robot drove.

    Attributes
    ----------
    views_xy : ndarray, shape (v, 2, 2)
        Lines of sight along which they detected walls, from the station to the wall [m].
    path_xy : ndarray, shape (p, 2)
        Path of the robot, straight from one place to the next [m]; a row of NaN separates recordings.
    misses : callable
        Returns the log probability that they do not detect n walls, shape (n,) [nats].
    """

    views_xy: FloatArray
    path_xy: FloatArray
    misses: Callable[[Sequence[Wall]], FloatArray]

    def later(self, until_now: "Looks") -> "Looks":
        """Return the looks of the recording that came after these.

        Parameters
        ----------
        until_now : Looks
            Lines of sight and path of all recordings; misses of the last one.

        Returns
        -------
        Looks
            Lines of sight that begin at none of the earlier stations, and the rest of the path.
        """
        views_xy = until_now.views_xy
        is_earlier = (views_xy[:, None, 0] == self.views_xy[None, :, 0]).all(axis=-1).any(axis=1)
        return until_now._replace(views_xy=views_xy[~is_earlier], path_xy=until_now.path_xy[len(self.path_xy) :])

    def passed(self, shapes: _Shapes) -> FloatArray:
        """Return how surely shapes were absent: 1 if the robot drove through, or stations at two places looked through.

        Parameters
        ----------
        shapes : ndarray of object, shape (n,)
            Lines, or areas.

        Returns
        -------
        ndarray, shape (n,)
            From 1 on, it counts as absent.
        """
        steps = np.stack([self.path_xy[:-1], self.path_xy[1:]], axis=1)
        steps = steps[np.isfinite(steps).all(axis=(1, 2))]
        owners, views = _trimmed(self.views_xy).query(shapes, predicate="intersects")
        # Lines of sight from one place may all be the same wrong echo, so they count once.
        places = np.unique(np.round(self.views_xy[:, 0] / _SAME), axis=0, return_inverse=True)[1].reshape(-1)
        seen = np.unique(np.stack([owners, places[views]]), axis=1)[0]
        driven = shapely.STRtree(shapely.linestrings(steps)).query(shapes, predicate="intersects")[0]
        passed: FloatArray = np.bincount(seen, minlength=len(shapes)) / _CROSSINGS
        return passed + np.isin(np.arange(len(shapes)), driven)


def contradicts(before: FeatureMap, later: FloatArray) -> bool:
    """Tell whether more lines of sight of a recording lead through walls of an earlier map than end at one.

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


def find_changes(before: FeatureMap, after: FeatureMap, *, earlier: Looks, later: Looks) -> Changes:
    """Compare the maps before and after a recording.

    Parameters
    ----------
    before, after : FeatureMap
        Both maps, in one frame.
    earlier, later : Looks
        What the earlier recordings looked at, and this one.

    Returns
    -------
    Changes
        What is gone, and what is new.
    """
    return Changes(
        gone_walls=_absent(_pieces(before, after, looks=earlier), later),
        gone_cylinders=_moved(_only(before, after), there=earlier, absent=later),
        new_walls=_absent(_pieces(after, before, looks=later), earlier),
        new_cylinders=_moved(_only(after, before), there=later, absent=earlier),
    )


def outdated(before: FeatureMap, *, earlier: Looks, later: Looks) -> list[Wall]:
    """Return the walls of an earlier map that are there no more, even if all recordings together speak for them.

    Parameters
    ----------
    before : FeatureMap
        The earlier map.
    earlier, later : Looks
        What the earlier recordings looked at, and the later one.

    Returns
    -------
    list of Wall
        Walls that earlier stations detected and later ones did not. Together with the walls that they are joined to,
        they need half as many looks again as walls that are not in the new map. Inferred parts count as well: often
        most of a side of a cupboard was inferred.
    """
    old, new = (_ends_at(looks, _detected(before.walls)) for looks in (earlier, later))
    gone = [wall for wall, was, is_there in zip(before.walls, old, new, strict=True) if was and not is_there]
    lines, missed = _lines(gone), later.misses(gone) / _MISSED
    bodies = _bodies(lines)
    looked = later.passed(bodies) + np.array([missed[shapely.intersects(lines, each)].sum() for each in bodies])
    return [wall for wall, enough in zip(gone, looked >= _SURELY, strict=True) if enough]


def _absent(pieces: Sequence[Wall], looks: Looks) -> tuple[FloatArray, ...]:
    """Return the endpoints of those pieces of walls that were not there when stations looked at their places."""
    is_absent = looks.passed(_bodies(_lines(pieces))) + looks.misses(pieces) / _MISSED >= 1.0
    return tuple(piece.endpoints_xy for piece, absent in zip(pieces, is_absent, strict=True) if absent)


def _moved(cylinders: Sequence[Cylinder], *, there: Looks, absent: Looks) -> tuple[Cylinder, ...]:
    """Return the cylinders through which the recordings without them looked or drove, and those with them did not."""
    discs = _discs(cylinders)
    counts = (absent.passed(discs) >= 1.0) & (there.passed(discs) < 1.0)
    return tuple(each for each, moved in zip(cylinders, counts, strict=True) if moved)


def _trimmed(views: FloatArray) -> shapely.STRtree:
    """Return lines of sight without their ends, None for those that are too short."""
    steps = views[:, 1] - views[:, 0]
    lengths = np.hypot(*steps.T)
    margins = (_BEYOND * steps.T / lengths).T
    lines = shapely.linestrings(np.stack([views[:, 0] + margins, views[:, 1] - margins], axis=1))
    return shapely.STRtree(np.where(lengths > 2.0 * _BEYOND, lines, None))


def _pieces(there: FeatureMap, other: FeatureMap, *, looks: Looks) -> list[Wall]:
    """Return the pieces of walls that were detected in one map and are not in the other, not even inferred.

    A wall that is longer in one map counts only if it is longer by more than the 95 % interval of its end.  ``looks``
    are those of the recordings of the first map: a place that no station detected is part of a wall only because
    nothing speaks against it.
    """
    known = shapely.union_all(shapely.buffer(_lines(other.walls), _SAME))
    detected = _detected(there.walls)
    # Parts that are wall wherever the ends may be.
    certain = np.array([_without_ends(each, _uncertain(each)) for each in there.walls], dtype=object)
    pieces, owners = shapely.get_parts(shapely.difference(detected, known), return_index=True)
    overlaps = shapely.length(shapely.intersection(shapely.buffer(pieces, _EXACT), certain[owners]))
    pieces, owners = pieces[overlaps >= _SAME], owners[overlaps >= _SAME]
    is_long = shapely.length(pieces) >= _SHORTEST
    is_apart = ~shapely.intersects(known, _lines(there.walls))[owners]
    return [
        replace(there.walls[owner], endpoints_xy=shapely.get_coordinates(piece))
        for piece, owner, counts in zip(pieces, owners, _ends_at(looks, pieces) & (is_long | is_apart), strict=True)
        if counts
    ]


def _ends_at(looks: Looks, lines: _Shapes) -> BoolArray:
    """Return for each line whether a station detected a wall there."""
    feet = shapely.STRtree(shapely.points(looks.views_xy[:, 1]))
    found: BoolArray = np.isin(np.arange(len(lines)), feet.query(lines, predicate="dwithin", distance=_SAME)[0])
    return found


def _detected(walls: Iterable[Wall]) -> _Shapes:
    """Return walls without the ends that were only inferred; a point if all of one was."""
    return np.array([_without_ends(each, each.inferred) for each in walls], dtype=object)


def _without_ends(wall: Wall, lengths: FloatArray) -> shapely.LineString:
    """Return a wall without some length at its start and at its end [m]."""
    first = min(lengths[0], wall.length)
    return substring(shapely.LineString(wall.endpoints_xy), first, max(first, wall.length - lengths[1]))


def _uncertain(wall: Wall) -> FloatArray:
    """Return the lengths at the start and at the end of a wall that may not be wall, shape (2,) [m]."""
    # The middle of a wall exists, however short it is.
    half_intervals = (HALF_OF_95 * wall.endpoint_sigmas).clip(max=max(0.5 * wall.length - _SAME, 0.0))
    # A sigma that was not estimated is NaN.
    lengths: FloatArray = np.fmax(wall.inferred, half_intervals)
    return lengths


def _bodies(pieces: _Shapes) -> _Shapes:
    """Return for each piece all pieces that it is joined to, as the sides of a cupboard are."""
    bodies = shapely.STRtree(shapely.get_parts(shapely.union_all(shapely.buffer(pieces, _JOINED))))
    numbers, owners = bodies.query(pieces, predicate="intersects")
    joined = [shapely.union_all(pieces[numbers[owners == owner]]) for owner in range(len(bodies))]
    found: _Shapes = np.array([joined[owner] for owner in owners[np.argsort(numbers)]], dtype=object)
    return found


def _only(there: FeatureMap, other: FeatureMap) -> list[Cylinder]:
    """Return the cylinders that only one map has."""
    known = shapely.union_all(_discs(other.cylinders, _SAME))
    return [each for each in there.cylinders if not shapely.intersects(known, shapely.Point(each.center_xy))]


def _lines(walls: Iterable[Wall]) -> _Shapes:
    return np.array([shapely.LineString(wall.endpoints_xy) for wall in walls], dtype=object)


def _discs(cylinders: Iterable[Cylinder], radius: float | None = None) -> _Shapes:
    """Return the cylinders as discs, of their own radius or of another one [m]."""
    radii = (each.radius if radius is None else radius for each in cylinders)
    found = [shapely.Point(each.center_xy).buffer(own) for each, own in zip(cylinders, radii, strict=True)]
    return np.array(found, dtype=object)
