"""Localisation in a known map: the poses of a recording, from a known or an unknown start.

Each station is registered to the landmarks of the map by scan matching: the first one everywhere in the map, the others
near the pose that odometry predicts. Of several possible starts each is followed until its score is far below that of
the best one. Then the estimator optimises the poses of the best one, with the map as its prior.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from scipy.special import softmax

from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InvalidValueError
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.known_map import known_landmarks, prior_of_map
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses, dead_reckoned, odometry_prior
from echoplan.joint.pose_correction.consistency import inlier_ratio
from echoplan.joint.pose_correction.pose_tracking import local_scans_of
from echoplan.joint.search.global_search import apart, find_poses, pose_grid
from echoplan.joint.search.scan_matching import LandmarkMap, LocalScan, best_score, locate
from echoplan.joint.settings import EstimateSettings
from echoplan.joint.trajectory import joined
from echoplan.model import FeatureMap, Localisation, Rig, StartPose, Stretch, Sweep, translated
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.preprocessing.stations import Stations, at_stations, group_sweeps, without_repeats

__all__ = ["localise"]

# Standard deviations of a start that the user gives [m, m, rad].
_GIVEN = np.array([0.1, 0.1, math.radians(10.0)])
# Score below the best one at which a start is given up [nats].
_GIVEN_UP = 30.0
# Number of starts that are followed.
_MOST = 60
# Share of the score of a perfect match below which a robot may have been carried elsewhere, and number of stations from
# there on by which that is decided.
_LOST, _LOOK_AHEAD = 0.25, 5


def localise(
    sweeps: Sequence[Sweep],
    feature_map: FeatureMap,
    *,
    rig: Rig,
    start: FloatArray | None = None,
    settings: JointSettings | None = None,
) -> Localisation:
    """Find the poses of a recording in a map.

    Parameters
    ----------
    sweeps : sequence of Sweep
        Sweeps with at least one ping, with their poses by odometry.
    feature_map : FeatureMap
        The map.
    rig : Rig
        Sensors that recorded the sweeps.
    start : ndarray, shape (3,), optional
        About where the first sweep was made: x, y and yaw in the frame of the map [m, m, rad]. Anywhere by default.
    settings : JointSettings, optional
        Settings of the estimator.

    Returns
    -------
    Localisation
        The poses, the alternatives to the first one, and how many of the echoes the map explains.

    Raises
    ------
    InvalidValueError
        If the map has no walls, there is no sweep or no echo, the first station fits the map nowhere or not at the
        start, or the map is too large to be searched without a start.
    """
    if not feature_map.walls:
        raise InvalidValueError("the map has no walls")
    # Coordinates of a country are so large that rounding would ruin the normal equations.
    origin = np.append(np.round(feature_map.walls[0].endpoints_xy[0]), 0.0)
    feature_map, settings = translated(feature_map, -origin[:2]), settings or JointSettings()
    estimate, stations = _initial(sweeps, rig, settings=settings)
    landmarks, _ = known_landmarks(feature_map)
    search = _Search(
        scans=local_scans_of(estimate),
        landmark_map=LandmarkMap.of(landmarks),
        grid=pose_grid(np.concatenate([wall.endpoints_xy for wall in feature_map.walls])),
        priors=odometry_prior(stations.poses, settings.pose_errors, estimate.odometry_noise),
        settings=settings,
    )
    parts = _followed(search, None if start is None else start - origin)
    # First sweep of each station, and of each part.
    own = np.unique(stations.numbers, return_index=True)[1]
    firsts = own[[tracks[0].first for tracks in parts]]
    found = []
    for tracks, some in zip(parts, np.split(np.arange(len(sweeps)), firsts[1:]), strict=True):
        prior = prior_of_map(feature_map, tracks[0].poses[0], noise=estimate.first_noise)
        mapper = JointMapper(rig, settings, prior=prior)
        for number in some:
            mapper.add(sweeps[number])
        part, model = mapper.trajectory()
        found.append(part)
    whole = joined(found)
    measurements = at_poses(estimate.recorded, stations.poses, whole.poses[own])
    there = replace(estimate, model=model, poses=whole.poses[own], measurements=measurements, features=landmarks)
    return Localisation(
        sweeps=whole.sweeps,
        poses=whole.poses + origin,
        covariances=whole.covariances,
        stretches=_stretches(parts, whole.sweeps[firsts], origin=origin),
        inlier_ratio=inlier_ratio(replace(there, features=there.refreshed())),
    )


def _initial(sweeps: Sequence[Sweep], rig: Rig, *, settings: EstimateSettings) -> tuple[Estimate, Stations]:
    """Return the estimate before any localisation, and the stations of the sweeps."""
    if not sweeps:
        raise InvalidValueError("the recording has no sweep")
    own = [measurements_of(sweep, rig) for sweep in sweeps]
    recorded = np.array([sweep.station for sweep in sweeps])
    stations = group_sweeps(recorded, np.array([len(each.readings) for each in own]), settings.stations)
    measurements = without_repeats(at_stations(join_measurements(own), stations))
    estimate = initial_estimate(rig, measurements, stations.poses, settings)
    if not estimate.arcs:
        raise InvalidValueError("the recording has no echoes")
    return estimate, stations


class _Track(NamedTuple):
    """Poses of the stations from ``first`` on, shape (k, 3) [m, m, rad], and their scores, shape (k,) [nats]."""

    first: int
    poses: FloatArray
    scores: FloatArray


@dataclass(frozen=True, slots=True, kw_only=True)
class _Search:
    """What poses are searched with: scans of the stations, map, grid of poses and prior of odometry."""

    scans: Sequence[LocalScan]
    landmark_map: LandmarkMap
    grid: FloatArray
    priors: PosePrior
    settings: EstimateSettings

    def begun(self, station: int, start: FloatArray | None = None) -> list[_Track]:
        """Return the poses at which a station fits, near a start or anywhere, the best first; there may be none."""
        scan, settings = self.scans[station], self.settings.localisation
        if start is None:
            poses, scores = find_poses(scan, self.landmark_map, grid=self.grid, settings=settings)
        else:
            pose, score = locate(scan, self.landmark_map, start, _GIVEN, settings)
            poses, scores = pose[None], np.array([score])
        return [_Track(station, pose[None], score[None]) for pose, score in zip(poses, scores, strict=True)]

    def continued(self, tracks: Sequence[_Track], station: int) -> list[_Track]:
        """Register the next station on all tracks, at least one, and give up those far worse than the best one."""
        grown = [self._continued(each, station) for each in tracks]
        totals = np.array([each.scores.sum() for each in grown])
        kept = apart(np.array([each.poses[-1] for each in grown]), totals, most=_MOST)
        return [grown[each] for each in kept if totals[each] >= totals.max() - _GIVEN_UP]

    def _continued(self, track: _Track, station: int) -> _Track:
        poses = np.concatenate([np.zeros((track.first, 3)), track.poses])
        guess, sigmas = dead_reckoned(self.priors.measured_poses, poses, station), 1.3 * self.priors.reaches[station]
        pose, score = locate(self.scans[station], self.landmark_map, guess, sigmas, self.settings.localisation)
        return _Track(track.first, np.append(track.poses, [pose], axis=0), np.append(track.scores, score))

    def hardly_fits(self, track: _Track) -> bool:
        """Return True if the last station of a track may have been made elsewhere."""
        perfect = best_score(self.scans[track.first + len(track.poses) - 1], self.settings.localisation)
        return bool(track.scores[-1] < _LOST * perfect)

    def is_elsewhere(self, tracks: Sequence[_Track], *, before: Sequence[_Track] = ()) -> bool:
        """Return True if the last station of ``tracks`` and those after it fit clearly better anywhere else.

        Any pose of the grid may be the next one, which costs the logarithm of their number. ``before`` are the tracks
        up to the station before it.
        """
        station = tracks[0].first + len(tracks[0].poses) - 1
        anew, onward = self.begun(station), tracks
        if not anew:
            return False
        for later in range(station + 1, min(station + _LOOK_AHEAD, len(self.scans))):
            anew, onward = self.continued(anew, later), self.continued(onward, later)
        best, led, past = (max((each.scores.sum() for each in some), default=0.0) for some in (anew, onward, before))
        return bool(best - math.log(len(self.grid)) > led - past + VERY_STRONG)


def _begun(search: _Search, start: FloatArray | None) -> list[_Track]:
    """Return the poses at which the first station fits, the best first; raise ``InvalidValueError`` if it does not."""
    if start is None and not len(search.grid):
        raise InvalidValueError("the map is too large to be searched everywhere: a start is needed")
    tracks = search.begun(0, start)
    if not tracks:
        raise InvalidValueError("the echoes fit the map nowhere")
    if start is not None and search.is_elsewhere(tracks):
        raise InvalidValueError("the recording does not begin there, but elsewhere in the map")
    return tracks


def _followed(search: _Search, start: FloatArray | None) -> list[list[_Track]]:
    """Return the tracks of each part of the recording that odometry connects, the best first."""
    parts = [_begun(search, start)]
    for station in range(1, len(search.scans)):
        tracks = search.continued(parts[-1], station)
        if search.hardly_fits(tracks[0]) and search.is_elsewhere(tracks, before=parts[-1]):
            parts.append(search.begun(station))
        else:
            parts[-1] = tracks
    return parts


def _stretches(parts: Sequence[Sequence[_Track]], sweeps: IntArray, *, origin: FloatArray) -> tuple[Stretch, ...]:
    """Return the possible first poses of each part of a recording, of which ``sweeps`` are the first sweeps.

    ``origin`` is that of the frame of the tracks in the frame of the map, with yaw 0, shape (3,) [m, m, rad].
    """
    stretches = []
    for tracks, first in zip(parts, sweeps.tolist(), strict=True):
        weights = softmax([each.scores.sum() for each in tracks]).tolist()
        starts = (
            StartPose(pose=each.poses[0] + origin, weight=weight) for each, weight in zip(tracks, weights, strict=True)
        )
        stretches.append(Stretch(first=first, starts=tuple(starts)))
    return tuple(stretches)
