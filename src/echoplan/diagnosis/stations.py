"""Stations that are inconsistent with the others: the recorded pose of the robot is wrong there."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.diagnosis.consistency import estimate_of, sampled, stations_of, windows
from echoplan.geometry import compose, invert
from echoplan.joint.estimate import Estimate
from echoplan.joint.pose_correction.consistency import log_evidence
from echoplan.joint.pose_correction.pose_tracking import local_scan_of
from echoplan.joint.search.scan_matching import LandmarkMap, locate
from echoplan.joint.settings import EstimateSettings
from echoplan.model import Rig, Sweep

__all__ = ["Misplaced", "carried", "misplaced_stations"]

# Standard deviations of a pose recorded by mistake [m, m, rad], and the factor by which they shrink to keep a pose.
_SLIP, _HELD = np.array([0.15, 0.15, math.radians(20.0)]), 1e-3
# Number of other stations that must detect a landmark; gain of the scan matching score above which a pose is tried
# [nats], if it differs enough from the recorded one [m, rad]; log evidence above which it is accepted [nats]. Chosen on
# seeds from 1000 of benchmarks/verdicts.py.
_OTHERS, _TRIED, _ACCEPTED = 2, 0.8, 30.0
_FAR, _TURNED = 0.06, math.radians(6.0)
# Most stations to report: if more are inconsistent, the cause is another one.
_MOST = 3
# Number of windows of a long recording that are checked: each takes as long as mapping it.
_WINDOWS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Misplaced:
    """A station that fits the others at another pose.

    Parameters
    ----------
    sweep : int
        Number of its first sweep.
    distance : float
        Distance of that pose from the recorded one [m].
    turn : float
        Rotation from the recorded to that pose, counter-clockwise [rad].
    gain : float
        Log evidence for that pose against the recorded one [nats].
    """

    sweep: int
    distance: float
    turn: float
    gain: float


def misplaced_stations(sweeps: Sequence[Sweep], rig: Rig) -> tuple[Misplaced, ...]:
    """Find the stations that fit the others better at another pose, the worst first.

    Parameters
    ----------
    sweeps : sequence of Sweep
        Sweeps with their poses in the map.
    rig : Rig
        Sensors that recorded them.

    Returns
    -------
    tuple of Misplaced
        At most three stations, with the pose at which they fit better.
    """
    found = [each for window in windows(sweeps, most=_WINDOWS) for each in _misplaced(window, rig)]
    return tuple(sorted(found, key=lambda each: -each.gain)[:_MOST])


def _misplaced(window: Sequence[Sweep], rig: Rig) -> Iterator[Misplaced]:
    """Yield the misplaced stations of one window."""
    some = sampled(window, rig, stations=EstimateSettings().window.stations)
    estimate = estimate_of(some, rig)
    if estimate is None:
        return
    trials = sorted(_trials(estimate), key=lambda trial: -trial[2])[:_MOST]
    numbers = stations_of(some).numbers
    for station, moved, _ in trials:
        measured = estimate.measured_poses[station]
        there = [
            carried(sweep, measured, moved) if number == station else sweep
            for sweep, number in zip(some, numbers, strict=True)
        ]
        after = estimate_of(there, rig)
        gain = log_evidence(after) - log_evidence(estimate) if after is not None else 0.0
        if gain > _ACCEPTED:
            off, first = compose(invert(measured), moved), some[int(np.argmax(numbers == station))]
            distance = float(np.hypot(off[0], off[1]))
            yield Misplaced(sweep=first.index, distance=distance, turn=float(off[2]), gain=gain)


def carried(sweep: Sweep, measured: FloatArray, moved: FloatArray) -> Sweep:
    """Return a sweep that moves rigidly with its station from one pose to another."""
    return replace(sweep, map_from_base=compose(moved, compose(invert(measured), sweep.map_from_base)))


def _trials(estimate: Estimate) -> Iterator[tuple[int, FloatArray, float]]:
    """Yield stations with a distant pose that fits the landmarks of the others better, and the gain in score [nats]."""
    for station, measured in enumerate(estimate.measured_poses):
        moved, gain = _elsewhere(estimate, station)
        off = compose(invert(measured), moved)
        if gain > _TRIED and (np.hypot(off[0], off[1]) > _FAR or abs(off[2]) > _TURNED):
            yield station, moved, gain


def _elsewhere(estimate: Estimate, station: int) -> tuple[FloatArray, float]:
    """Return the pose at which a station fits the landmarks of the others best, and the gain in score [nats]."""
    least, settings = estimate.settings.search.min_second_station_llr, estimate.settings.localisation
    known = [
        each
        for each in estimate.features
        if each.supporting(least) - int(each.llr_by_station[station] > least) >= _OTHERS
    ]
    scan = local_scan_of(estimate, station)
    landmark_map, here = LandmarkMap.of(known, estimate.measurements.centers), estimate.measured_poses[station]
    _, now = locate(scan, landmark_map, here, _HELD * _SLIP, settings)
    moved, then = locate(scan, landmark_map, here, _SLIP, settings)
    return moved, then - now
