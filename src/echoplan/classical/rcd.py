"""The conventional approach: regions of constant depth (the paper's Section 3.1).

Leonard and Durrant-Whyte (1992).  The depth of a region is taken as the distance, its middle as the direction;
nothing is compensated.  What a region is shows over several stations: those of a wall share a tangent, those of a
corner cross in a point, those of a cylinder touch a circle.
"""

import numpy as np
from pydantic import Field

from echoplan.classical.features import (
    AssemblySettings,
    Grouped,
    Observation,
    Target,
    TargetKind,
    assemble,
    find_targets,
)
from echoplan.extraction import (
    ClusteringSettings,
    Rcd,
    RcdSettings,
    differential_clusters,
    region_of_constant_depth,
)
from echoplan.model import FeatureMap, Pings, Rig, Sweep
from echoplan.preprocessing import valid_pings
from echoplan.settings import Settings

__all__ = ["RcdMapper", "RcdMapperSettings"]

_UNDECIDED = np.ones(3)


class RcdMapperSettings(Settings):
    """Settings of all stages of the conventional approach."""

    clustering: ClusteringSettings = Field(default_factory=ClusteringSettings)
    rcd: RcdSettings = Field(default_factory=RcdSettings)
    assembly: AssemblySettings = Field(default_factory=AssemblySettings)
    point_radius: float = Field(default=0.03, gt=0.0, description="Radius below which a circle is a corner [m].")


class RcdMapper:
    """Maps by regions of constant depth.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : RcdMapperSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: RcdMapperSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or RcdMapperSettings()
        self._sweeps: list[Sweep] = []
        self.observations: list[Observation] = []

    def add(self, sweep: Sweep) -> None:
        """Find the regions of one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        pings = valid_pings(Pings.from_sweep(sweep, self.rig), self.rig)
        clusters = differential_clusters(pings, self.settings.clustering)
        regions = [region_of_constant_depth(cluster, self.settings.rcd) for cluster in clusters]
        self.observations += [self._observation(sweep, region) for region in regions if region is not None]
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Join the regions found so far.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders.
        """
        return assemble(
            self.group(self.observations),
            self._sweeps,
            self.settings.assembly,
            method="rcd",
            parameters=self.settings.model_dump(mode="json"),
        )

    def group(self, observations: list[Observation]) -> Grouped:
        """Classify walls, corners and cylinders by what their regions share.

        Parameters
        ----------
        observations : list of Observation
            Regions of all sweeps.

        Returns
        -------
        Grouped
            Walls are line targets; corners are point targets and circles so small that they are points.
        """
        assembly = self.settings.assembly
        targets = find_targets(
            observations, assembly.association, assembly.cylinders, min_stations=assembly.min_stations
        )
        points = [each for each in targets if self._is_point(each)]
        circles = [each for each in targets if each.kind is TargetKind.CIRCLE and not self._is_point(each)]
        return Grouped(
            lines=[each.group for each in targets if each.kind is TargetKind.LINE],
            corners=[member for each in points for member in each.group.members],
            cylinders=[each.group.members for each in circles],
        )

    def _is_point(self, target: Target) -> bool:
        radius = target.group.fit.parameters[2] if target.kind is TargetKind.CIRCLE else 0.0
        return target.kind is not TargetKind.LINE and bool(radius <= self.settings.point_radius)

    def _observation(self, sweep: Sweep, region: Rcd) -> Observation:
        resolution = max(sensor.resolution for sensor in self.rig.sensors)
        return Observation(
            sweep=sweep.index,
            point=region.located(resolution=resolution),
            degrees=_UNDECIDED,
            pings=region.pings,
        )
