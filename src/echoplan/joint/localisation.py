"""Localisation in a known map: the poses of a recording, from a known or an unknown start.

Each station is registered to the landmarks of the map by scan matching: the first one everywhere in the map, the others
near the pose that odometry predicts. Of several possible starts each is followed until its score is far below that of
the best one. The poses of those that remain are optimised, with the map as their prior, and compared by what the map
explains and what it should have returned. The estimator then goes on from the likeliest one.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from scipy.special import softmax

from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InvalidValueError
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.known_map import known_landmarks, prior_of_map
from echoplan.joint.likelihood.hypothesis_scores import STRONGEST_MISS, missed
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses, dead_reckoned, odometry_prior
from echoplan.joint.pose_correction.consistency import inlier_ratio
from echoplan.joint.pose_correction.pose_tracking import local_scans_of
from echoplan.joint.search.global_search import SAME_PLACE, apart, find_poses, pose_grid
from echoplan.joint.search.scan_matching import LandmarkMap, LocalScan, best_score, locate
from echoplan.joint.settings import EstimateSettings
from echoplan.joint.trajectory import joined
from echoplan.model import FeatureMap, Localisation, Rig, StartPose, Sweep, TrajectorySegment, translated
from echoplan.preprocessing.measurements import join_measurements, measurements_of, rearranged_stations
from echoplan.preprocessing.stations import Stations, at_stations, group_sweeps, without_repeats

__all__ = ["localise"]

# Standard deviations of a start that the user gives [m, m, rad].
_START_SIGMAS = np.array([0.1, 0.1, math.radians(10.0)])
# Score below that of the best track at which a track is given up [nats].
_MAX_SCORE_LOSS = 30.0
# Number of tracks that are followed.
_MAX_TRACKS = 120
# Number of tracks that are optimised, some tenths of a second each, and greatest number of iterations.
_MAX_OPTIMISED, _ROUNDS = 20, 3
# Optimisation begins with this multiple of the noise of the readings, as scan matching errs by centimetres.
_COARSE = 4.0
# Share of a perfect score below which a robot may have been carried elsewhere, and number of stations from there on by
# which that is decided.
_MIN_FIT, _LOOK_AHEAD = 0.25, 5


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
        landmark_map=LandmarkMap.of(landmarks, np.zeros((0, 2))),
        grid=pose_grid(np.concatenate([*(wall.endpoints_xy for wall in feature_map.walls), feature_map.poses[:, :2]])),
        priors=odometry_prior(stations.poses, settings.pose_errors, estimate.odometry_noise),
        settings=settings,
    )
    followed = _followed(search, None if start is None else start - origin)
    parts = list(map(partial(_weighed, estimate=estimate, feature_map=feature_map, rig=rig), followed))
    # Indices of the first sweep of each station, and of each part.
    of_stations = np.unique(stations.numbers, return_index=True)[1]
    of_parts = of_stations[[tracks[0].first for tracks in parts]]
    trajectories = []
    for tracks, indices in zip(parts, np.split(np.arange(len(sweeps)), of_parts[1:]), strict=True):
        prior = prior_of_map(feature_map, tracks[0].poses[0], noise=estimate.first_noise)
        mapper = JointMapper(rig, settings, prior=prior)
        for index in indices:
            mapper.add(sweeps[index])
        trajectory, model = mapper.trajectory()
        trajectories.append(trajectory)
    found = joined(trajectories)
    poses = found.poses[of_stations]
    measurements = at_poses(estimate.recorded, stations.poses, poses)
    located = replace(estimate, model=model, poses=poses, measurements=measurements, features=landmarks)
    return Localisation(
        sweeps=found.sweeps,
        poses=found.poses + origin,
        covariances=found.covariances,
        segments=_segments(parts, found.sweeps[of_parts], origin=origin),
        inlier_ratio=inlier_ratio(located.rescore(located.noise)),
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
    """Poses of the stations from ``first`` on, shape (k, 3) [m, m, rad], their scores, shape (k,) [nats], a weight."""

    first: int
    poses: FloatArray
    scores: FloatArray
    weight: float = 1.0


@dataclass(frozen=True, kw_only=True)
class _Search:
    """What poses are searched with: scans of the stations, map, grid of poses and prior of odometry."""

    scans: Sequence[LocalScan]
    landmark_map: LandmarkMap
    grid: FloatArray
    priors: PosePrior
    settings: EstimateSettings

    @cached_property
    def perfect(self) -> FloatArray:
        """Scores of perfect matches, shape (s,) [nats]."""
        return np.array([best_score(each, self.settings.localisation) for each in self.scans])

    def begun(self, station: int, start: FloatArray | None = None) -> list[_Track]:
        """Return the poses at which a station fits, near a start or anywhere, the best first; there may be none."""
        scan, settings = self.scans[station], self.settings.localisation
        if start is None:
            poses, scores = find_poses(scan, self.landmark_map, grid=self.grid, settings=settings)
        else:
            pose, score = locate(scan, self.landmark_map, start, _START_SIGMAS, settings)
            poses, scores = pose[None], np.array([score])
        return [_Track(station, pose[None], score[None]) for pose, score in zip(poses, scores, strict=True)]

    def continued(self, tracks: Sequence[_Track], station: int) -> list[_Track]:
        """Register the next station on all tracks, at least one, and give up those far worse than the best one."""
        grown = [after for each in tracks for after in self._continued(each, station)]
        totals = np.array([each.scores.sum() for each in grown])
        kept = apart(np.array([each.poses[-1] for each in grown]), totals, most=_MAX_TRACKS)
        return [grown[each] for each in kept if totals[each] >= totals.max() - _MAX_SCORE_LOSS]

    def _continued(self, track: _Track, station: int) -> Iterator[_Track]:
        """Register the next station where odometry leads from the last one, and from the last one that fits.

        The farther it may be from there, the less probable is each place.
        """
        poses = np.concatenate([np.zeros((track.first, 3)), track.poses])
        guess, near = dead_reckoned(self.priors.measured_poses, poses, station), self.priors.reaches[station]
        far = self._reach_of_odometry(track, station)
        for reach in (near, far) if self.fit(track, last=1) < _MIN_FIT else (near,):
            pose, score = locate(self.scans[station], self.landmark_map, guess, 1.3 * reach, self.settings.localisation)
            score -= float(np.log(reach / near).sum())
            yield _Track(track.first, np.append(track.poses, [pose], axis=0), np.append(track.scores, score))

    def _reach_of_odometry(self, track: _Track, station: int) -> FloatArray:
        """Return the standard deviations of odometry since the last station that fits [m, m, rad]."""
        fits = track.scores > _MIN_FIT * self.perfect[track.first : station]
        after = track.first + 1 + int(np.flatnonzero(fits).max(initial=0))
        reach: FloatArray = np.sqrt((self.priors.reaches[after : station + 1] ** 2).sum(axis=0))
        way = np.diff(self.priors.measured_poses[after : station + 1, :2], axis=0)
        reach[:2] += np.hypot(*way.T).sum() * reach[2]
        return reach

    def fit(self, track: _Track, *, last: int) -> float:
        """Return the share of a perfect score that the ``last`` stations of a track have."""
        stations = slice(track.first + len(track.poses) - last, track.first + len(track.poses))
        return float(track.scores[-last:].sum() / max(self.perfect[stations].sum(), 1e-9))

    def is_elsewhere(self, tracks: Sequence[_Track], *, before: Sequence[_Track] = ()) -> bool:
        """Return True if the last station of ``tracks`` and those after it fit clearly better anywhere else.

        Any pose of the grid may be the next one, which costs the logarithm of their number; and the other place must
        fit well in itself, as a robot may also have left the map. ``before`` are the tracks up to the station before.
        """
        station = tracks[0].first + len(tracks[0].poses) - 1
        restarted, onward = self.begun(station), tracks
        if not restarted:
            return False
        for later in range(station + 1, min(station + _LOOK_AHEAD, len(self.scans))):
            restarted, onward = self.continued(restarted, later), self.continued(onward, later)
        there, here, past = (
            max((each.scores.sum() for each in some), default=0.0) for some in (restarted, onward, before)
        )
        # A robot in the map leaves few echoes unexplained; one outside of it, all: the matches must outweigh the rest.
        match = math.log1p(1.0 / self.settings.localisation.outlier_likelihood)
        miss = -math.log(1.0 - self.settings.min_inlier_ratio)
        is_inside = self.fit(restarted[0], last=len(restarted[0].poses)) > miss / (match + miss)
        return bool(is_inside and there - math.log(len(self.grid)) > here - past + VERY_STRONG)


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
        hardly_fits = search.fit(tracks[0], last=1) < _MIN_FIT
        if hardly_fits and search.is_elsewhere(tracks, before=parts[-1]):
            parts.append(search.begun(station))
        else:
            parts[-1] = tracks
    return parts


def _weighed(tracks: Sequence[_Track], *, estimate: Estimate, feature_map: FeatureMap, rig: Rig) -> list[_Track]:
    """Return the best track of each place with its weight at optimised poses, the likeliest first."""
    ends, totals = np.array([each.poses[-1] for each in tracks]), np.array([each.scores.sum() for each in tracks])
    tracks = [tracks[each] for each in apart(ends, totals, most=_MAX_OPTIMISED, same=SAME_PLACE)]
    if len(tracks) == 1:
        return tracks
    first, last = tracks[0].first, tracks[0].first + len(tracks[0].poses)
    recorded, measured = rearranged_stations(estimate.recorded, range(first, last)), estimate.measured_poses[first:last]
    log_odds = []
    for track in tracks:
        prior = prior_of_map(feature_map, track.poses[0], noise=estimate.first_noise)
        initial = initial_estimate(rig, recorded, measured, estimate.settings, prior)
        now = replace(initial, poses=track.poses, measurements=at_poses(recorded, measured, track.poses))
        for noise in (_COARSE * initial.noise, initial.noise):
            now = now.rescore(noise).alternate(noise, initial.odometry(), _ROUNDS)
        log_odds.append(_log_odds(now))
    weights = softmax(log_odds)
    return [tracks[each]._replace(weight=float(weights[each])) for each in np.argsort(-weights)]


def _log_odds(estimate: Estimate) -> float:
    """Return the log odds of poses in a known map [nats].

    Readings of an arc share the errors of the map and of the sonar model, so it counts as one reading, with the odds
    that the right map explains it; and a landmark that a station misses entirely as an arc that it does not explain.
    """
    explained = estimate.inlier_mask(estimate.features)
    arcs = sum(arc.share_of(explained) for arc in estimate.arcs)
    misses = sum(missed(estimate.measurements, each.ping_scores, each.extent) for each in estimate.features)
    ratio = estimate.settings.min_inlier_ratio
    return math.log(ratio / (1.0 - ratio)) * (arcs + misses / STRONGEST_MISS)


def _segments(
    parts: Sequence[Sequence[_Track]], sweeps: IntArray, *, origin: FloatArray
) -> tuple[TrajectorySegment, ...]:
    """Return the possible first poses of each part of a recording, of which ``sweeps`` are the first sweeps.

    ``origin`` is that of the frame of the tracks in the frame of the map, with yaw 0, shape (3,) [m, m, rad].
    """
    return tuple(
        TrajectorySegment(
            first=first,
            starts=tuple(StartPose(pose=each.poses[0] + origin, weight=each.weight) for each in tracks),
        )
        for tracks, first in zip(parts, sweeps.tolist(), strict=True)
    )
