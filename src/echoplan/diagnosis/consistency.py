"""Consistency: how many of the echoes one room explains, if all poses are right."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from echoplan.arrays import IntArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.pose_correction.consistency import log_evidence
from echoplan.joint.search.duplicates import without_duplicates
from echoplan.joint.settings import EstimateSettings, PoseMode
from echoplan.model import Rig, Sweep
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.preprocessing.servo import ServoError
from echoplan.preprocessing.stations import Stations, at_stations, group_sweeps

__all__ = ["FEW_STATIONS", "Consistency", "consistency", "estimate_of", "gathered", "sampled", "stations_of", "windows"]

# Stations, and pings of each, that separate a wrong convention from the right one: a small recording, explained in a
# third of a second.
FEW_STATIONS, _PINGS = 10, 100


class Consistency(NamedTuple):
    """What one room explains of a recording.

    Attributes
    ----------
    explained : ndarray of int, shape (s,)
        Echoes of each sensor of the rig that it explains.
    grouped : ndarray of int, shape (s,)
        Echoes that neighbouring pings share: strays are not among them.
    gain : float
        Log evidence for the room [nats].
    weight : float
        Independent echoes among those that are explained.
    """

    explained: IntArray
    grouped: IntArray
    gain: float
    weight: float

    @property
    def share(self) -> float:
        """Explained share of the echoes that neighbouring pings share; 0 without any."""
        return float(self.explained.sum()) / max(int(self.grouped.sum()), 1)

    @property
    def strangest(self) -> int:
        """Index of the sensor of whose echoes the smallest share is explained."""
        return int(np.argmin((self.explained + 1) / (self.grouped + 1)))


def sampled(sweeps: Sequence[Sweep], rig: Rig, *, stations: int = FEW_STATIONS) -> list[Sweep]:
    """Choose the sweeps of so many stations, and of fine scans every k-th firing.

    Stations beyond those that joint explains together are left out: a robot may have drifted, or left the room.
    Positions are those from near the first one: those of a country are so large that rounding alone would spoil them.
    """
    sweeps = [sweep for sweep in sweeps if len(sweep)]
    if not sweeps:
        return []
    numbers = stations_of(sweeps).numbers
    last = min(int(numbers[-1]), EstimateSettings().window.stations - 1)
    chosen = np.unique(np.linspace(0, last, stations).astype(np.int64))
    origin = np.append(np.round(sweeps[0].station[:2]), 0.0)
    kept = [_thinned(sweep, rig) for sweep, number in zip(sweeps, numbers, strict=True) if number in chosen]
    return [replace(sweep, map_from_base=sweep.map_from_base - origin) for sweep in kept]


def windows(sweeps: Sequence[Sweep], *, most: int) -> list[list[Sweep]]:
    """Split sweeps into those of stations that joint explains together; of many windows keep some, spread evenly."""
    sweeps = [sweep for sweep in sweeps if len(sweep)]
    if not sweeps:
        return []
    numbers = stations_of(sweeps).numbers
    stations = np.arange(numbers[-1] + 1)
    parts = np.array_split(stations, math.ceil(len(stations) / EstimateSettings().window.stations))
    chosen = np.unique(np.linspace(0, len(parts) - 1, most).round().astype(np.int64))
    return [
        [sweep for sweep, number in zip(sweeps, numbers, strict=True) if number in parts[index]] for index in chosen
    ]


def stations_of(sweeps: Sequence[Sweep]) -> Stations:
    """Group sweeps as joint does, by their recorded poses."""
    poses = np.array([sweep.station for sweep in sweeps]).reshape(-1, 3)
    return group_sweeps(poses, np.array([len(sweep) for sweep in sweeps]), EstimateSettings().stations)


def _thinned(sweep: Sweep, rig: Rig) -> Sweep:
    stride = len(sweep) // (_PINGS * len(rig.sensors)) + 1
    firings = np.unique(sweep.stamps_ns, return_inverse=True)[1]
    return sweep[firings % stride == 0] if stride > 1 else sweep


def gathered(sweeps: Sequence[Sweep], rig: Rig) -> Estimate | None:
    """Gather what was detected, from the poses as recorded; None without any reading."""
    parts = [measurements_of(sweep, rig) for sweep in sweeps]
    if not any(np.isfinite(part.readings).any() for part in parts):
        return None
    stations = stations_of(sweeps)
    detected = at_stations(join_measurements(parts), stations)
    return initial_estimate(rig, detected, stations.poses, EstimateSettings(poses=PoseMode.TRUST))


def estimate_of(sweeps: Sequence[Sweep], rig: Rig, *, servo: ServoError | None = None) -> Estimate | None:
    """Explain sweeps from the poses as recorded, calibrating the servo from an error; None without any reading."""
    estimate = gathered(sweeps, rig)
    if estimate is None:
        return None
    # Matrices are small: threads would only wait for each other.
    with threadpool_limits(limits=1, user_api="blas"):
        if servo is not None:
            estimate = estimate.calibrate(servo)
        return estimate.explain()


def consistency(sweeps: Sequence[Sweep], rig: Rig) -> Consistency:
    """Count the echoes of some sweeps that one room explains from the poses as recorded."""
    estimate, count = estimate_of(sweeps, rig), len(rig.sensors)
    if estimate is None or not estimate.arcs:
        none = np.zeros(count, dtype=np.int64)
        return Consistency(none, none, 0.0, 0.0)
    pings = np.concatenate([arc.pings for arc in estimate.arcs])
    features = without_duplicates(estimate.features, estimate.settings.copies)
    sensors, hits = estimate.measurements.sensors[pings], estimate.inlier_mask(features)[pings]
    return Consistency(
        explained=np.bincount(sensors[hits], minlength=count),
        grouped=np.bincount(sensors, minlength=count),
        gain=log_evidence(estimate),
        weight=float(estimate.measurements.weights[pings[hits]].sum()),
    )
