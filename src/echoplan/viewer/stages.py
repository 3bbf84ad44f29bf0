"""What the stages of the paper's method made of one sweep, step by step, for pictures of them."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.classical.features import Observation
from echoplan.classical.fuzzy import class_of
from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper
from echoplan.extraction import (
    Cluster,
    LocatedPoint,
    Parabola,
    compensated_distances,
    fit_parabola,
)
from echoplan.geometry import signed_distances, wrap
from echoplan.model import FeatureClass, Pings, Sweep
from echoplan.preprocessing import kmeans_filter, valid_pings

__all__ = [
    "Fitted",
    "Located",
    "SweepStages",
    "WallProfile",
    "example",
    "fitted_cluster",
    "sweep_stages",
    "wall_profile",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Located:
    """A cluster and its detection.

    Parameters
    ----------
    cluster : Cluster
        Echoes of one object.
    observation : Observation or None
        Its place and class; None where the cluster shows no nearest point.
    """

    cluster: Cluster
    observation: Observation | None

    @property
    def feature_class(self) -> FeatureClass | None:
        """Class of the largest membership; None where there is no observation."""
        return None if self.observation is None else class_of(self.observation.degrees)


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepStages:
    """One sweep, stage by stage.

    Parameters
    ----------
    index : int
        Number of the sweep.
    valid : Pings
        All echoes.
    kept : Pings
        Those that the filter kept.
    located : tuple of Located
        The clusters, counter-clockwise.
    """

    index: int
    valid: Pings
    kept: Pings
    located: tuple[Located, ...]

    @property
    def stray(self) -> Pings:
        """Echoes in no cluster: dropped by the filter, or too few of a kind."""
        clustered = {each for located in self.located for each in _readings(located.cluster.pings)}
        return self.valid[np.array([each not in clustered for each in _readings(self.valid)], dtype=bool)]

    @property
    def observations(self) -> tuple[Observation, ...]:
        """What was located."""
        return tuple(each.observation for each in self.located if each.observation is not None)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Fitted:
    """A cluster as the polynomial saw it.

    Parameters
    ----------
    cluster : Cluster
        The echoes.
    point : LocatedPoint
        The minimum.
    distances : ndarray, shape (n,)
        Compensated distances [m].
    parabola : Parabola
        What was fitted to them.
    """

    cluster: Cluster
    point: LocatedPoint
    distances: FloatArray
    parabola: Parabola

    def __post_init__(self) -> None:
        count = len(self.cluster.pings)
        store(self, distances=checked_floats(self.distances, name="distances", shape=(count,)))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class WallProfile:
    """Distances of one wall against the angle from its normal.

    Parameters
    ----------
    angles : ndarray, shape (n,)
        Angle of the beam axis from the normal [rad].
    measured : ndarray, shape (n,)
        Reading plus the length of the arm [m].
    compensated : ndarray, shape (n,)
        The same after Eq. 1 [m].
    distance : float
        Distance of the wall from the hub [m].
    """

    angles: FloatArray
    measured: FloatArray
    compensated: FloatArray
    distance: float

    def __post_init__(self) -> None:
        angles = checked_floats(self.angles, name="angles", shape=(None,))
        store(
            self,
            angles=angles,
            measured=checked_floats(self.measured, name="measured", shape=angles.shape),
            compensated=checked_floats(self.compensated, name="compensated", shape=angles.shape),
        )


def sweep_stages(mapper: MdpFuzzyMapper, sweep: Sweep) -> SweepStages:
    """Run the stages of the paper's method once more on one sweep.

    Parameters
    ----------
    mapper : MdpFuzzyMapper
        A mapper that was given all sweeps, because the greatest width of a cluster is taken from all.
    sweep : Sweep
        One of them.

    Returns
    -------
    SweepStages
        What each stage gave.
    """
    valid = valid_pings(Pings.from_sweep(sweep, mapper.rig), mapper.rig)
    kept = kmeans_filter(valid, mapper.settings.filter)
    clusters = mapper.clusters_of(kept)
    located = (Located(cluster=each, observation=next(iter(mapper.observe(sweep, [each])), None)) for each in clusters)
    return SweepStages(index=sweep.index, valid=valid, kept=kept, located=tuple(located))


def fitted_cluster(located: Located, *, radius: float = np.inf) -> Fitted | None:
    """Fit the polynomial of a located cluster once more.

    Parameters
    ----------
    located : Located
        The cluster and its minimum.
    radius : float, optional
        Curvature that its class supposes [m].

    Returns
    -------
    Fitted or None
        None where nothing was located or nothing can be fitted.
    """
    if located.observation is None:
        return None
    point = located.observation.point
    distances = _compensated(located.cluster, normal=point.bearing, distance=point.distance, radius=radius)
    parabola = fit_parabola(located.cluster.bearings, distances)
    if parabola is None:
        return None
    return Fitted(cluster=located.cluster, point=point, distances=distances, parabola=parabola)


def wall_profile(located: Located, lines: FloatArray) -> WallProfile | None:
    """Compare the distances of a cluster with those to the wall that gave them.

    Parameters
    ----------
    located : Located
        A cluster and its minimum.
    lines : ndarray, shape (m, 2)
        Walls, true or mapped, as ``(normal_angle, offset)`` [rad, m].

    Returns
    -------
    WallProfile or None
        Against the line that lies nearest to the minimum; None where nothing was located or there is no line.
    """
    if located.observation is None or not len(lines):
        return None
    point, cluster = located.observation.point, located.cluster
    line = lines[np.argmin(_misfits(point, lines))]
    signed = -float(signed_distances(line, cluster.hub_xy))
    normal = float(line[0]) if signed >= 0 else float(line[0]) + np.pi
    return WallProfile(
        angles=wrap(cluster.bearings - normal),
        measured=cluster.pings.ranges + _arms(cluster),
        compensated=_compensated(cluster, normal=normal, distance=abs(signed), radius=np.inf),
        distance=abs(signed),
    )


def example(stages: Sequence[SweepStages], feature_class: FeatureClass, *, distance: float = 1.0) -> Located | None:
    """Pick a cluster that shows what its class looks like.

    Parameters
    ----------
    stages : sequence of SweepStages
        Some sweeps.
    feature_class : FeatureClass
        The class.
    distance : float, optional
        How far away its object should be [m]; the paper measured at 1 m.

    Returns
    -------
    Located or None
        The one whose distance is nearest to that; None where there is none of the class.
    """
    of_class = [
        (abs(each.observation.point.distance - distance), number, each)
        for number, each in enumerate(each for sweep in stages for each in sweep.located)
        if each.observation is not None and each.feature_class is feature_class
    ]
    return min(of_class)[2] if of_class else None


def _readings(pings: Pings) -> list[tuple[float, ...]]:
    return list(zip(pings.sensors.tolist(), pings.bearings.tolist(), pings.ranges.tolist(), strict=True))


def _arms(cluster: Cluster) -> FloatArray:
    arms: FloatArray = np.hypot(*(cluster.pings.origins_xy - cluster.pings.hubs_xy).T)
    return arms


def _compensated(cluster: Cluster, *, normal: float, distance: float, radius: float) -> FloatArray:
    depth = max(distance - float(_arms(cluster).mean()), 0.0)
    return compensated_distances(cluster, normal=normal, depth=depth, radius=radius)


def _misfits(point: LocatedPoint, lines: FloatArray) -> FloatArray:
    """How far a located point is from lines, and how far its normal from theirs, as lengths at its distance [m]."""
    away = signed_distances(lines, point.position_xy)
    turns = wrap(2 * (lines[:, 0] - point.bearing)) / 2
    misfits: FloatArray = np.hypot(away, point.distance * np.sin(turns))
    return misfits
