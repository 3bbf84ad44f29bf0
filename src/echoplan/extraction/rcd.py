"""Regions of constant depth (Leonard and Durrant-Whyte 1992; Section 3.1 of the paper)."""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.extraction.clusters import Cluster
from echoplan.extraction.minimum import LocatedPoint
from echoplan.settings import Settings

__all__ = ["Rcd", "RcdSettings", "region_of_constant_depth"]


class RcdSettings(Settings):
    """Settings of the extraction of regions of constant depth."""

    tolerance: float = Field(
        default=0.01,
        gt=0.0,
        description="Largest difference of depth within a region [m]: two steps of a 5 mm module.",
    )
    min_pings: int = Field(default=5, ge=1, description="Smallest number of pings of a region.")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Rcd:
    """A region of constant depth: directions in which the distance is the same.

    Parameters
    ----------
    hub_xy : ndarray, shape (2,)
        Position of the turret's axis [m].
    bearing_min, bearing_max : float
        First and last direction, counter-clockwise [rad].
    depth : float
        Distance from the hub [m].
    pings : int
        How many echoes it holds.
    covered_ends : int, optional
        At how many ends a nearer echo cuts the region off.
    beyond : float, optional
        Angle over which the object answers beyond the region [rad].
    tolerance : float, optional
        Greatest difference of depth within the region [m].
    """

    hub_xy: FloatArray
    bearing_min: float
    bearing_max: float
    depth: float
    pings: int
    covered_ends: int = 0
    beyond: float = 0.0
    tolerance: float = 0.0

    def __post_init__(self) -> None:
        store(self, hub_xy=checked_floats(self.hub_xy, name="hub_xy", shape=(2,)))

    @property
    def width(self) -> float:
        """Angle between first and last direction [rad]."""
        return self.bearing_max - self.bearing_min

    def located(self, *, resolution: float) -> LocatedPoint:
        """Take the middle of the region for the object's normal, as the conventional method does.

        Parameters
        ----------
        resolution : float
            Step of the readings [m].

        Returns
        -------
        LocatedPoint
            Middle and depth.  The normal may lie off the middle by half of what the object answers beyond the region,
            and by a step of rotation; with one end covered it may lie anywhere in the inner half of the region, with
            both anywhere in it.  The depth is as good as half the tolerance: nothing is compensated within it.
        """
        step = self.width / max(self.pings - 1, 1)
        window = self.beyond / 2 + (step, self.width / 2, self.width)[self.covered_ends]
        return LocatedPoint(
            hub_xy=self.hub_xy,
            bearing=(self.bearing_min + self.bearing_max) / 2,
            distance=self.depth,
            covariance=np.diag([window**2 / 12, (self.tolerance / 2) ** 2 + resolution**2 / 12]),
        )


def region_of_constant_depth(cluster: Cluster, settings: RcdSettings | None = None) -> Rcd | None:
    """Find the longest run of echoes in a cluster whose depth is constant.

    Parameters
    ----------
    cluster : Cluster
        Echoes of one object.
    settings : RcdSettings, optional
        What counts as constant.

    Returns
    -------
    Rcd or None
        The run that spans the widest angle, with its mean depth; None if it has too few pings.
    """
    settings = settings or RcdSettings()
    distances, bearings = cluster.distances, cluster.bearings
    ends = [_run_end(distances, start, tolerance=settings.tolerance) for start in range(len(distances))]
    start = int(np.argmax(bearings[ends] - bearings))
    run = slice(start, ends[start] + 1)
    if len(distances[run]) < settings.min_pings:
        return None
    return Rcd(
        hub_xy=cluster.hub_xy,
        bearing_min=float(bearings[run][0]),
        bearing_max=float(bearings[run][-1]),
        depth=float(distances[run].mean()),
        pings=len(distances[run]),
        covered_ends=int(run.start == 0 and cluster.right < distances[0])
        + int(run.stop == len(distances) and cluster.left < distances[-1]),
        beyond=cluster.extent - float(np.ptp(bearings[run])),
        tolerance=settings.tolerance,
    )


def _run_end(distances: FloatArray, start: int, *, tolerance: float) -> int:
    """Index of the last echo that follows ``start`` while the depth stays within the tolerance."""
    spread = np.maximum.accumulate(distances[start:]) - np.minimum.accumulate(distances[start:])
    # Readings are multiples of a step, so a spread of just the tolerance must not hang on the last bit.
    return start + int(np.count_nonzero(spread <= tolerance * (1 + 1e-9))) - 1
