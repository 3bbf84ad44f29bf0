"""Causes: mistakes in the conventions of a recording, each tested on the recording itself."""

import math
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import product
from typing import Any

import numpy as np

from echoplan.diagnosis.calibration import servo_error
from echoplan.diagnosis.consistency import Consistency, consistency, sampled
from echoplan.model import UNITS, Axes, Conventions, Heading, Rig, Sweep
from echoplan.preprocessing import ENOUGH_PLACES, count_places
from echoplan.preprocessing.placement import servo_turned

__all__ = ["SAME_UNIT", "Cause", "Remedy", "find_remedies"]

_HALF = math.pi / 2
# Relative tolerance of units: they are written with six digits.
SAME_UNIT = 1e-6


class Cause(StrEnum):
    """Common mistake."""

    SERVO = "servo"
    HEADING = "heading"
    AXES = "axes"
    RANGE_UNIT = "range unit"
    POSITION_UNIT = "position unit"
    SENSOR = "sensor"


@dataclass(frozen=True, slots=True, kw_only=True)
class Remedy:
    """A mistake, and how many more echoes one room explains without it.

    Parameters
    ----------
    cause : Cause
        Kind of mistake.
    conventions : Conventions
        Conventions that the recording really follows.
    sensor_id : int or None
        Sensor that points backwards, if that is the mistake.
    yaw : float
        Direction of this sensor [rad].
    share, share_before : float
        Shares of the echoes that one room explains, with the remedy and without.
    """

    cause: Cause
    conventions: Conventions
    sensor_id: int | None = None
    yaw: float = 0.0
    share: float = 0.0
    share_before: float = 0.0


def find_remedies(
    sweeps: Sequence[Sweep], rig: Rig, *, conventions: Conventions, causes: Collection[Cause] = tuple(Cause)
) -> tuple[Remedy, ...]:
    """Test common mistakes, one at a time, on a sample of a recording.

    Parameters
    ----------
    sweeps : sequence of Sweep
        All sweeps, as read with the conventions.
    rig : Rig
        Sensors that recorded them.
    conventions : Conventions
        Conventions as in ``rig.toml``.
    causes : collection of Cause, optional
        Mistakes to test; all by default.

    Returns
    -------
    tuple of Remedy
        Remedies that explain the echoes, and clearly more of them than without; the best first.
    """
    if not causes:
        return ()
    some = sampled(sweeps, rig)
    # With fewer places, any conventions are consistent.
    if count_places(some) < ENOUGH_PLACES:
        return ()
    found = sorted(_found(some, rig, conventions=conventions, causes=causes), key=lambda each: -each[0])
    return tuple(remedy for gain, remedy in found if gain > _AS_GOOD * found[0][0])


def _found(
    sweeps: Sequence[Sweep], rig: Rig, *, conventions: Conventions, causes: Collection[Cause]
) -> Iterator[tuple[float, Remedy]]:
    """Yield the remedies that explain the echoes better, with the gain in log evidence [nats]."""
    # A small servo error is no mistake, since `joint` calibrates it.
    before = consistency(servo_turned(sweeps, servo_error(sweeps, rig)), rig)
    recorded = [conventions.undo(sweep) for sweep in sweeps]
    for trial in _trials(sweeps, rig, conventions, before):
        if trial.cause not in causes:
            continue
        after = consistency([trial.conventions.apply(sweep) for sweep in recorded], _turned_about(rig, trial))
        # Probability densities depend on the unit of ranges: compare those of ranges in the unit as read.
        scale = trial.conventions.range_unit / conventions.range_unit
        gain = after.gain + after.weight * math.log(scale) - before.gain
        # For a turned sensor only its own echoes count: those of the others may fit better by chance.
        if _explains(after if trial.sensor_id is None else after.of_sensor(before.strangest), gain=gain):
            yield gain, replace(trial, share=after.share, share_before=before.share)


# Least share of explained echoes with a remedy, and share above which the lower threshold applies; thresholds of the
# gain in log evidence per independent echo [nats]. Chosen on seeds from 1000 of benchmarks/verdicts.py. With drifting
# poses fewer echoes are explained, and wrong conventions may explain more by chance.
_ENOUGH, _NEARLY_ALL = 0.5, 0.9
_BETTER, _FAR_BETTER = 0.5, 1.5
# Share of the greatest log evidence from which another remedy is reported, too.
_AS_GOOD = 0.97


