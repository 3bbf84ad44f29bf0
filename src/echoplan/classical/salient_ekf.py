"""Salient features and an extended Kalman filter: maps while it corrects the odometry.

After the idea of Lee and Song (2010), here as recalled from summaries, not from the article itself: returns that lie
on a common circle come from one reflector and determine it better than any one of them.  In a sweep from one place that
circle is a region of constant depth about the sensor.  Its middle is the sighting; lines and circles that explain the
sightings of several sweeps are the landmarks of an EKF over the last poses and the map (Smith, Self and Cheeseman
1990), matched by the gate of their Mahalanobis distance.
"""

from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.features import AssemblySettings, Fit, Group, Grouped, Observation, assemble
from echoplan.classical.features.walls import opened_by
from echoplan.classical.slam import CIRCLE, LINE, Landmark, Slam, SlamSettings
from echoplan.extraction import (
    Cluster,
    ClusteringSettings,
    LocatedPoint,
    RcdSettings,
    differential_clusters,
    minimum_distance_point,
)
from echoplan.geometry import invert, signed_distances, transform_points, wrap
from echoplan.model import Cylinder, FeatureMap, Pings, Rig, Sweep
from echoplan.preprocessing import valid_pings
from echoplan.settings import Settings

__all__ = ["SalientEkfMapper", "SalientEkfSettings"]

_DEGREES = {LINE.name: np.array([0.0, 0.0, 1.0]), CIRCLE.name: np.array([0.0, 1.0, 0.0])}
_CORNER, _UNDECIDED = np.array([1.0, 0.0, 0.0]), np.ones(3)


class SalientEkfSettings(Settings):
    """Settings of all stages."""

    former_keys: ClassVar = {"certainty": "min_radius_z"}

    clustering: ClusteringSettings = Field(default_factory=ClusteringSettings)
    rcd: RcdSettings = Field(default_factory=RcdSettings)
    slam: SlamSettings = Field(default_factory=SlamSettings)
    assembly: AssemblySettings = Field(default_factory=AssemblySettings)
    min_radius_z: float = Field(
        default=2.0,
        ge=0.0,
        description="Number of standard deviations by which the radius of a cylinder exceeds that of a corner.",
    )


class SalientEkfMapper:
    """Maps by salient features and an extended Kalman filter, and corrects the poses.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : SalientEkfSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: SalientEkfSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or SalientEkfSettings()
        self.slam = Slam(self.settings.slam)
        self._sweeps: list[Sweep] = []

    def add(self, sweep: Sweep) -> None:
        """Find what is salient in one more sweep, and filter it.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        pings = valid_pings(Pings.from_sweep(sweep, self.rig), self.rig)
        clusters = differential_clusters(pings, self.settings.clustering)
        salient = [seen for cluster in clusters if (seen := self._sighting(sweep, cluster)) is not None]
        self.slam.add(sweep.index, sweep.station, salient)
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Make a map of the landmarks.

        Returns
        -------
        FeatureMap
            Walls, corners and cylinders, and the corrected poses.
        """
        assembled = assemble(
            self._grouped(),
            self._sweeps,
            self.settings.assembly,
            method="salient-ekf",
            parameters=self.settings.model_dump(mode="json"),
        )
        confirmed = [
            each for each in self._circles(round_ones=True) if _stations(each) >= self.settings.assembly.min_stations
        ]
        cylinders = tuple(self._cylinder(each) for each in confirmed)
        poses = self.slam.poses
        return replace(assembled, walls=opened_by(poses[:, :2], assembled.walls), cylinders=cylinders, poses=poses)

    @property
    def observations(self) -> list[Observation]:
        """What was seen of the landmarks, as it lies in the map after the correction."""
        return [each for landmark in self.slam.landmarks for each in self._members(landmark)]

    def _sighting(self, sweep: Sweep, cluster: Cluster) -> Observation | None:
        resolution = max(sensor.resolution for sensor in self.rig.sensors)
        point = minimum_distance_point(cluster, resolution=resolution)
        if point is None:
            return None
        return Observation(
            sweep=sweep.index, point=_placed(point, invert(sweep.station)), degrees=_UNDECIDED, pings=len(cluster.pings)
        )

    def _grouped(self) -> Grouped:
        """Hand lines and corners to the assembly; cylinders are the filter's own."""
        return Grouped(
            lines=[self._group(each) for each in self.slam.landmarks if each.shape is LINE],
            corners=[seen for each in self._circles(round_ones=False) for seen in self._members(each, _CORNER)],
        )

    def _circles(self, *, round_ones: bool) -> list[Landmark]:
        circles = [each for each in self.slam.landmarks if each.shape is CIRCLE]
        sigmas = [np.sqrt(self._covariance(each)[2, 2]) for each in circles]
        return [
            each
            for each, sigma in zip(circles, sigmas, strict=True)
            if (self._value(each)[2] > self.settings.min_radius_z * sigma) == round_ones
        ]

    def _members(self, landmark: Landmark, degrees: FloatArray | None = None) -> tuple[Observation, ...]:
        decided = _DEGREES[landmark.shape.name] if degrees is None else degrees
        return tuple(
            replace(each, point=_placed(each.point, self.slam.pose(each.sweep)), degrees=decided)
            for each in landmark.sightings
        )

    def _group(self, landmark: Landmark) -> Group:
        """Hand a line on to the assembly with the parameters and the covariance that the filter gave it."""
        members, line = self._members(landmark), self._value(landmark)
        points = [member.point for member in members]
        return Group(
            members=members,
            fit=Fit(
                parameters=np.array([float(wrap(line[0])), line[1]]),
                covariance=self._covariance(landmark),
                bearing_residuals=wrap([point.bearing - line[0] for point in points]),
                distance_residuals=signed_distances(line, [point.position_xy for point in points]),
            ),
        )

    def _cylinder(self, landmark: Landmark) -> Cylinder:
        members, circle = self._members(landmark), self._value(landmark)
        return Cylinder(
            center_xy=circle[:2],
            radius=float(circle[2]),
            covariance=self._covariance(landmark),
            pings=sum(member.pings for member in members),
            stations=_stations(landmark),
        )

    def _value(self, landmark: Landmark) -> FloatArray:
        return self.slam.state[landmark.name]

    def _covariance(self, landmark: Landmark) -> FloatArray:
        return self.slam.state.marginal([landmark.name]).covariance


def _is_whole(cluster: Cluster) -> bool:
    """Return True if no nearer echo covers an end of a cluster, which would displace its middle."""
    return min(cluster.right, cluster.left) > float(cluster.distances.min())


def _placed(point: LocatedPoint, pose: FloatArray) -> LocatedPoint:
    return LocatedPoint(
        hub_xy=transform_points(pose, point.hub_xy),
        bearing=point.bearing + float(pose[2]),
        distance=point.distance,
        covariance=point.covariance,
    )


def _stations(landmark: Landmark) -> int:
    return len({sighting.sweep for sighting in landmark.sightings})
