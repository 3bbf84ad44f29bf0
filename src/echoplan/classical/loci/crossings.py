"""Crossings of arcs: the points that two echoes have in common.

Two circles of radii r1 and r2 whose centres are d apart meet at the angle gamma of
``cos(gamma) = (r1**2 + r2**2 - d**2) / (2 r1 r2)``, which lies between -1 and 1 just if they meet at all; from the
first centre the crossings lie ``a = (r1**2 - r2**2 + d**2) / (2 d)`` along the way to the second and
``h = sqrt(r1**2 - a**2)`` to either side.
"""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.classical.loci.loci import Loci
from echoplan.geometry import directions

__all__ = ["Crossings", "find_crossings"]

# Number of pairs of arcs that are compared at a time, which limits the memory to some megabytes.
_PAIRS = 1 << 20


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Crossings:
    """Points on two arcs.

    Parameters
    ----------
    first, second : ndarray of int, shape (c,)
        Numbers of the arcs.
    points_xy : ndarray, shape (c, 2)
        Where they cross [m].
    """

    first: IntArray
    second: IntArray
    points_xy: FloatArray


def find_crossings(first: Loci, second: Loci, *, min_angle: float) -> Crossings:
    """Find where arcs cross transversally, within the beams of both.

    Parameters
    ----------
    first, second : Loci
        Arcs; each of the first is compared with each of the second.
    min_angle : float
        Least angle between two arcs that cross [rad]: the flatter a crossing, the farther an error of range moves it.

    Returns
    -------
    Crossings
        Every pair of arcs that cross; two may cross twice.

    Examples
    --------
    >>> one = Loci(centers_xy=[[0, 0]], ranges=[5.0], bearings=[0.9], half_apertures=[0.2], sweeps=[0])
    >>> other = Loci(centers_xy=[[3, 0]], ranges=[4.0], bearings=[1.6], half_apertures=[0.2], sweeps=[1])
    >>> find_crossings(one, other, min_angle=0.5).points_xy.round(6)
    array([[3., 4.]])
    """
    rows = max(_PAIRS // max(len(second), 1), 1)
    starts = range(0, len(first), rows)
    parts = [_crossings(first[start : start + rows], second, min_angle=min_angle) for start in starts]
    return Crossings(
        first=np.concatenate([_none(), *(part.first + start for start, part in zip(starts, parts, strict=True))]),
        second=np.concatenate([_none(), *(part.second for part in parts)]),
        points_xy=np.concatenate([np.zeros((0, 2)), *(part.points_xy for part in parts)]),
    )


def _crossings(first: Loci, second: Loci, *, min_angle: float) -> Crossings:
    one, other = np.nonzero(_is_transversal(first, second, min_angle=min_angle))
    way = second.centers_xy[other] - first.centers_xy[one]
    squares = np.sum(way**2, axis=1)[:, None]
    radii = first.ranges[one, None]
    # a and h in units of d.
    ahead = (radii**2 - second.ranges[other, None] ** 2 + squares) / (2 * squares)
    aside = np.sqrt(np.maximum(radii**2 / squares - ahead**2, 0.0))
    foot = first.centers_xy[one] + ahead * way
    across = aside * np.column_stack([-way[:, 1], way[:, 0]])
    points = np.concatenate([foot + across, foot - across])
    one, other = np.tile(one, 2), np.tile(other, 2)
    inside = np.flatnonzero(_in_beam(first, one, points))
    inside = inside[_in_beam(second, other[inside], points[inside])]
    return Crossings(first=one[inside], second=other[inside], points_xy=points[inside])


def _is_transversal(first: Loci, second: Loci, *, min_angle: float) -> BoolArray:
    """Mask of the pairs of arcs, shape (n, m), that may cross at a wide enough angle: near, and their circles cross."""
    squares = _squared_distances(first.centers_xy, second.centers_xy)
    product = 2 * np.cos(min_angle) * np.multiply.outer(first.ranges, second.ranges)
    meet = np.abs(np.add.outer(first.ranges**2, second.ranges**2) - squares) <= product
    # No point of an arc is farther from its middle than the chord to its end.
    chords = [2 * loci.ranges * np.sin(np.minimum(loci.half_apertures, np.pi) / 2) for loci in (first, second)]
    near = _squared_distances(first.middles_xy, second.middles_xy) <= np.add.outer(*chords) ** 2
    transversal: BoolArray = meet & near & (squares > 0)
    return transversal


def _squared_distances(first_xy: FloatArray, second_xy: FloatArray) -> FloatArray:
    squares: FloatArray = np.subtract.outer(first_xy[:, 0], second_xy[:, 0]) ** 2
    squares += np.subtract.outer(first_xy[:, 1], second_xy[:, 1]) ** 2
    return squares


def _in_beam(loci: Loci, which: IntArray, points_xy: FloatArray) -> BoolArray:
    """Mask of the points on a circle that lie within the beam."""
    axes = directions(loci.bearings)
    nearest = np.sum(loci.centers_xy * axes, axis=1) + loci.ranges * np.cos(loci.half_apertures)
    inside: BoolArray = points_xy[:, 0] * axes[which, 0] + points_xy[:, 1] * axes[which, 1] >= nearest[which]
    return inside


def _none() -> IntArray:
    return np.zeros(0, dtype=np.int64)
