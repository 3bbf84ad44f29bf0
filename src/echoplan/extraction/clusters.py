"""Differential-distance clusters: runs of neighbouring echoes whose distance does not jump (Section 5.2)."""

from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray, IntArray, checked_floats, store
from echoplan.geometry import circular_mean, directions, wrap
from echoplan.model import Pings

__all__ = ["Cluster", "ClusteringSettings", "differential_clusters", "hub_distances"]


class ClusteringSettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of the clustering; the paper names the method and none of its numbers."""

    jump: float = Field(
        default=0.02, gt=0.0, description="neighbouring distances that differ by more are two reflectors [m]"
    )
    max_gap: float = Field(default=4.5, ge=1.0, description="missing steps of rotation that a run survives (dropouts)")
    reach: int = Field(default=4, ge=1, description="neighbours to which a ping may be linked (stray echoes)")
    min_pings: int = Field(default=3, ge=1, description="a run of fewer pings is no feature")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cluster:
    """Echoes of one reflector in one sweep, counter-clockwise.

    Parameters
    ----------
    pings : Pings
        The n echoes.
    bearings : ndarray, shape (n,)
        Directions of the beam axes, unwrapped and not decreasing [rad].
    right, left : float
        Distance from the hub of the echo next to the clockwise and to the counter-clockwise end [m];
        ``inf`` where there is none.
    """

    pings: Pings
    bearings: FloatArray
    right: float
    left: float

    def __post_init__(self) -> None:
        store(self, bearings=checked_floats(self.bearings, name="bearings", shape=(len(self.pings),)))

    @property
    def distances(self) -> FloatArray:
        """Distance of the echo from the hub along the beam axis [m], shape (n,)."""
        return hub_distances(self.pings)

    @property
    def hub_xy(self) -> FloatArray:
        """Mean position of the turret's axis [m], shape (2,)."""
        mean: FloatArray = self.pings.hubs_xy.mean(axis=0)
        return mean

    @property
    def extent(self) -> float:
        """Angle over which the reflector answers [rad]: the paper's "ultrasonic distance range"."""
        return float(self.bearings[-1] - self.bearings[0])


def hub_distances(pings: Pings) -> FloatArray:
    """Distances of echoes from the turret's axis, along the beam.

    Parameters
    ----------
    pings : Pings
        n pings with finite ranges.

    Returns
    -------
    ndarray, shape (n,)
        Range plus the part of the arm that lies along the beam [m]: ``a + b`` of the paper.
    """
    arms = np.sum((pings.origins_xy - pings.hubs_xy) * directions(pings.bearings), axis=1)
    distances: FloatArray = arms + pings.ranges
    return distances


def differential_clusters(pings: Pings, settings: ClusteringSettings | None = None) -> list[Cluster]:
    """Split a sweep into runs of neighbouring echoes without a jump in distance.

    Echoes are sorted around the full circle.  Each is linked to those of its next few neighbours that lie
    within a few steps of rotation and differ by less than a jump: runs survive dropouts, step over stray echoes
    and wrap around 360 degrees.

    Parameters
    ----------
    pings : Pings
        Valid pings of one sweep.
    settings : ClusteringSettings, optional
        What is a jump and what is a gap.

    Returns
    -------
    list of Cluster
        The runs, counter-clockwise by their first echo; empty if there is none.
    """
    settings = settings or ClusteringSettings()
    if not len(pings):
        return []
    circle = pings[np.argsort(wrap(pings.bearings), kind="stable")]
    distances = hub_distances(circle)
    max_gap = settings.max_gap * rotation_step(circle)
    labels = _connect(wrap(circle.bearings), distances, max_gap=max_gap, settings=settings)
    runs = [np.flatnonzero(labels == label) for label in np.unique(labels)]
    return [
        _cluster(circle, run, distances=distances, max_gap=max_gap) for run in runs if len(run) >= settings.min_pings
    ]


def rotation_step(pings: Pings) -> float:
    """Return the usual turn from one ping to the next around the circle.

    Parameters
    ----------
    pings : Pings
        Pings of one sweep, at least one.

    Returns
    -------
    float
        Median gap between neighbouring directions that differ [rad]; a full turn for one direction.
    """
    directions_around = np.sort(np.mod(pings.bearings, 2 * np.pi))
    gaps = np.diff(directions_around, append=directions_around[0] + 2 * np.pi)
    distinct = gaps[gaps > 1e-6]
    return float(np.median(distinct))


def _connect(bearings: FloatArray, distances: FloatArray, *, max_gap: float, settings: ClusteringSettings) -> IntArray:
    """Label connected echoes; bearings are sorted, neighbours are taken around the circle."""
    from scipy.sparse import coo_array  # noqa: PLC0415 - only mappers need it
    from scipy.sparse.csgraph import connected_components  # noqa: PLC0415

    count = len(bearings)
    first = np.tile(np.arange(count), settings.reach)
    hops = np.repeat(np.arange(1, settings.reach + 1), count)
    second = (first + hops) % count
    gaps = np.mod(bearings[second] - bearings[first], 2 * np.pi)
    linked = (gaps <= max_gap) & (np.abs(distances[second] - distances[first]) <= settings.jump)
    links = coo_array((np.ones(linked.sum()), (first[linked], second[linked])), shape=(count, count))
    labels: IntArray = connected_components(links, directed=False)[1].astype(np.int64)
    return labels


def _cluster(circle: Pings, run: IntArray, *, distances: FloatArray, max_gap: float) -> Cluster:
    """Unroll a run about its middle and look at what lies beyond its ends."""
    middle = circular_mean(circle.bearings[run])
    unrolled = middle + wrap(circle.bearings[run] - middle)
    order = np.argsort(unrolled, kind="stable")
    run, bearings = run[order], unrolled[order]

    def neighbour(end: int, step: int) -> float:
        beyond = (run[end] + step) % len(circle)
        gap = abs(float(wrap(circle.bearings[beyond] - circle.bearings[run[end]])))
        return float(distances[beyond]) if gap <= max_gap and beyond not in run else float("inf")

    return Cluster(pings=circle[run], bearings=bearings, right=neighbour(0, -1), left=neighbour(-1, 1))
