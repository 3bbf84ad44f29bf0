"""Differential-distance clusters: runs of neighbouring echoes whose distance does not jump (Section 5.2)."""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray, checked_floats, store
from echoplan.extraction.runs import connected_runs
from echoplan.geometry import circular_mean, directions, rotation_step, wrap
from echoplan.model import Pings
from echoplan.settings import Settings

__all__ = ["Cluster", "ClusteringSettings", "differential_clusters", "hub_distances", "indexed_clusters"]


class ClusteringSettings(Settings):
    """Settings of the clustering; the paper names the method and none of its numbers."""

    jump: float = Field(
        default=0.02, gt=0.0, description="Largest difference between neighbouring distances from one reflector [m]."
    )
    max_gap: float = Field(default=4.5, ge=1.0, description="Largest gap in a run, in steps of rotation, for dropouts.")
    reach: int = Field(
        default=4,
        ge=1,
        le=1000,
        description="Number of neighbours with which a ping may be linked, across stray echoes.",
    )
    min_pings: int = Field(default=3, ge=1, description="Smallest number of pings of a feature.")


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


def differential_clusters(
    pings: Pings, settings: ClusteringSettings | None = None, *, distances: FloatArray | None = None
) -> list[Cluster]:
    """Split a sweep into runs of neighbouring echoes without a jump in distance.

    Parameters
    ----------
    pings : Pings
        n valid pings of one sweep.
    settings : ClusteringSettings, optional
        What is a jump and what is a gap.
    distances : ndarray, shape (n,), optional
        Distances in which jumps are looked for [m], such as compensated ones; those from the hub by default.

    Returns
    -------
    list of Cluster
        The runs; empty if there is none.
    """
    return [cluster for cluster, _ in indexed_clusters(pings, settings, distances=distances)]


def indexed_clusters(
    pings: Pings, settings: ClusteringSettings | None = None, *, distances: FloatArray | None = None
) -> list[tuple[Cluster, IntArray]]:
    """Return differential clusters, each with the indices of its echoes in ``pings``, in the order of the cluster."""
    settings = settings or ClusteringSettings()
    if not len(pings):
        return []
    around = np.argsort(wrap(pings.bearings), kind="stable")
    circle = pings[around]
    depths = hub_distances(circle) if distances is None else distances[around]
    max_gap = settings.max_gap * rotation_step(circle.bearings)
    runs = connected_runs(circle.bearings, depths, max_gap=max_gap, jump=settings.jump, reach=settings.reach)
    clusters = []
    for run in runs:
        if len(run) >= settings.min_pings:
            members = np.sort(run)
            # Counter-clockwise about the middle of the run, so that none starts at 180 degrees.
            turns = wrap(circle.bearings[members] - circular_mean(circle.bearings[members]))
            ordered = members[np.argsort(turns, kind="stable")]
            clusters.append((_cluster(circle, ordered, max_gap=max_gap), around[ordered]))
    return clusters


def _cluster(circle: Pings, run: IntArray, *, max_gap: float) -> Cluster:
    """Unroll the bearings of an ordered run and look at what lies beyond its ends."""
    middle = circular_mean(circle.bearings[run])
    bearings = middle + wrap(circle.bearings[run] - middle)
    distances = hub_distances(circle)

    def neighbour(end: int, step: int) -> float:
        """Return the distance of the ping beside an end [m]; inf if it is too far off or in the run itself."""
        beyond = (run[end] + step) % len(circle)
        gap = abs(float(wrap(circle.bearings[beyond] - circle.bearings[run[end]])))
        return float(distances[beyond]) if gap <= max_gap and beyond not in run else float("inf")

    return Cluster(pings=circle[run], bearings=bearings, right=neighbour(0, -1), left=neighbour(-1, 1))
