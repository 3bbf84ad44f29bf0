"""The K-means filter of Section 5.1 of the paper: noise and stray points off."""

from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry import directions
from echoplan.model import Pings
from echoplan.settings import Settings

__all__ = ["KmeansSettings", "echo_points", "kmeans_filter"]


class KmeansSettings(Settings):
    """Settings of the K-means filter; the paper names the filter and none of its numbers."""

    former_keys: ClassVar = {"spread": "gate_ratio"}

    pings_per_cluster: int = Field(
        default=5,
        ge=2,
        description="Mean size of a cluster, so small that every stray echo can have a cluster of its own.",
    )
    min_members: int = Field(default=3, ge=1, description="Smallest number of pings of a cluster that is kept.")
    gate_ratio: float = Field(
        default=3.0,
        gt=1.0,
        description="Largest distance of a ping from its centroid, as a multiple of the median distance.",
    )
    seed: int = Field(default=0, ge=0, description="Seed of the initial centroids.")


def echo_points(pings: Pings) -> FloatArray:
    """Points that the readings would mean if sound were a ray.

    Parameters
    ----------
    pings : Pings
        n pings with finite ranges.

    Returns
    -------
    ndarray, shape (n, 2)
        The points on the beam axes at the measured ranges [m].
    """
    return pings.origins_xy + pings.ranges[:, None] * directions(pings.bearings)


def kmeans_filter(pings: Pings, settings: KmeansSettings | None = None) -> Pings:
    """Drop the pings that belong to no group of echoes.

    Echo points are clustered by K-means (Section 5.1 and reference 25 of the paper).  Stray echoes end in
    clusters of their own, which are too small, or far from the centroid of another.

    Parameters
    ----------
    pings : Pings
        Valid pings of one sweep.
    settings : KmeansSettings, optional
        How many clusters, and what is too few or too far.

    Returns
    -------
    Pings
        The pings that are kept, in the same order.
    """
    settings = settings or KmeansSettings()
    clusters = len(pings) // settings.pings_per_cluster
    if clusters < 2:
        return pings
    points = echo_points(pings)
    labels, centroids = _cluster(points, clusters=clusters, seed=settings.seed)
    distances = np.hypot(*(points - centroids[labels]).T)
    return pings[_is_member(labels, distances, settings)]


def _cluster(points_xy: FloatArray, *, clusters: int, seed: int) -> tuple[IntArray, FloatArray]:
    from sklearn.cluster import KMeans  # noqa: PLC0415 - a second of import that most commands do not need

    found = KMeans(n_clusters=clusters, n_init=1, random_state=seed).fit(points_xy)
    return found.labels_.astype(np.int64), found.cluster_centers_


def _is_member(labels: IntArray, distances: FloatArray, settings: KmeansSettings) -> BoolArray:
    members = np.zeros(len(labels), dtype=bool)
    for label in np.unique(labels):
        own = labels == label
        if own.sum() >= settings.min_members:
            members[own] = distances[own] <= settings.gate_ratio * np.median(distances[own])
    return members
