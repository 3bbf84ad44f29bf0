"""The paper's system: rotary array, MDP compensation, polynomial minimum and fuzzy model (Section 5, Figure 9)."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from pydantic import Field

from echoplan.classical.covering import covering_state
from echoplan.classical.features import (
    AssemblySettings,
    Grouped,
    Observation,
    absorb,
    assemble,
    cylinder_of,
    group_lines,
    group_points,
)
from echoplan.classical.fuzzy import FuzzySettings, class_of, corrected_memberships
from echoplan.extraction import (
    Cluster,
    ClusteringSettings,
    LocatedPoint,
    MdpSettings,
    compensated_clusters,
    differential_clusters,
    middle_point,
    minimum_distance_point,
)
from echoplan.model import Cylinder, FeatureClass, FeatureMap, Pings, Rig, Sweep
from echoplan.preprocessing import KmeansSettings, kmeans_filter, valid_pings
from echoplan.preprocessing.stations import StationSettings, group_sweeps
from echoplan.settings import Settings

__all__ = ["MdpFuzzyMapper", "MdpFuzzySettings"]

# Two sweeps are repeated scans of one station if the array neither moved nor turned by more than a step of the servo.
_REPEATED = StationSettings(max_distance=0.01, max_turn=math.radians(1.0), max_pings=2**31)

# The radii in Eq. 5 are settled when none changes by more [m]: a hundredth of what they are uncertain by.
_SETTLED = 1e-4

# A prior this wide [m] moves a radius known to 0.1 m by no more than a micrometre.
_UNINFORMATIVE = 100.0


class MdpFuzzySettings(Settings):
    """Settings of all stages of the paper's system."""

    filter: KmeansSettings = Field(default_factory=KmeansSettings)
    clustering: ClusteringSettings = Field(default_factory=ClusteringSettings)
    order: Literal["paper", "cluster once"] = Field(
        default="paper",
        description="Cluster again after the compensation as in Section 5.2 (paper), or classify the first "
        "clusters (cluster once).",
    )
    mdp: MdpSettings = Field(default_factory=MdpSettings)
    radius_rounds: int = Field(
        default=10,
        ge=0,
        description="Number of rounds in which the radius of the fitted circle goes back into Eq. 5; 0 takes the "
        "expected radius.",
    )
    fuzzy: FuzzySettings = Field(default_factory=FuzzySettings)
    circle: Literal["least squares", "prior"] = Field(
        default="least squares",
        description="Fit cylinders by least squares alone, or with the expected radius and its standard "
        "deviation as a prior.",
    )
    assembly: AssemblySettings = Field(default_factory=AssemblySettings)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Learned:
    """What classifying and locating one cluster needs of all sweeps: L_max [rad] and the fitted circles."""

    max_width: float
    circles: tuple[Cylinder, ...] = ()