def _explains(concerned: Consistency, *, gain: float) -> bool:
    """Return True if a correction explains the echoes that it concerns, and clearly better."""
    least = _BETTER if concerned.share > _NEARLY_ALL else _FAR_BETTER
    return concerned.share > _ENOUGH and gain > least * concerned.weight


def _trials(sweeps: Sequence[Sweep], rig: Rig, conventions: Conventions, before: Consistency) -> Iterator[Remedy]:
    """Yield the remedies to test."""
    if any(np.ptp(sweep.servo_angles) > 0.0 for sweep in sweeps):
        yield from _written(Cause.SERVO, conventions, _SERVOS)
    yield from _written(Cause.HEADING, conventions, [{"heading": each} for each in Heading])
    yield from _written(Cause.AXES, conventions, [{"axes": each} for each in Axes])
    for cause, name, factors in (
        (Cause.RANGE_UNIT, "range_unit", _range_factors(sweeps, rig)),
        (Cause.POSITION_UNIT, "position_unit", _position_factors(sweeps, rig)),
    ):
        now = getattr(conventions, name)
        yield from _written(cause, conventions, [{name: _named(now * factor)} for factor in factors])
    sensor = rig.sensors[before.strangest]
    yaw = math.remainder(sensor.yaw + math.pi, math.tau)
    yield Remedy(cause=Cause.SENSOR, conventions=conventions, sensor_id=sensor.sensor_id, yaw=yaw)


# Signs and offsets of servos: as written, clockwise, and 0 to 180 degrees with 90 ahead, in both directions.
_SERVOS = tuple(
    {"servo_sign": sign, "servo_offset": offset} for sign, offset in ((1, 0.0), (-1, 0.0), (1, -_HALF), (-1, _HALF))
)


def _written(cause: Cause, now: Conventions, changes: Iterable[Mapping[str, Any]]) -> Iterator[Remedy]:
    """Yield a remedy for each change of the conventions."""
    for change in changes:
        conventions = replace(now, **change)
        if conventions != now:
            yield Remedy(cause=cause, conventions=conventions)


def _named(metres: float) -> float:
    """Return the exact unit [m] if a length is that up to rounding, else the length."""
    return next((unit for unit in UNITS.values() if math.isclose(unit, metres, rel_tol=SAME_UNIT)), metres)


# Factors between a length and the same number read in a metric unit.
_FACTORS = sorted({one / UNITS[other] for one, other in product(UNITS.values(), ("m", "cm", "mm"))} - {1.0})
# Least share of echoes within the range limits; least and greatest median step of the robot, as shares of the range.
_WITHIN, _NEAREST, _FARTHEST = 0.9, 0.02, 2.0


def _range_factors(sweeps: Sequence[Sweep], rig: Rig) -> list[float]:
    """Return the factors for which nearly all echoes lie within the range limits of their sensors."""
    ranges = np.concatenate([sweep.ranges for sweep in sweeps])
    sensors = rig.indices(np.concatenate([sweep.sensor_ids for sweep in sweeps]))
    detected = np.isfinite(ranges)
    low, high = rig.min_ranges[sensors][detected], rig.max_ranges[sensors][detected]

    def fits(factor: float) -> bool:
        """Return True if nearly all echoes, times a factor, lie within the range limits."""
        return bool(np.mean((factor * ranges[detected] >= low) & (factor * ranges[detected] <= high)) > _WITHIN)

    return [factor for factor in _FACTORS if fits(factor)] if detected.any() else []


def _position_factors(sweeps: Sequence[Sweep], rig: Rig) -> list[float]:
    """Return the factors for which the median step between sweeps is plausible for the range of the sensors."""
    places = np.array([sweep.station[:2] for sweep in sweeps])
    strides = np.hypot(*np.diff(places, axis=0).T)
    stride, reach = float(np.median(strides[strides > 0])) if strides.any() else 0.0, float(rig.max_ranges.max())
    return [factor for factor in _FACTORS if _NEAREST * reach < factor * stride < _FARTHEST * reach]


def _turned_about(rig: Rig, trial: Remedy) -> Rig:
    """Return the rig with the sensor of the trial turned about."""
    if trial.sensor_id is None:
        return rig
    turned = (replace(each, yaw=trial.yaw) if each.sensor_id == trial.sensor_id else each for each in rig.sensors)
    return replace(rig, sensors=tuple(turned))
