"""The minimum-distance point of a cluster: where the object is, by a least-squares polynomial (Eq. 6-11)."""

from dataclasses import dataclass

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, checked_covariance, checked_floats, store
from echoplan.extraction.clusters import (
    Cluster,
    ClusteringSettings,
    differential_clusters,
    hub_distances,
    indexed_clusters,
)
from echoplan.extraction.compensation import arm_excess
from echoplan.geometry import directions, wrap
from echoplan.model import Pings
from echoplan.settings import Settings

__all__ = [
    "LocatedPoint",
    "MdpSettings",
    "Parabola",
    "compensated_clusters",
    "compensated_distances",
    "fit_parabola",
    "middle_point",
    "minimum_distance_point",
]


class MdpSettings(Settings):
    """Settings of the minimum-distance point."""

    iterations: int = Field(
        default=5,
        ge=1,
        description="Number of rounds of compensation: the normal is unknown until the polynomial is fitted.",
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class LocatedPoint:
    """The nearest point of an object, as seen from the hub of the array.

    Parameters
    ----------
    hub_xy : ndarray, shape (2,)
        Position of the turret's axis [m].
    bearing : float
        Direction of the object's normal, outward from the hub [rad].
    distance : float
        Distance of the object from the hub [m].
    covariance : ndarray, shape (2, 2)
        Of bearing and distance, in that order [rad, m].
    """

    hub_xy: FloatArray
    bearing: float
    distance: float
    covariance: FloatArray

    def __post_init__(self) -> None:
        store(
            self,
            hub_xy=checked_floats(self.hub_xy, name="hub_xy", shape=(2,)),
            covariance=checked_covariance(self.covariance, name="covariance", size=2),
        )

    @property
    def position_xy(self) -> FloatArray:
        """The point itself [m], shape (2,)."""
        return self.hub_xy + self.distance * directions(self.bearing)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Parabola:
    """A least-squares parabola ``y = a0 + a1 x + a2 x**2`` about a centre of x.

    Parameters
    ----------
    center : float
        Where x is 0 [rad].
    coefficients : ndarray, shape (3,)
        a0, a1, a2 in metres and powers of radians.
    covariance : ndarray, shape (3, 3)
        Of the coefficients.
    """

    center: float
    coefficients: FloatArray
    covariance: FloatArray

    @property
    def opens_upward(self) -> bool:
        """Whether the parabola has a minimum at all."""
        return bool(self.coefficients[2] > 0)

    @property
    def vertex(self) -> FloatArray:
        """Bearing and distance of the minimum [rad, m], shape (2,)."""
        a0, a1, a2 = self.coefficients
        return np.array([self.center - a1 / (2 * a2), a0 - a1**2 / (4 * a2)])

    @property
    def vertex_covariance(self) -> FloatArray:
        """Covariance of the vertex by the delta method, shape (2, 2) [rad, m]."""
        _, a1, a2 = self.coefficients
        jacobian = np.array(
            [
                [0.0, -1 / (2 * a2), a1 / (2 * a2**2)],
                [1.0, -a1 / (2 * a2), a1**2 / (4 * a2**2)],
            ]
        )
        covariance: FloatArray = jacobian @ self.covariance @ jacobian.T
        return (covariance + covariance.T) / 2


def fit_parabola(bearings: FloatArray, distances: FloatArray, *, floor: float = 0.0) -> Parabola | None:
    """Fit a parabola by least squares (Eq. 6-11 with m = 2).

    The normal equations of Eq. 9 and 11 lose half the digits; the same minimiser comes from an orthogonal
    factorisation of the centred, scaled system of Eq. 10.

    Parameters
    ----------
    bearings : ndarray, shape (n,)
        x [rad].
    distances : ndarray, shape (n,)
        y [m].
    floor : float, optional
        Least standard deviation of a distance [m]: what quantisation alone leaves.

    Returns
    -------
    Parabola or None
        None if fewer than three distinct bearings leave the parabola undetermined.

    Examples
    --------
    >>> x = np.array([0.0, 0.1, 0.2, 0.3])
    >>> fit_parabola(x, 1.0 + (x - 0.12) ** 2).vertex.round(6)
    array([0.12, 1.  ])
    """
    if len(np.unique(bearings)) < 3:
        return None
    center, scale = float(bearings.mean()), float(np.ptp(bearings)) / 2
    design = np.vander((bearings - center) / scale, 3, increasing=True)
    q, r = np.linalg.qr(design)
    scaled = np.linalg.solve(r, q.T @ distances)
    residuals = distances - design @ scaled
    variance = max(float(residuals @ residuals) / max(len(bearings) - 3, 1), floor**2)
    inverse = np.linalg.inv(r)
    unscale = scale ** -np.arange(3.0)
    return Parabola(
        center=center,
        coefficients=scaled * unscale,
        covariance=variance * (inverse @ inverse.T) * np.outer(unscale, unscale),
    )


def compensated_distances(cluster: Cluster, *, normal: float, depth: float, radius: float = np.inf) -> FloatArray:
    """Take out of distances what the turning arm added (Eq. 1-5).

    Parameters
    ----------
    cluster : Cluster
        Echoes of one object.
    normal : float
        Direction of the object's normal [rad].
    depth : float
        The reading in that direction [m].
    radius : float, optional
        Curvature of the object [m]: ``inf`` flat, 0 corner.

    Returns
    -------
    ndarray, shape (n,)
        Distance of the object from the hub by each echo [m].
    """
    arms_xy = cluster.pings.origins_xy - cluster.pings.hubs_xy
    arms, angles = np.hypot(*arms_xy.T), np.arctan2(arms_xy[:, 1], arms_xy[:, 0])
    excess = arm_excess(wrap(angles - normal), arm=arms, depth=depth, radius=radius)
    distances: FloatArray = cluster.pings.ranges + arms - excess
    return distances


def minimum_distance_point(
    cluster: Cluster, settings: MdpSettings | None = None, *, radius: float = np.inf, resolution: float = 0.0
) -> LocatedPoint | None:
    """Locate the object of a cluster: compensate, fit, and again with the better normal.

    With a the curvature that is left without the arm b, a normal wrong by n moves the vertex by -n b / (2 a), so a
    Newton step divides the change by 1 + b / (2 a).

    Parameters
    ----------
    cluster : Cluster
        Echoes of one object.
    settings : MdpSettings, optional
        How many rounds.
    radius : float, optional
        Curvature of the object that the class supposes [m]: ``inf`` flat, 0 corner (Eq. 5).
    resolution : float, optional
        Step of the readings [m].

    Returns
    -------
    LocatedPoint or None
        The vertex of the parabola; None where the parabola opens downward or has its vertex outside the cluster,
        because such a cluster shows no nearest point.
    """
    settings = settings or MdpSettings()
    arm = float(np.hypot(*(cluster.pings.origins_xy - cluster.pings.hubs_xy).T).mean())
    normal = float(cluster.bearings[np.argmin(cluster.distances)])
    depth = float(cluster.pings.ranges.min())
    parabola = None
    for _ in range(settings.iterations):
        distances = compensated_distances(cluster, normal=normal, depth=depth, radius=radius)
        parabola = fit_parabola(cluster.bearings, distances, floor=resolution / np.sqrt(12))
        if parabola is None or not parabola.opens_upward:
            return None
        bearing, distance = parabola.vertex
        depth = max(float(distance) - arm, 0.0)
        # A normal that is off by n comes back off by -gain n, and would run away from a gain above 1 if taken whole.
        gain = arm / (2 * float(parabola.coefficients[2]))
        normal += (float(bearing) - normal) / (1 + gain)
        normal = float(np.clip(normal, cluster.bearings[0], cluster.bearings[-1]))
    if parabola is None or not cluster.bearings[0] <= parabola.vertex[0] <= cluster.bearings[-1]:
        return None
    bearing, distance = parabola.vertex
    # The vertex lies in the window of the cluster, however flat the parabola: sigma is at most that of the window.
    sigma = float(np.sqrt(parabola.vertex_covariance[0, 0]))
    shrink = np.array([min(1.0, cluster.extent / np.sqrt(12) / sigma) if sigma > 0 else 1.0, 1.0])
    return LocatedPoint(
        hub_xy=cluster.hub_xy,
        bearing=float(bearing),
        distance=float(distance),
        covariance=parabola.vertex_covariance * np.outer(shrink, shrink),
    )


def compensated_clusters(
    pings: Pings, clustering: ClusteringSettings | None = None, mdp: MdpSettings | None = None
) -> list[Cluster]:
    """Cluster, take the arm out of each cluster, and cluster the compensated distances again (Section 5.2).

    The class of an object follows from the second clustering, so the first compensation takes it for a flat (Eq. 1).
    Clusters without a nearest point keep their distances.

    Parameters
    ----------
    pings : Pings
        Valid pings of one sweep.
    clustering : ClusteringSettings, optional
        What is a jump and what is a gap.
    mdp : MdpSettings, optional
        Rounds of compensation.

    Returns
    -------
    list of Cluster
        The clusters of the second round, with the distances as measured.
    """
    distances = hub_distances(pings)
    for cluster, indices in indexed_clusters(pings, clustering):
        point = minimum_distance_point(cluster, mdp)
        if point is not None:
            distances[indices] = compensated_distances(cluster, normal=point.bearing, depth=point.distance)
    return differential_clusters(pings, clustering, distances=distances)


def middle_point(cluster: Cluster, *, resolution: float = 0.0) -> LocatedPoint:
    """Locate an object by the middle of its cluster.

    A point has the same distance in every direction of the beam, so its distances have no minimum to fit; its
    direction lies anywhere in the window in which nothing else was detected.

    Parameters
    ----------
    cluster : Cluster
        Echoes of one object.
    resolution : float, optional
        Step of the readings [m].

    Returns
    -------
    LocatedPoint
        Middle of the window and mean distance, as uncertain as the window is wide.
    """
    scatter = float(np.var(cluster.distances)) + resolution**2 / 12
    return LocatedPoint(
        hub_xy=cluster.hub_xy,
        bearing=float(cluster.bearings[[0, -1]].mean()),
        distance=float(cluster.distances.mean()),
        covariance=np.diag([cluster.extent**2 / 12, scatter]),
    )
