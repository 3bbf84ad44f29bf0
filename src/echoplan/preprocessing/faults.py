"""Faults of readings and of recordings: found before anything is mapped, and kept out of the map."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.model import Pings, Rig, Sensor, Sweep
from echoplan.preprocessing.constancy import Trace, is_value, runs_of
from echoplan.preprocessing.recording_faults import (
    RecordingFault,
    RecordingFaultKind,
    find_beam_faults,
    find_place_faults,
)
from echoplan.preprocessing.sensor_faults import SensorFault, SensorFaultKind, find_sensor_faults

__all__ = ["Faults", "clean_sweeps", "find_faults"]

# The step of readings is no finer than this [m], whatever a rig says.
_FINEST = 0.001
# Half of the angle over which modules detect a near wall, whatever a rig says: data sheets name a third of it [rad].
_BROADEST = math.radians(30.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Faults:
    """What is wrong with a recording.

    Parameters
    ----------
    sensors : tuple of SensorFault, optional
        Faults of sensors, in the order of the rig.
    recording : tuple of RecordingFault, optional
        Faults of the recording as a whole.
    """

    sensors: tuple[SensorFault, ...] = ()
    recording: tuple[RecordingFault, ...] = ()

    @property
    def has_no_poses(self) -> bool:
        """Whether the robot moved but its places were not recorded."""
        return any(fault.kind == RecordingFaultKind.NO_POSES for fault in self.recording)

    @property
    def is_from_one_place(self) -> bool:
        """Whether all readings are from one place, or the places were not recorded."""
        return self.has_no_poses or any(fault.kind == RecordingFaultKind.ONE_PLACE for fault in self.recording)

    def has_no_echoes(self, rig: Rig) -> bool:
        """Return True if no sensor of a rig has an echo: then that is what there is to map."""
        return [fault.kind for fault in self.sensors] == [SensorFaultKind.DEAD] * len(rig.sensors)


def find_faults(sweeps: Sequence[Sweep], rig: Rig) -> Faults:
    """Find faults of the readings of a recording, sensor by sensor, and of the recording as a whole.

    Parameters
    ----------
    sweeps : sequence of Sweep
        All sweeps, in the order of time.
    rig : Rig
        What made them.

    Returns
    -------
    Faults
        None of a sound recording.

    Examples
    --------
    >>> from echoplan.sources import open_source
    >>> room = open_source("sim:paper-room")
    >>> find_faults(tuple(room), room.rig)
    Faults(sensors=(), recording=())
    """
    recorded = [sweep for sweep in sweeps if len(sweep)]
    if not recorded:
        return Faults()
    traces = _traces(recorded, rig)
    sensors = find_sensor_faults(traces, recorded, rig)
    beam = find_beam_faults(clean_sweeps(recorded, rig, Faults(sensors=sensors)), rig)
    # A narrow beam shows where each reading belongs, from any place.
    return Faults(sensors=sensors, recording=beam or find_place_faults(recorded, traces))


def _traces(sweeps: Sequence[Sweep], rig: Rig) -> list[Trace]:
    """Sort the pings of sweeps by sensor."""
    placed = [Pings.from_sweep(sweep, rig) for sweep in sweeps]
    sensors = np.concatenate([pings.sensors for pings in placed])
    origins_xy = np.concatenate([pings.origins_xy for pings in placed])
    bearings = np.concatenate([pings.bearings for pings in placed])
    readings = np.concatenate([pings.ranges for pings in placed])
    ends = np.cumsum(np.bincount(sensors, minlength=len(rig.sensors)))
    parts = np.split(np.argsort(sensors, kind="stable"), ends[:-1])
    return [
        Trace(
            x=origins_xy[own, 0],
            y=origins_xy[own, 1],
            bearings=bearings[own],
            readings=readings[own],
            half_aperture=max(_BROADEST, sensor.half_aperture),
            step=_step_of(readings[own], sensor),
        )
        for own, sensor in zip(parts, rig.sensors, strict=True)
    ]


def _step_of(readings: FloatArray, sensor: Sensor) -> float:
    """Return the step of readings [m]: that of the rig, or a coarser one that the readings themselves show."""
    gaps = np.diff(np.unique(readings[np.isfinite(readings)]))
    return max(_FINEST, sensor.resolution, float(np.quantile(gaps, 0.1)) if len(gaps) else 0.0)


def clean_sweeps(sweeps: Sequence[Sweep], rig: Rig, faults: Faults) -> tuple[Sweep, ...]:
    """Take out of sweeps what faults of their sensors put there.

    A value that stands for no echo becomes ``inf``.  Readings that were held or logged again, that stand for anything
    too close, that belong to other angles, and all those of dead and stuck sensors become ``nan``: they say nothing.

    Parameters
    ----------
    sweeps : sequence of Sweep
        All sweeps, as they were recorded.
    rig : Rig
        What made them.
    faults : Faults
        What ``find_faults`` found in them.

    Returns
    -------
    tuple of Sweep
        As many sweeps with as many pings; the same objects if no sensor has a fault.
    """
    if not faults.sensors or faults.has_no_echoes(rig):
        return tuple(sweeps)
    sizes = [len(sweep) for sweep in sweeps]
    sensor_ids = np.concatenate([sweep.sensor_ids for sweep in sweeps])
    ranges = np.concatenate([sweep.ranges for sweep in sweeps])
    numbers = np.repeat(np.arange(len(sweeps)), sizes)
    traces = dict(zip(rig.sensor_ids.tolist(), _traces(sweeps, rig), strict=True))
    for fault in faults.sensors:
        own = sensor_ids == fault.sensor_id
        trace = traces[fault.sensor_id]._replace(readings=ranges[own])
        ranges[own] = _cleaned(trace, numbers[own], fault)
    parts = np.split(ranges, np.cumsum(sizes)[:-1])
    return tuple(replace(sweep, ranges=part) for sweep, part in zip(sweeps, parts, strict=True))


def _cleaned(trace: Trace, sweeps: IntArray, fault: SensorFault) -> FloatArray:
    """Return the readings of a sensor, of these sweeps, without one of its faults."""
    if fault.kind in (SensorFaultKind.DEAD, SensorFaultKind.STUCK):
        return np.full(len(trace.readings), np.nan)
    if fault.kind in (SensorFaultKind.HELD, SensorFaultKind.LOGGED_REPEATEDLY):
        repeats = np.diff(runs_of(trace.readings), prepend=-1) == 0
        return np.where(repeats & np.isfinite(trace.readings), np.nan, trace.readings)
    if fault.kind == SensorFaultKind.FLYBACK:
        firsts = np.searchsorted(sweeps, sweeps, side="left")
        return np.where(np.arange(len(sweeps)) - firsts < fault.value, np.nan, trace.readings)
    instead = np.inf if fault.kind == SensorFaultKind.NO_ECHO_VALUE else np.nan
    return np.where(is_value(trace, fault.value), instead, trace.readings)
