"""The paper's system: rotary array, MDP compensation, polynomial minimum and fuzzy model (Section 5, Figure 9)."""

import math

import numpy as np
from pydantic import BaseModel, Field

from echoplan.classification import FuzzySettings, class_of, corrected_memberships, covering_state
from echoplan.extraction import (
    Cluster,
    ClusteringSettings,
    LocatedPoint,
    MdpSettings,
    differential_clusters,
    middle_point,
    minimum_distance_point,
)
from echoplan.mapping import (
    AssemblySettings,
    Grouped,
    Observation,
    absorb,
    assemble,
    group_lines,
    group_points,
)
from echoplan.model import FeatureClass, FeatureMap, Pings, Rig, Sweep
from echoplan.preprocessing import KmeansSettings, kmeans_filter, valid_pings

__all__ = ["MdpFuzzyMapper", "MdpFuzzySettings"]


class MdpFuzzySettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of all stages of the paper's system."""

    filter: KmeansSettings = Field(default_factory=KmeansSettings)
    clustering: ClusteringSettings = Field(default_factory=ClusteringSettings)
    mdp: MdpSettings = Field(default_factory=MdpSettings)
    fuzzy: FuzzySettings = Field(default_factory=FuzzySettings)
    assembly: AssemblySettings = Field(default_factory=AssemblySettings)


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
        self._sweeps: list[Sweep] = []
        self._clusters: list[list[Cluster]] = []

    def add(self, sweep: Sweep) -> None:
        """Filter and cluster one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        pings = valid_pings(Pings.from_sweep(sweep, self.rig), self.rig)
        kept = kmeans_filter(pings, self.settings.filter)
        self._clusters.append(differential_clusters(kept, self.settings.clustering))
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Classify, locate and join what was heard so far.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        return assemble(
            self.group(self.observations),
            self._sweeps,
            self.settings.assembly,
            method="mdp-fuzzy",
            parameters=self.settings.model_dump(mode="json"),
        )

    @property
    def observations(self) -> list[Observation]:
        """What was located and classified so far, sweep by sweep."""
        return [
            each
            for sweep, clusters in zip(self._sweeps, self._clusters, strict=True)
            for each in self.observe(sweep, clusters)
        ]

    @property
    def max_width(self) -> float:
        """L_max of Eq. 12 [rad]: how wide the widest object of a sweep usually is.

        The paper averages two scans of one scene; the median over all sweeps is the same idea with more
        scans, and one sweep in which two objects ran together cannot spoil it.
        """
        if self.settings.fuzzy.max_width is not None:
            return self.settings.fuzzy.max_width
        widest = [max(cluster.extent for cluster in clusters) for clusters in self._clusters if clusters]
        return float(np.median(widest)) if widest else math.tau

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
        covered = [covering_state(cluster) for cluster in clusters]
        degrees = [
            corrected_memberships(cluster.extent / self.max_width, state, rules=self.settings.fuzzy.rules)
            for cluster, state in zip(clusters, covered, strict=True)
        ]
        located = [self._locate(cluster, class_of(each)) for cluster, each in zip(clusters, degrees, strict=True)]
        return [
            Observation(sweep=sweep.index, point=point, degrees=each, pings=len(cluster.pings))
            for cluster, point, each in zip(clusters, located, degrees, strict=True)
            if point is not None
        ]

    def group(self, heard: list[Observation]) -> Grouped:
        """Put observations together by object.

        Parameters
        ----------
        heard : list of Observation
            Observations of all sweeps.

        Returns
        -------
        Grouped
            Lines of flats, with what else lies on them; the rest as corners and cylinders.
        """
        gates = self.settings.assembly.association
        lines = group_lines(_of_class(heard, FeatureClass.WALL), gates)
        others = absorb(lines, [each for each in heard if class_of(each.degrees) is not FeatureClass.WALL], gates)
        return Grouped(
            lines=lines,
            corners=_of_class(others, FeatureClass.CORNER),
            cylinders=group_points(
                _of_class(others, FeatureClass.CYLINDER), gates, depth=self._radius(FeatureClass.CYLINDER)
            ),
        )

    def _locate(self, cluster: Cluster, feature_class: FeatureClass) -> LocatedPoint | None:
        resolution = max(sensor.resolution for sensor in self.rig.sensors)
        radius = self._radius(feature_class)
        point = minimum_distance_point(cluster, self.settings.mdp, radius=radius, resolution=resolution)
        if point is None and feature_class is FeatureClass.CORNER:
            return middle_point(cluster, resolution=resolution)
        return point

    def _radius(self, feature_class: FeatureClass) -> float:
        """Curvature that the class supposes (Section 3.2): a flat has none, a corner is a point."""
        expected = self.settings.assembly.cylinders.radius
        return {FeatureClass.WALL: math.inf, FeatureClass.CYLINDER: expected, FeatureClass.CORNER: 0.0}[feature_class]


def _of_class(heard: list[Observation], feature_class: FeatureClass) -> list[Observation]:
    return [each for each in heard if class_of(each.degrees) is feature_class]
