"""Faults of single sensors: what their readings show that no world does."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from echoplan.arrays import BoolArray
from echoplan.model import Rig, Sensor, Sweep
from echoplan.preprocessing.constancy import (
    Trace,
    count_walls,
    excess_of_value,
    held_readings,
    is_logged_repeatedly,
    is_value,
    runs_of,
)
from echoplan.preprocessing.flyback import count_flyback_readings

__all__ = ["SensorFault", "SensorFaultKind", "find_sensor_faults"]

# Fewer pings do not show what is usual for a sensor.
_FEWEST = 30
# A sensor that has an echo in less than this share of what is usual for its rig is dead.
_DEAD_SHARE = 0.05
# A stuck sensor reads one value, to this width [m], in at least this share of its readings.
_STUCK_WIDTH, _STUCK_SHARE = 0.01, 0.95
# Chance that another wall is as far away as the first, as where a robot keeps its distance or stands in the middle of a
# room; and that not one of all readings of it differs by a step.
_SAME_DISTANCE, _SAME_STEP = 0.3, 0.15
# One sensor in a hundred is broken, and one in a hundred of those that are named may be sound [nats].
_EVIDENCE = 2 * math.log(100.0)
# What concerns less than this share of the readings harms no map; so many of the commonest values are examined.
_SHARE, _VALUES = 0.03, 3
# A value that stands for something is read in this share of the readings at least: in the middle of a simulated
# corridor 8 to 10 % of readings that are rounded to centimetres are the same.
_STANDING = 0.12
# So small a share of the readings may be nearer than the value that stands for all that is too close.
_NEARER = 0.01
# From so many places at least a reading that no echo has, where nothing else stands for no echo, stands for it.
_PLACES = 3


class SensorFaultKind(StrEnum):
    """What is wrong with a sensor."""

    DEAD = "dead"
    STUCK = "stuck"
    NO_ECHO_VALUE = "no-echo-value"
    BLIND_VALUE = "blind-value"
    FIXED_VALUE = "fixed-value"
    HELD = "held"
    LOGGED_REPEATEDLY = "logged-repeatedly"
    FLYBACK = "flyback"


# Of sensors with one of these it is settled whether they hold readings; others may do so besides.
_SETTLED = {
    SensorFaultKind.DEAD,
    SensorFaultKind.STUCK,
    SensorFaultKind.NO_ECHO_VALUE,
    SensorFaultKind.HELD,
    SensorFaultKind.LOGGED_REPEATEDLY,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorFault:
    """A fault of one sensor.

    Parameters
    ----------
    sensor_id : int
        The sensor.
    kind : SensorFaultKind
        What is wrong.
    value : float, optional
        The reading that it concerns [m]; of ``LOGGED_REPEATEDLY`` how many times each reading is logged, of ``FLYBACK``
        how many readings of a sweep; else nan.
    share : float, optional
        Share of the pings of the sensor that it concerns.
    """

    sensor_id: int
    kind: SensorFaultKind
    value: float = math.nan
    share: float = 1.0


def find_sensor_faults(traces: Sequence[Trace], sweeps: Sequence[Sweep], rig: Rig) -> tuple[SensorFault, ...]:
    """Find what is wrong with the sensors of a rig.

    Parameters
    ----------
    traces : sequence of Trace
        The pings of each sensor of the rig.
    sweeps : sequence of Sweep
        The same pings, sweep by sweep.
    rig : Rig
        What made them.

    Returns
    -------
    tuple of SensorFault
        In the order of the rig; none of sound sensors.
    """
    shares = [_share_of_echoes(trace) for trace in traces]
    fired = [share for trace, share in zip(traces, shares, strict=True) if len(trace.readings)]
    least = _DEAD_SHARE * float(np.median(fired)) if fired else 0.0
    found: list[SensorFault] = []
    for trace, sensor, share in zip(traces, rig.sensors, shares, strict=True):
        if len(trace.readings) < _FEWEST:
            continue
        if share <= least:
            found.append(SensorFault(sensor_id=sensor.sensor_id, kind=SensorFaultKind.DEAD))
        elif _is_stuck(trace):
            value = float(np.median(trace.readings[np.isfinite(trace.readings)]))
            found.append(SensorFault(sensor_id=sensor.sensor_id, kind=SensorFaultKind.STUCK, value=value))
        else:
            found += [*_constants(trace, sensor), *_flyback(sweeps, sensor)]
    return _with_mates(found, traces, rig)


def _share_of_echoes(trace: Trace) -> float:
    return float(np.isfinite(trace.readings).mean()) if len(trace.readings) else 0.0


def _is_stuck(trace: Trace) -> bool:
    """Return True if a sensor reads one value at places that no few walls explain."""
    finite = trace.only(np.isfinite(trace.readings))
    middle = np.median(finite.readings)
    near = np.abs(finite.readings - middle) <= _STUCK_WIDTH
    if len(near) < _FEWEST or near.mean() < _STUCK_SHARE:
        return False
    chance = _SAME_STEP if np.ptp(finite.readings) == 0.0 else _SAME_DISTANCE
    return (count_walls(finite.only(near)) - 1) * -math.log(chance) > _EVIDENCE


def _constants(trace: Trace, sensor: Sensor) -> Iterator[SensorFault]:
    """Yield the values that stand for no echo or for what is too close, and whether readings repeat."""
    has_no_echo = is_no_echo(trace, sensor)
    names_no_echo = bool(has_no_echo.mean() >= _SHARE)
    rest = trace._replace(readings=np.where(has_no_echo, np.nan, trace.readings))
    values, counts = np.unique(rest.readings[np.isfinite(rest.readings)], return_counts=True)
    commonest = np.argsort(-counts, kind="stable")[:_VALUES]
    for value in values[commonest][counts[commonest] >= _SHARE * len(rest.readings)].tolist():
        kind = _kind_of(value, rest, sensor, names_no_echo=names_no_echo)
        there = is_value(rest, value)
        if kind is not None:
            yield SensorFault(sensor_id=sensor.sensor_id, kind=kind, value=value, share=float(there.mean()))
            rest = rest._replace(readings=np.where(there, np.nan, rest.readings))
            names_no_echo |= kind == SensorFaultKind.NO_ECHO_VALUE
    # A module that reads no echo, by whatever value, has no need to hold a reading.
    held = 0.0 if names_no_echo else float(held_readings(rest).mean())
    if is_logged_repeatedly(rest):
        finite = rest.readings[np.isfinite(rest.readings)]
        times = float(np.median(np.bincount(runs_of(finite))))
        yield SensorFault(sensor_id=sensor.sensor_id, kind=SensorFaultKind.LOGGED_REPEATEDLY, value=times)
    elif held >= _SHARE:
        yield SensorFault(sensor_id=sensor.sensor_id, kind=SensorFaultKind.HELD, share=held)


def _flyback(sweeps: Sequence[Sweep], sensor: Sensor) -> list[SensorFault]:
    count = count_flyback_readings(sweeps, sensor.sensor_id, sensor.half_aperture)
    if not count:
        return []
    return [SensorFault(sensor_id=sensor.sensor_id, kind=SensorFaultKind.FLYBACK, value=float(count))]


def is_no_echo(trace: Trace, sensor: Sensor) -> BoolArray:
    """Mark the readings at the end of the reach or beyond: they mean that there was no echo."""
    marked: BoolArray = trace.readings >= sensor.max_range - 1.01 * sensor.resolution
    return marked


def _kind_of(value: float, trace: Trace, sensor: Sensor, *, names_no_echo: bool) -> SensorFaultKind | None:
    """Return what a value stands for; None if it is a distance like others, or already known to be none."""
    there = is_value(trace, value)
    if value < sensor.min_range:
        # Sonar misses some echoes anywhere: a module that never says so says it by this value.
        starts = trace.only(there & ~np.append(False, there[:-1]))
        is_no_distance = not names_no_echo and count_walls(starts) >= _PLACES
        return SensorFaultKind.NO_ECHO_VALUE if is_no_distance else None
    if not _stands_for_something(trace, value):
        return None
    others = trace.readings[np.isfinite(trace.readings) & ~there]
    if not names_no_echo or np.mean(others > value) < _NEARER:
        return SensorFaultKind.NO_ECHO_VALUE
    return SensorFaultKind.BLIND_VALUE if np.mean(others < value) < _NEARER else SensorFaultKind.FIXED_VALUE


def _stands_for_something(trace: Trace, value: float) -> bool:
    """Return True if a value is read often, and at more places than a distance would be."""
    return bool(is_value(trace, value).mean() >= _STANDING and excess_of_value(trace, value) >= _EVIDENCE)


def _with_mates(found: list[SensorFault], traces: Sequence[Trace], rig: Rig) -> tuple[SensorFault, ...]:
    """Add sensors of the same module as those that hold their last reading, if they never read no echo either."""
    settled = {fault.sensor_id for fault in found if fault.kind in _SETTLED}
    if any(fault.kind == SensorFaultKind.HELD for fault in found):
        for trace, sensor in zip(traces, rig.sensors, strict=True):
            if sensor.sensor_id not in settled and len(trace.readings) and is_no_echo(trace, sensor).mean() < _SHARE:
                share = float((np.bincount(runs_of(trace.readings)) - 1).sum() / len(trace.readings))
                found.append(SensorFault(sensor_id=sensor.sensor_id, kind=SensorFaultKind.HELD, share=share))
    places = {sensor.sensor_id: place for place, sensor in enumerate(rig.sensors)}
    return tuple(sorted(found, key=lambda fault: places[fault.sensor_id]))
