"""Localisation in a known map: the poses of a recording, from a known or an unknown start.

Each station is registered to the landmarks of the map by scan matching: the first one everywhere in the map or near a
start, the others near the pose that odometry predicts. Of several possible starts each is followed until it is far less
likely than the best one. Where a station does not fit, the robot may be outside of the map, or it may have been carried
to any pose in it, which costs the logarithm of their number: both are followed, and what comes later decides. The poses
of the tracks that remain are optimised, with the map as their prior, and compared by what the map explains and what it
should have returned. The estimator then goes on from the likeliest one.
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
from echoplan.geometry import compose, invert, wrap
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.known_map import known_landmarks, prior_of_map
from echoplan.joint.likelihood.hypothesis_scores import STRONGEST_MISS, missed
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.optimisation.odometry_noise import VERY_STRONG
from echoplan.joint.optimisation.pose_factors import PosePrior, at_poses, dead_reckoned, odometry_prior
from echoplan.joint.pose_correction.consistency import explained_arcs, inlier_ratio, jaccard_index
from echoplan.joint.pose_correction.pose_tracking import local_scans_of
from echoplan.joint.search.global_search import SAME_PLACE, SAME_POSE, apart, find_poses, pose_grid
from echoplan.joint.search.scan_matching import LandmarkMap, LocalScan, best_score, locate
from echoplan.joint.settings import EstimateSettings
from echoplan.joint.trajectory import joined
from echoplan.model import FeatureMap, Localisation, Rig, StartPose, Sweep, TrajectorySegment, translated
from echoplan.preprocessing.measurements import join_measurements, measurements_of, rearranged_stations
from echoplan.preprocessing.stations import Stations, at_stations, group_sweeps, without_repeats

__all__ = ["localise"]

# Standard deviations of a start that the user gives [m, m, rad].
_START_SIGMAS = np.array([0.1, 0.1, math.radians(10.0)])
# Log odds below those of the best track at which a track is given up [nats].
_MAX_LOSS = 30.0
# Number of tracks that are followed.
_MAX_TRACKS = 120
# Number of tracks that are optimised, some tenths of a second each, and greatest number of iterations.
_MAX_OPTIMISED, _ROUNDS = 20, 3
# Optimisation begins with this multiple of the noise of the readings, as scan matching errs by centimetres.
_COARSE = 4.0
# Share of a perfect score that echoes of another place may reach by chance: a station that has less may be outside of
# the map.
_MIN_FIT = 0.25


def localise(
    sweeps: Sequence[Sweep],
    feature_map: FeatureMap,
    *,
    rig: Rig,
    start: FloatArray | None = None,
    carried_until: float = math.inf,
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
        About where the first sweep was made, right to 0.3 m and 30 degrees: x, y and yaw in the frame of the map [m, m,
        rad]. Anywhere by default.
    carried_until : float, optional
        Last station, counted from 0, before which the robot may have been carried elsewhere.  Every station by default.
    settings : JointSettings, optional
        Settings of the estimator.

    Returns
    -------
    Localisation
        The poses, the alternatives to the first one, and how far echoes and map agree.

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
    priors = odometry_prior(stations.poses, settings.pose_errors, estimate.odometry_noise)
    search = _Search(
        scans=local_scans_of(estimate),
        landmark_map=LandmarkMap.of(landmarks, np.zeros((0, 2))),
        grid=pose_grid(np.concatenate([*(wall.endpoints_xy for wall in feature_map.walls), feature_map.poses[:, :2]])),
        priors=priors._replace(sigmas=np.concatenate([[_START_SIGMAS], priors.sigmas[1:]])),
        settings=settings,
        start=None if start is None else start - origin,
        carried_until=carried_until,
    )
    followed = _followed(search)
    parts = list(map(partial(_weighed, search=search, estimate=estimate, feature_map=feature_map, rig=rig), followed))
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
    located = located.rescore(located.noise)
    return Localisation(
        sweeps=found.sweeps,
        poses=found.poses + origin,
        covariances=found.covariances,
        segments=_segments(parts, found.sweeps[of_parts], origin=origin),
        inlier_ratio=inlier_ratio(located),
        jaccard_index=jaccard_index(located),
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
    """Poses of the stations from ``first`` on, and how well they fit.

    Attributes
    ----------
    first : int
        Number of its first station.
    poses : ndarray, shape (k, 3)
        Poses [m, m, rad].
    scores : ndarray, shape (k,)
        Scores of the stations; 0 outside of the map [nats].
    before : tuple of _Track
        Tracks up to the station before, the best first, if the robot was carried elsewhere; else none.
    gain : float
        Log odds of what comes before the first station, less what chance adds to the scores [nats]: what a robot
        detects outside of the map fits somewhere in it, too, so only more than that speaks for a pose.
    weight : float
        Probability among the tracks from the same station on.
    """

    first: int
    poses: FloatArray
    scores: FloatArray
    before: "tuple[_Track, ...]" = ()
    gain: float = 0.0
    weight: float = 1.0

    @property
    def total(self) -> float:
        """Log odds of all stations [nats]."""
        return float(self.scores.sum()) + self.gain


@dataclass(frozen=True, kw_only=True)
class _Search:
    """What poses are searched with: scans of the stations, map, grid of poses and prior of odometry."""

    scans: Sequence[LocalScan]
    landmark_map: LandmarkMap
    grid: FloatArray
    priors: PosePrior
    settings: EstimateSettings
    # About where the recording begins, shape (3,) [m, m, rad]; anywhere if it is None.
    start: FloatArray | None
    # Last station before which the robot may have been carried elsewhere.
    carried_until: float

    @cached_property
    def chance(self) -> FloatArray:
        """Scores that echoes of another place may reach by chance, shape (s,) [nats]."""
        return _MIN_FIT * np.array([best_score(each, self.settings.localisation) for each in self.scans])

    def log_prior(self, first_pose: FloatArray) -> float:
        """Return the log density of the first pose by the start, less its greatest value [nats]."""
        if self.start is None:
            return 0.0
        off = first_pose - self.start
        return -0.5 * float(np.sum((np.append(off[:2], wrap(off[2])) / _START_SIGMAS) ** 2))

    def at_start(self) -> list[_Track]:
        """Return the poses at which the first station fits: anywhere, or near the start, where it may not fit, too."""
        if self.start is None:
            return self._fitting(0, self.grid)
        grid = pose_grid(self.start[:2] + 3.0 * np.outer([-1.0, 1.0], _START_SIGMAS[:2]))
        grid = grid[np.abs(wrap(grid[:, 2] - self.start[2])) <= 3.0 * _START_SIGMAS[2]]
        tracks = [each._replace(gain=each.gain + self.log_prior(each.poses[0])) for each in self._fitting(0, grid)]
        return [*tracks, _Track(0, self.start[None], np.zeros(1))]

    def _fitting(self, station: int, grid: FloatArray) -> list[_Track]:
        """Return the poses near those of a grid at which a station fits, the best first; there may be none."""
        poses, scores = find_poses(
            self.scans[station], self.landmark_map, grid=grid, settings=self.settings.localisation
        )
        gain = -float(self.chance[station])
        return [_Track(station, pose[None], score[None], gain=gain) for pose, score in zip(poses, scores, strict=True)]

    def elsewhere(self, tracks: Sequence[_Track], station: int) -> list[_Track]:
        """Return the tracks of a robot that was carried anywhere before a station; ``tracks`` lead to there.

        Any pose of the grid may be the next one, which costs the logarithm of their number.
        """
        if station > self.carried_until:
            return []
        found, before = self._fitting(station, self.grid), tuple(tracks)
        price = math.log(max(len(self.grid), 1)) + VERY_STRONG
        return [each._replace(before=before, gain=each.gain + before[0].total - price) for each in found]

    def continued(self, tracks: Sequence[_Track], station: int) -> list[_Track]:
        """Register the next station on all tracks, at least one, and give up those far worse than the best one."""
        return _best([after for each in tracks for after in self._continued(each, station)])

    def _continued(self, track: _Track, station: int) -> Iterator[_Track]:
        """Register the next station where odometry leads from the last one that fits; it may also be outside.

        The farther it may be from there, the less probable is each place.
        """
        poses = np.concatenate([np.zeros((track.first, 3)), track.poses])
        guess, near = dead_reckoned(self.priors.measured_poses, poses, station), self.priors.reaches[station]
        reach, chance = self._reach_of_odometry(track, station), float(self.chance[station])
        pose, score = locate(self.scans[station], self.landmark_map, guess, 1.3 * reach, self.settings.localisation)
        score -= float(np.log(reach / near).sum())
        extended, scores = self._extended(track, pose), np.append(track.scores, score)
        yield track._replace(poses=extended, scores=scores, gain=track.gain - chance)
        if score < chance:
            yield track._replace(poses=np.append(track.poses, [guess], axis=0), scores=np.append(track.scores, 0.0))

    def _extended(self, track: _Track, pose: FloatArray) -> FloatArray:
        """Return the poses of a track and of the next station.

        If no station fitted before, the poses of all of them follow from this one by odometry.
        """
        if track.scores.any():
            return np.append(track.poses, [pose], axis=0)
        measured = self.priors.measured_poses[track.first : track.first + len(track.poses) + 1]
        return compose(pose, compose(invert(measured[-1]), measured))

    def _reach_of_odometry(self, track: _Track, station: int) -> FloatArray:
        """Return the standard deviations of odometry since the last station that fits [m, m, rad].

        If none fits, they are those since the start, and contain those of the start.
        """
        after = track.first + 1 + int(np.flatnonzero(track.scores).max(initial=-1))
        reach: FloatArray = np.sqrt((self.priors.reaches[after : station + 1] ** 2).sum(axis=0))
        way = np.diff(self.priors.measured_poses[after : station + 1, :2], axis=0)
        reach[:2] += np.hypot(*way.T).sum() * reach[2]
        return reach


def _best(tracks: Sequence[_Track]) -> list[_Track]:
    """Return the tracks that are not far worse than the best one and lead to different poses, the best first.

    A track in the map and one outside of it differ at the same pose: odometry may be off by more in the second one.
    """
    inside = [each for each in tracks if each.scores[-1] > 0.0]
    outside = [each for each in tracks if each.scores[-1] <= 0.0]
    kept = [*_apart(inside, most=_MAX_TRACKS), *_apart(outside, most=_MAX_TRACKS)]
    ranked = sorted(kept, key=lambda each: each.total, reverse=True)
    return [each for each in ranked if each.total >= ranked[0].total - _MAX_LOSS]


def _apart(tracks: Sequence[_Track], *, most: int, same: tuple[float, float] = SAME_POSE) -> list[_Track]:
    """Return the best tracks that lead to different poses, the best first."""
    ends = np.array([each.poses[-1] for each in tracks]).reshape(-1, 3)
    totals = np.array([each.total for each in tracks])
    return [tracks[each] for each in apart(ends, totals, most=most, same=same)]


def _begun(search: _Search) -> list[_Track]:
    """Return the poses at which the first station fits, the best first; raise ``InvalidValueError`` if it does not."""
    if search.start is None and not len(search.grid):
        raise InvalidValueError("the map is too large to be searched everywhere: a start is needed")
    tracks = search.at_start()
    if not tracks:
        raise InvalidValueError("the echoes fit the map nowhere")
    if search.start is None:
        return tracks
    not_yet = _Track(0, np.zeros((0, 3)), np.zeros(0))
    return _best([*tracks, *search.elsewhere([not_yet], 0)])


def _followed(search: _Search) -> list[list[_Track]]:
    """Return the tracks of each part of the recording that odometry connects, the best first.

    Raise ``InvalidValueError`` if the recording does not begin at the start.
    """
    tracks = _begun(search)
    for station in range(1, len(search.scans)):
        before, tracks = tracks, search.continued(tracks, station)
        if all(each.before and each.first == 0 for each in tracks):
            break
        if tracks[0].scores[-1] < search.chance[station]:
            tracks = _best([*tracks, *search.elsewhere(before, station)])
    parts = _parts(tracks)
    if len(parts) > 1 and parts[1][0].first == 0:
        raise InvalidValueError("the recording does not begin there, but elsewhere in the map")
    return parts


def _parts(tracks: Sequence[_Track]) -> list[list[_Track]]:
    """Return the tracks of each part; those of the last part begin at the same station as the best one."""
    part = [each for each in tracks if each.before is tracks[0].before]
    return [*_parts(part[0].before), part] if part[0].before else [part]


def _weighed(
    tracks: Sequence[_Track], *, search: _Search, estimate: Estimate, feature_map: FeatureMap, rig: Rig
) -> list[_Track]:
    """Return the best track of each place with its weight at optimised poses, the likeliest first."""
    tracks = _apart(tracks, most=_MAX_OPTIMISED, same=SAME_PLACE)
    if len(tracks) == 1:
        return tracks
    optimised = [_optimised(each, estimate, feature_map=feature_map, rig=rig) for each in tracks]
    # Several of them may end at one place.
    ends, log_odds = np.array([each.poses[-1] for each in optimised]), np.array(list(map(_log_odds, optimised)))
    if tracks[0].first == 0:
        log_odds += [search.log_prior(each.poses[0]) for each in optimised]
    kept = apart(ends, log_odds, most=_MAX_OPTIMISED, same=SAME_PLACE)
    return [
        tracks[each]._replace(poses=optimised[each].poses, weight=float(weight))
        for each, weight in zip(kept, softmax(log_odds[kept]), strict=True)
    ]


def _optimised(track: _Track, estimate: Estimate, *, feature_map: FeatureMap, rig: Rig) -> Estimate:
    """Return the estimate of the stations of a track, from its poses on."""
    first, last = track.first, track.first + len(track.poses)
    recorded, measured = rearranged_stations(estimate.recorded, range(first, last)), estimate.measured_poses[first:last]
    prior = prior_of_map(feature_map, track.poses[0], noise=estimate.first_noise)
    initial = initial_estimate(rig, recorded, measured, estimate.settings, prior)
    now = replace(initial, poses=track.poses, measurements=at_poses(recorded, measured, track.poses))
    for noise in (_COARSE * initial.noise, initial.noise):
        now = now.rescore(noise).alternate(noise, initial.odometry(), _ROUNDS)
    return now


def _log_odds(estimate: Estimate) -> float:
    """Return the log odds of poses in a known map [nats].

    Readings of an arc share the errors of the map and of the sonar model, so it counts as one reading, with the odds
    that the right map explains it; and a landmark that a station misses entirely as an arc that it does not explain.
    """
    misses = sum(missed(estimate.measurements, each.ping_scores, each.extent) for each in estimate.features)
    ratio = estimate.settings.min_inlier_ratio
    return math.log(ratio / (1.0 - ratio)) * (explained_arcs(estimate) + misses / STRONGEST_MISS)


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
