"""Consistency: share of the echoes that a model of one room explains from the given poses."""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy.special import betainc
from threadpoolctl import threadpool_limits

from echoplan.arrays import FloatArray, IntArray
from echoplan.joint.estimate import Estimate
from echoplan.joint.initial_estimate import initial_estimate
from echoplan.joint.pose_correction.consistency import log_evidence
from echoplan.joint.search.duplicates import without_duplicates
from echoplan.joint.settings import EstimateSettings, PoseMode
from echoplan.model import Rig, Sweep
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.preprocessing.servo import ServoError
from echoplan.preprocessing.stations import Stations, at_stations, group_sweeps

__all__ = [
    "CONSISTENT",
    "FEW_STATIONS",
    "Consistency",
    "consistency",
    "estimate_of",
    "gathered",
    "sampled",
    "stations_of",
    "windows",
]

# Number of stations, and of pings per station and sensor, that suffice to detect wrong conventions. Mapping such a
# sample takes a third of a second.
FEW_STATIONS, _PINGS = 10, 100
# Chance that a sensor of which half the share of the others is explained is called odd, over all sensors of a rig.
_CHANCE = 0.01


class Consistency(NamedTuple):
    """How well one room explains a recording.

    Attributes
    ----------
    explained : ndarray of int, shape (s,)
        Explained echoes of each sensor of the rig.
    grouped : ndarray of int, shape (s,)
        Echoes of each sensor that belong to arcs, without stray ones.
    gain : float
        Log evidence of the room [nats].
    weights : ndarray, shape (s, 2)
        Number of independent echoes of each sensor among the explained ones, and among those that belong to arcs.
    """

    explained: IntArray
    grouped: IntArray
    gain: float
    weights: FloatArray

    @property
    def weight(self) -> float:
        """Number of independent echoes among the explained ones."""
        return float(self.weights[:, 0].sum())

    @property
    def share(self) -> float:
        """Explained share of the echoes that belong to arcs; 0 without any."""
        return float(self.explained.sum()) / max(int(self.grouped.sum()), 1)

    def of_sensor(self, sensor: int) -> "Consistency":
        """Return the consistency of the echoes of one sensor, given by its index."""
        one = slice(sensor, sensor + 1)
        return self._replace(explained=self.explained[one], grouped=self.grouped[one], weights=self.weights[one])

    @property
    def strangest(self) -> int:
        """Index of the sensor of whose echoes the smallest share is explained."""
        return int(np.argmin((self.explained + 1) / (self.grouped + 1)))

    @property
    def has_unexplained_sensor(self) -> bool:
        """Whether most echoes of the strangest sensor are unexplained: only then more could be explained otherwise."""
        return self.of_sensor(self.strangest).share < 0.5

    @property
    def has_odd_sensor(self) -> bool:
        """Whether the share of explained echoes of the strangest sensor is less than half that of the others.

        The test is binomial, on independent echoes.
        """
        explained, grouped = self.weights[self.strangest]
        others, of_others = self.weights.sum(axis=0) - self.weights[self.strangest]
        half = 0.5 * others / max(of_others, 1.0)
        if not explained < half * grouped:
            return False
        return bool(betainc(grouped - explained, explained + 1.0, 1.0 - half) < _CHANCE / len(self.weights))


# Stands for rigs whose sensors are not compared.
CONSISTENT = Consistency(np.ones(1, dtype=np.int64), np.ones(1, dtype=np.int64), 0.0, np.ones((1, 2)))


def sampled(sweeps: Sequence[Sweep], rig: Rig, *, stations: int = FEW_STATIONS) -> list[Sweep]:
    """Return the sweeps of some stations, with every k-th firing of fine scans.

    The stations are spread evenly over the first window, since a robot may drift or leave the room later. Positions are
    relative to the first one, since rounding would spoil large coordinates.
    """
    sweeps = [sweep for sweep in sweeps if len(sweep)]
    if not sweeps:
        return []
    numbers = stations_of(sweeps).numbers
    last = min(int(numbers[-1]), EstimateSettings().window.stations - 1)
    chosen = np.unique(np.linspace(0, last, stations).astype(np.int64))
    origin = np.append(np.round(sweeps[0].station[:2]), 0.0)
    kept = []
    for sweep, number in zip(sweeps, numbers, strict=True):
        if number in chosen:
            stride = len(sweep) // (_PINGS * len(rig.sensors)) + 1
            firings = np.unique(sweep.stamps_ns, return_inverse=True)[1]
            thinned = sweep[firings % stride == 0]
            kept.append(replace(thinned, map_from_base=thinned.map_from_base - origin))
    return kept


def windows(sweeps: Sequence[Sweep], *, most: int) -> list[list[Sweep]]:
    """Split sweeps into windows as `joint` does; of many windows return at most ``most``, spread evenly."""
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
    """Group sweeps into stations by their recorded poses, as `joint` does."""
    poses = np.array([sweep.station for sweep in sweeps]).reshape(-1, 3)
    return group_sweeps(poses, np.array([len(sweep) for sweep in sweeps]), EstimateSettings().stations)


def gathered(sweeps: Sequence[Sweep], rig: Rig) -> Estimate | None:
    """Return the initial estimate from the recorded poses; None without any reading."""
    parts = [measurements_of(sweep, rig) for sweep in sweeps]
    if not any(np.isfinite(part.readings).any() for part in parts):
        return None
    stations = stations_of(sweeps)
    detected = at_stations(join_measurements(parts), stations)
    return initial_estimate(rig, detected, stations.poses, EstimateSettings(poses=PoseMode.TRUST))


def estimate_of(sweeps: Sequence[Sweep], rig: Rig, *, servo: ServoError | None = None) -> Estimate | None:
    """Return the estimate from the recorded poses; None without any reading.

    With a servo error, gain and offset of the servo are calibrated from there.
    """
    estimate = gathered(sweeps, rig)
    if estimate is None:
        return None
    # On matrices this small, threads cost more than they save.
    with threadpool_limits(limits=1, user_api="blas"):
        if servo is not None:
            estimate = estimate.calibrate(servo)
        return estimate.explain()


def consistency(sweeps: Sequence[Sweep], rig: Rig) -> Consistency:
    """Count the echoes that one room explains from the recorded poses."""
    estimate, count = estimate_of(sweeps, rig), len(rig.sensors)
    if estimate is None or not estimate.arcs:
        none = np.zeros(count, dtype=np.int64)
        return Consistency(none, none, 0.0, np.zeros((count, 2)))
    pings = np.concatenate([arc.pings for arc in estimate.arcs])
    features = without_duplicates(estimate.features, estimate.settings.duplicates)
    sensors, hits = estimate.measurements.sensors[pings], estimate.inlier_mask(features)[pings]
    weights = estimate.measurements.weights[pings]
    return Consistency(
        explained=np.bincount(sensors[hits], minlength=count),
        grouped=np.bincount(sensors, minlength=count),
        gain=log_evidence(estimate),
        weights=np.stack(
            [
                np.bincount(sensors[hits], weights=weights[hits], minlength=count),
                np.bincount(sensors, weights=weights, minlength=count),
            ],
            axis=1,
        ),
    )
