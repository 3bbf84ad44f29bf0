"""Line segments by iterative end-point fit and Kalman filter (Yuan et al. 2014; as recalled).

Consecutive echo points of one sensor are taken for points of walls.  A robot that drives along a wall sees them so;
a turning array sees arcs, of which the fit makes chords whose covariances know of the noise and not of the tilt.
"""

from dataclasses import dataclass, replace

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.features.endpoints import split_at_farthest, split_at_steps
from echoplan.classical.features.kalman import KalmanSettings, Track, merged, tracked
from echoplan.classical.points import (
    Cloud,
    SegmentSettings,
    fit_orthogonal,
    join_segments,
    map_of_features,
    segment_of,
)
from echoplan.geometry import signed_distances
from echoplan.model import FeatureMap, Pings, Rig, Sweep
from echoplan.preprocessing import echo_points, valid_pings
from echoplan.settings import Settings

__all__ = ["IepfKalmanMapper", "IepfKalmanSettings"]


class IepfKalmanSettings(Settings):
    """Settings of the end-point fit, of the filter and of the map."""

    max_step: float = Field(
        default=0.3, gt=0.0, description="Largest distance between consecutive points of a chain [m]."
    )
    tolerance: float = Field(
        default=0.03,
        gt=0.0,
        description="Largest distance of a point from the chord; beyond it the chain is split [m].",
    )
    min_points: int = Field(default=4, ge=2, description="Smallest number of points of a segment.")
    min_length: float = Field(default=0.2, gt=0.0, description="Smallest length of a segment [m].")
    min_sweeps: int = Field(default=2, ge=1, description="Smallest number of sweeps that must measure a line.")
    segments: SegmentSettings = Field(default_factory=SegmentSettings)
    filter: KalmanSettings = Field(default_factory=KalmanSettings)
    max_extension: float = Field(
        default=0.5, ge=0.0, description="Largest length by which a wall is extended to meet its neighbour [m]."
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Echoes:
    """Echo points of one sensor, one after the other, with the hub and the sweep of each."""

    points_xy: FloatArray
    origins_xy: FloatArray
    sweeps: IntArray


class IepfKalmanMapper:
    """Maps by line segments through consecutive echo points of each sensor.

    Parameters
    ----------
    rig : Rig
        What made the sweeps.
    settings : IepfKalmanSettings, optional
        Settings of the stages.
    """

    def __init__(self, rig: Rig, settings: IepfKalmanSettings | None = None) -> None:
        self.rig = rig
        self.settings = settings or IepfKalmanSettings()
        self._sweeps: list[Sweep] = []
        self._pings: list[Pings] = []

    def add(self, sweep: Sweep) -> None:
        """Keep the valid echoes of one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        self._pings.append(valid_pings(Pings.from_sweep(sweep, self.rig), self.rig))
        self._sweeps.append(sweep)

    def result(self) -> FeatureMap:
        """Fit, filter and merge the segments of all sensors.

        Returns
        -------
        FeatureMap
            Walls and corners.
        """
        tracks: list[Track] = []
        for sensor in range(len(self.rig.sensors)):
            for measured in self._measured(self._echoes(sensor)):
                tracks = tracked(tracks, measured, self.settings.filter)
        sure = [
            replace(track.segment, stations=len(track.sweeps))
            for track in merged(tracks, self.settings.filter)
            if len(track.sweeps) >= self.settings.min_sweeps
        ]
        return map_of_features(
            join_segments(sure, max_extension=self.settings.max_extension),
            self._sweeps,
            method="iepf-kalman",
            parameters=self.settings.model_dump(mode="json"),
        )

    @property
    def points_xy(self) -> FloatArray:
        """Echo points on the beam axes [m], shape (n, 2)."""
        return np.concatenate([np.zeros((0, 2)), *(echo_points(pings) for pings in self._pings)])

    def _echoes(self, sensor: int) -> _Echoes:
        own = [pings[pings.sensors == sensor] for pings in self._pings]
        sweeps = [np.full(len(pings), sweep.index) for pings, sweep in zip(own, self._sweeps, strict=True)]
        return _Echoes(
            points_xy=np.concatenate([np.zeros((0, 2)), *(echo_points(pings) for pings in own)]),
            origins_xy=np.concatenate([np.zeros((0, 2)), *(pings.origins_xy for pings in own)]),
            sweeps=np.concatenate([np.zeros(0, dtype=np.int64), *sweeps]),
        )

    def _measured(self, echoes: _Echoes) -> list[Track]:
        """Find segments by splitting the chain of a sensor's echoes."""
        found = []
        for chain in split_at_steps(echoes.points_xy, max_step=self.settings.max_step):
            for piece in split_at_farthest(echoes.points_xy[chain], tolerance=self.settings.tolerance):
                points_xy = echoes.points_xy[chain[piece]]
                length = float(np.hypot(*(points_xy[-1] - points_xy[0])))
                if len(points_xy) >= self.settings.min_points and length >= self.settings.min_length:
                    found.append(self._track(echoes, chain[piece]))
        return found

    def _track(self, echoes: _Echoes, piece: IntArray) -> Track:
        cloud = Cloud(points_xy=echoes.points_xy[piece], weights=np.ones(len(piece)))
        line = fit_orthogonal(cloud)
        segment = segment_of(cloud, line, self.settings.segments, members=piece)
        beyond = signed_distances(line, echoes.origins_xy[piece]).mean() > 0
        return Track(segment=segment.turned() if beyond else segment, sweeps=frozenset(echoes.sweeps[piece].tolist()))
