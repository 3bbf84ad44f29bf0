"""Regions of constant depth (Leonard and Durrant-Whyte 1992; Section 3.1 of the paper)."""

from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.extraction.clusters import Cluster
from echoplan.extraction.minimum import LocatedPoint

__all__ = ["Rcd", "RcdSettings", "region_of_constant_depth"]


class RcdSettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of the extraction of regions of constant depth."""

    tolerance: float = Field(
        default=0.01,
        gt=0.0,
        description="greatest difference of depth within a region [m]: two steps of a 5 mm module",
    )
    min_pings: int = Field(default=5, ge=1, description="a region of fewer pings is none")


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
    """

    hub_xy: FloatArray
    bearing_min: float
    bearing_max: float
    depth: float
    pings: int

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
            Middle and depth.  The middle may lie anywhere in the inner half of the region, whose ends are where
            the echo crossed the threshold; the depth is as good as a step of the readings.
        """
        return LocatedPoint(
            hub_xy=self.hub_xy,
            bearing=(self.bearing_min + self.bearing_max) / 2,
            distance=self.depth,
            covariance=np.diag([(self.width / 2) ** 2 / 12, resolution**2 / 12]),
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
    )


def _run_end(distances: FloatArray, start: int, *, tolerance: float) -> int:
    """Index of the last echo that follows ``start`` while the depth stays within the tolerance."""
    spread = np.maximum.accumulate(distances[start:]) - np.minimum.accumulate(distances[start:])
    # Readings are multiples of a step, so a spread of just the tolerance must not hang on the last bit.
    return start + int(np.count_nonzero(spread <= tolerance * (1 + 1e-9))) - 1