class MdpFuzzyMapper:
    """Maps by the method of the 2018 paper.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : MdpFuzzySettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: MdpFuzzySettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or MdpFuzzySettings()
        self._assembly = _assembly_of(self.settings)
        self._sweeps: list[Sweep] = []
        self._clusters: list[list[Cluster]] = []
        self._learned: _Learned | None = None

    def add(self, sweep: Sweep) -> None:
        """Filter and cluster one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        pings = valid_pings(Pings.from_sweep(sweep, self.rig), self.rig)
        self._clusters.append(self.clusters_of(kmeans_filter(pings, self.settings.filter)))
        self._sweeps.append(sweep)
        self._learned = None

    def clusters_of(self, kept: Pings) -> list[Cluster]:
        """Cluster what the filter kept of one sweep, in the order that the settings ask for."""
        if self.settings.order == "paper":
            return compensated_clusters(kept, self.settings.clustering, self.settings.mdp)
        return differential_clusters(kept, self.settings.clustering)

    def result(self) -> FeatureMap:
        """Classify, locate and join all objects of all sweeps.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        # A repeated scan of a station is no second view of an object.
        first = {scan.index: scans[0].index for scans in _by_station(self._sweeps) for scan in scans}
        return assemble(
            self.group([replace(each, sweep=first[each.sweep]) for each in self.observations]),
            self._sweeps,
            self._assembly,
            method="mdp-fuzzy",
            parameters=self.settings.model_dump(mode="json"),
        )

    @property
    def observations(self) -> list[Observation]:
        """Located and classified objects of all sweeps, sweep by sweep."""
        return self._observations(self._learn())

    @property
    def max_width(self) -> float:
        """L_max of Eq. 12 [rad]: the mean of the greatest widths in two repeated scans.

        Where no station was swept twice: the median, over the sweeps, of the width of their widest clusters.
        """
        if self.settings.fuzzy.max_width is not None:
            return self.settings.fuzzy.max_width
        extents = [[cluster.extent for cluster in clusters] for clusters in self._clusters]
        widest = {sweep.index: max(own) for sweep, own in zip(self._sweeps, extents, strict=True) if own}
        if not widest:
            return math.tau
        repeated = _repeated_scans(self._sweeps, widest)
        if repeated:
            return float(np.max(repeated, axis=0).mean())
        return float(np.median(list(widest.values())))

    def observe(self, sweep: Sweep, clusters: list[Cluster]) -> list[Observation]:
        """Classify and locate the objects of one sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings.
        clusters : list of Cluster
            Its clusters.

        Returns
        -------
        list of Observation
            One for each cluster that could be located.
        """
        return self._observe(sweep, clusters, self._learn())

    def group(self, observations: list[Observation]) -> Grouped:
        """Put observations together by object.

        Parameters
        ----------
        observations : list of Observation
            Observations of all sweeps.

        Returns
        -------
        Grouped
            Lines of flats, with what else lies on them; the rest as corners and cylinders.
        """
        return self._group(observations, self._learn())

    def _learn(self) -> _Learned:
        """Find L_max, and circles that were located with their own radii in Eq. 5.

        The first round locates cylinders with the expected radius, each further one with the radii of the circles of
        the last, until none changes.
        """
        if self._learned is not None:
            return self._learned
        learned = _Learned(max_width=self.max_width)
        for _ in range(self.settings.radius_rounds):
            fitted = self._circles(learned)
            settled = _have_settled(learned.circles, fitted)
            learned = replace(learned, circles=fitted)
            if settled:
                break
        self._learned = learned
        return learned

    def _circles(self, learned: _Learned) -> tuple[Cylinder, ...]:
        grouped = self._group(self._observations(learned), learned).confirmed(self._assembly.min_stations)
        fitted = (
            cylinder_of(members, self._assembly.cylinders, association=self._assembly.association)
            for members in grouped.cylinders
        )
        return tuple(cylinder for cylinder in fitted if cylinder is not None)

    def _observations(self, learned: _Learned) -> list[Observation]:
        return [
            each
            for sweep, clusters in zip(self._sweeps, self._clusters, strict=True)
            for each in self._observe(sweep, clusters, learned)
        ]

    def _observe(self, sweep: Sweep, clusters: list[Cluster], learned: _Learned) -> list[Observation]:
        rules = self.settings.fuzzy.rules
        degrees = [
            corrected_memberships(cluster.extent / learned.max_width, covering_state(cluster), rules=rules)
            for cluster in clusters
        ]
        points = [self._locate(each, class_of(own), learned) for each, own in zip(clusters, degrees, strict=True)]
        return [
            Observation(sweep=sweep.index, point=point, degrees=own, pings=len(cluster.pings))
            for cluster, point, own in zip(clusters, points, degrees, strict=True)
            if point is not None
        ]

    def _locate(self, cluster: Cluster, feature_class: FeatureClass, learned: _Learned) -> LocatedPoint | None:
        """Fit the minimum with the curvature of the class (Section 3.2): a flat has none, a corner is a point."""
        resolution = max(sensor.resolution for sensor in self.rig.sensors)

        def located(radius: float) -> LocatedPoint | None:
            """Return the point of least distance, fitted with the curvature of a surface of some radius [m]."""
            return minimum_distance_point(cluster, self.settings.mdp, radius=radius, resolution=resolution)

        if feature_class is FeatureClass.WALL:
            return located(math.inf)
        if feature_class is FeatureClass.CORNER:
            return located(0.0) or middle_point(cluster, resolution=resolution)
        point = located(self._assembly.cylinders.radius)
        return located(self._radius_at(point, learned)) if point and learned.circles else point

    def _radius_at(self, point: LocatedPoint, learned: _Learned) -> float:
        """Radius of the circle on which a point lies within the gate; the expected one where there is none."""
        misses = [abs(float(np.hypot(*(point.position_xy - each.center_xy))) - each.radius) for each in learned.circles]
        nearest = int(np.argmin(misses)) if misses else None
        if nearest is None or misses[nearest] > self._assembly.association.point_gate:
            return self._assembly.cylinders.radius
        return learned.circles[nearest].radius

    def _group(self, observations: list[Observation], learned: _Learned) -> Grouped:
        gates = self._assembly.association
        lines = group_lines(_of_class(observations, FeatureClass.WALL), gates)
        rest = [each for each in observations if class_of(each.degrees) is not FeatureClass.WALL]
        others = absorb(lines, rest, gates)
        cylinders = _of_class(others, FeatureClass.CYLINDER)
        depths = [self._radius_at(each.point, learned) for each in cylinders]
        return Grouped(
            lines=lines,
            corners=_of_class(others, FeatureClass.CORNER),
            cylinders=group_points(cylinders, gates, depth=depths),
        )


def _of_class(observations: list[Observation], feature_class: FeatureClass) -> list[Observation]:
    return [each for each in observations if class_of(each.degrees) is feature_class]


def _assembly_of(settings: MdpFuzzySettings) -> AssemblySettings:
    """Return the settings of the assembly, without a prior of the radius unless one is asked for."""
    if settings.circle == "prior":
        return settings.assembly
    cylinders = settings.assembly.cylinders.model_copy(update={"radius_sigma": _UNINFORMATIVE})
    return settings.assembly.model_copy(update={"cylinders": cylinders})


def _by_station(sweeps: list[Sweep]) -> list[list[Sweep]]:
    """Put sweeps together that follow each other from one pose."""
    if not sweeps:
        return []
    poses, pings = np.array([sweep.station for sweep in sweeps]), np.array([len(sweep) for sweep in sweeps])
    numbers = group_sweeps(poses, pings, _REPEATED).numbers
    stations: list[list[Sweep]] = [[] for _ in range(int(numbers[-1]) + 1)]
    for sweep, number in zip(sweeps, numbers, strict=True):
        stations[number].append(sweep)
    return stations


def _repeated_scans(sweeps: list[Sweep], widest: dict[int, float]) -> list[list[float]]:
    """Return the greatest widths of the first and the second scan of each station with clusters in two."""
    stations = [[widest[scan.index] for scan in scans if scan.index in widest] for scans in _by_station(sweeps)]
    return [widths[:2] for widths in stations if len(widths) > 1]


def _have_settled(earlier: Sequence[Cylinder], later: Sequence[Cylinder]) -> bool:
    if len(earlier) != len(later):
        return False
    changes = [abs(one.radius - other.radius) for one, other in zip(earlier, later, strict=True)]
    return max(changes, default=0.0) <= _SETTLED
