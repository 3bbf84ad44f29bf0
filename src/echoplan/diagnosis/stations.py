"""Stations that do not fit the others: one that was set down elsewhere, or turned otherwise, than was written."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.diagnosis.consistency import estimate_of, sampled, stations_of, windows
from echoplan.geometry import compose, invert
from echoplan.joint.estimate import Estimate
from echoplan.joint.pose_correction.consistency import log_evidence
from echoplan.joint.search.scan_matching import LandmarkMap, local_scans, locate
from echoplan.joint.settings import EstimateSettings
from echoplan.model import Rig, Sweep

__all__ = ["Misplaced", "carried", "misplaced_stations"]

# How far a person is off who made a mistake [m, m, rad], and how exactly a place is held that is not questioned.
_SLIP, _HELD = np.array([0.15, 0.15, math.radians(20.0)]), 1e-3
# A feature is known that so many other stations detect.  A pose is tried that fits the arcs of a station so much better
# to what is known [nats] and is so far away [m, rad], and accepted if the log evidence rises by so much [nats]:
# on seeds 1000 on of benchmarks/verdicts.py.
_OTHERS, _TRIED, _ACCEPTED = 2, 0.8, 30.0
_FAR, _TURNED = 0.06, math.radians(6.0)
# More than so many stations are not misplaced one by one.
_MOST = 3
# Windows of a long recording that are checked: each takes as long as mapping it.
_WINDOWS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Misplaced:
    """A station that fits the others from another pose.

    Parameters
    ----------
    sweep : int
        Number of its first sweep.
    distance : float
        How far that pose is from the recorded one [m].
    turn : float
        How far it is turned, counter-clockwise [rad].
    gain : float
        Log evidence for the other pose [nats].
    """

    sweep: int
    distance: float
    turn: float
    gain: float


def misplaced_stations(sweeps: Sequence[Sweep], rig: Rig) -> tuple[Misplaced, ...]:
    """Find the stations that fit their neighbours better at another pose, the worst first.

    Parameters
    ----------
    sweeps : sequence of Sweep
        With their poses in the map.
    rig : Rig
        That recorded them.

    Returns
    -------
    tuple of Misplaced
        Stations with the pose at which they fit better.
    """
    found = [each for window in windows(sweeps, most=_WINDOWS) for each in _misplaced(window, rig)]
    return tuple(sorted(found, key=lambda each: -each.gain)[:_MOST])


def _misplaced(window: Sequence[Sweep], rig: Rig) -> Iterator[Misplaced]:
    """Yield those of one window."""
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
    """Carry a sweep along when its station is moved from one pose to another."""
    return replace(sweep, map_from_base=compose(moved, compose(invert(measured), sweep.map_from_base)))


def _trials(estimate: Estimate) -> Iterator[tuple[int, FloatArray, float]]:
    """Yield stations, poses from which they fit far better to what others know, and how much."""
    for station, measured in enumerate(estimate.measured_poses):
        moved, gain = _elsewhere(estimate, station)
        off = compose(invert(measured), moved)
        if gain > _TRIED and (np.hypot(off[0], off[1]) > _FAR or abs(off[2]) > _TURNED):
            yield station, moved, gain


def _elsewhere(estimate: Estimate, station: int) -> tuple[FloatArray, float]:
    """Find the pose from which a station fits best to what the others know, and how much better it does."""
    least, settings = estimate.settings.search.second_station, estimate.settings.localisation
    known = [
        each
        for each in estimate.features
        if each.supporting(least) - int(each.llr_by_station[station] > least) >= _OTHERS
    ]
    arcs = [arc for arc in estimate.arcs if arc.station == station]
    sight = local_scans(arcs, estimate.recorded, estimate.model.tabulated(), estimate.measured_poses[station])
    landmark_map, here = LandmarkMap.of(known), estimate.measured_poses[station]
    _, now = locate(sight, landmark_map, here, _HELD * _SLIP, settings)
    moved, then = locate(sight, landmark_map, here, _SLIP, settings)
    return moved, then - now
