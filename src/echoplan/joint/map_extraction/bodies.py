"""Bodies: objects of unknown depth behind detected walls, which occlude the view of other walls."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import directions
from echoplan.joint.map_extraction.segment import PARALLEL, Segment, path_since
from echoplan.joint.map_extraction.surroundings import Beside, points_on

__all__ = ["Bodies"]

# Mean depth of a body of which only the front was detected [m]. On flats 20 to 59 of `benchmarks/flats.py` half the
# value gives the same walls, and twice the value shortens them a little.
_DEPTH = 0.5


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Bodies:
    """Bodies behind n segments."""

    # Landmark of each front, shape (n,).
    owners: IntArray
    # Lower ends of the fronts [m], shape (n, 2).
    origins_xy: FloatArray
    # Unit vectors along each front and into the body, shape (n, 2, 2).
    axes: FloatArray
    # Lengths of the fronts [m], shape (n,).
    widths: FloatArray
    # Least and greatest depth of each body [m], shape (n, 2).
    depths: FloatArray

    @classmethod
    def behind(cls, segments: Sequence[Segment], path_xy: FloatArray) -> "Bodies":
        """Return the bodies behind segments; each ends at its detected back, or before the path of the robot [m]."""
        return cls(
            owners=np.array([each.owner for each in segments], dtype=np.int64),
            origins_xy=np.array([each.point(each.low) for each in segments]).reshape(-1, 2),
            axes=np.array([[each.along, directions(each.wall.line[0])] for each in segments]).reshape(-1, 2, 2),
            widths=np.array([each.high - each.low for each in segments]),
            depths=np.array([_depths(each, segments, path_xy) for each in segments]).reshape(-1, 2),
        )

    def hide(self, origins_xy: FloatArray, owner: int, line: FloatArray, places: FloatArray) -> FloatArray:
        """Return the probability that a body occludes each place along a line, seen from the origin of the same row.

        Segments of the landmark itself and those that face its line do not count: their bodies end at the line at the
        latest.
        """
        fronts = (self.owners != owner) & (self.axes[:, 1] @ directions(line[0]) > -PARALLEL)
        corner, axes, (least, greatest) = self.origins_xy[fronts], self.axes[fronts], self.depths[fronts].T
        start, stop = (
            np.einsum("fij,rfj->rfi", axes, points[:, None] - corner)
            for points in (origins_xy, points_on(line, places))
        )
        along, inward = np.moveaxis(stop - start, -1, 0)
        # Where each line of sight enters and leaves the strip perpendicular to the front, as shares of its length.
        borders = np.stack([-start[..., 0], self.widths[fronts] - start[..., 0]])
        shares = np.sort(borders / np.where(np.abs(along) < 1e-12, 1e-12, along), axis=0).clip(0.0, 1.0)
        depths = start[..., 1] + shares * inward
        nearest = depths.min(axis=0).clip(0.0)
        chances = np.where(nearest < least, 1.0, np.exp(-nearest / _DEPTH))
        chances *= (shares[0] < shares[1]) & (depths.max(axis=0) > 0.0) & (nearest < greatest)
        hidden: FloatArray = 1.0 - np.prod(1.0 - chances, axis=1)
        return hidden


def _depths(front: Segment, segments: Sequence[Segment], path_xy: FloatArray) -> tuple[float, float]:
    """Return the least and greatest depth of the body behind a front: to its back, or to the path of the robot [m]."""
    normal_angle, offset = front.wall.line
    opposite = [each for each in segments if math.cos(each.wall.line[0] - normal_angle) < -PARALLEL]
    beside = [Beside.of(front.wall.line, each) for each in opposite]
    backs = [-each.depth for each in beside if each.depth < 0.0 and each.first < front.high and front.low < each.last]
    if backs:
        return min(backs), min(backs)
    driven_xy = path_since(front.wall, path_xy)
    places, depths = driven_xy @ front.along, driven_xy @ directions(normal_angle) - offset
    driven = depths[(places > front.low) & (places < front.high) & (depths > 0.0)]
    return 0.0, float(driven.min(initial=math.inf))
