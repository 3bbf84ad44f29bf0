"""Causes: mistakes in how a recording is written, each tried on the recording itself."""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import product
from typing import Any

import numpy as np

from echoplan.diagnosis.calibration import servo_error, servo_turned
from echoplan.diagnosis.consistency import Consistency, consistency, sampled
from echoplan.model import UNITS, Axes, Conventions, Heading, Rig, Sweep
from echoplan.preprocessing import ENOUGH_PLACES, count_places

__all__ = ["SAME_UNIT", "Cause", "Remedy", "find_remedies"]

_HALF = math.pi / 2
# Lengths of a unit that are written with six digits are the same.
SAME_UNIT = 1e-6


class Cause(StrEnum):
    """What people get wrong."""

    SERVO = "servo"
    HEADING = "heading"
    AXES = "axes"
    RANGE_UNIT = "range unit"
    POSITION_UNIT = "position unit"
    SENSOR = "sensor"


@dataclass(frozen=True, slots=True, kw_only=True)
class Remedy:
    """A mistake, and how much better the recording fits one room without it.

    Parameters
    ----------
    cause : Cause
        The kind of mistake.
    conventions : Conventions
        How the recording is written.
    sensor_id : int or None
        The sensor that looks backwards, if it is that.
    yaw : float
        Which way it looks [rad].
    share, share_before : float
        Share of the echoes that one room explains, with the remedy and without.
    """

    cause: Cause
    conventions: Conventions
    sensor_id: int | None = None
    yaw: float = 0.0
    share: float = 0.0
    share_before: float = 0.0


def find_remedies(sweeps: Sequence[Sweep], rig: Rig, *, conventions: Conventions) -> tuple[Remedy, ...]:
    """Try what people get wrong, one after the other, on a part of a recording.

    Parameters
    ----------
    sweeps : sequence of Sweep
        All sweeps, as read with the conventions.
    rig : Rig
        What made them.
    conventions : Conventions
        As ``rig.toml`` has them.

    Returns
    -------
    tuple of Remedy
        Those that explain the echoes, and clearly more of them than are explained now; the best first.
    """
    some = sampled(sweeps, rig)
    # From fewer places anything fits.
    if count_places(some) < ENOUGH_PLACES:
        return ()
    # A servo that does not quite turn as recorded is no mistake: joint calibrates it.
    before = consistency(servo_turned(some, servo_error(some, rig)), rig)
    recorded = [conventions.undo(sweep) for sweep in some]
    found: list[tuple[float, Remedy]] = []
    for trial in _trials(some, rig, conventions, before):
        after = consistency([trial.conventions.apply(sweep) for sweep in recorded], _turned_about(rig, trial))
        gain = _gain(after, trial.conventions.range_unit / conventions.range_unit) - before.gain
        if _explains(after, gain):
            found.append((gain, replace(trial, share=after.share, share_before=before.share)))
    found.sort(key=lambda each: -each[0])
    return tuple(remedy for gain, remedy in found if gain > _AS_GOOD * found[0][0])


# Share of the echoes that are explained once a mistake is corrected, and evidence for it from each of them that is
# independent [nats]: of benchmarks/verdicts.py, seeds 1000 on.  From poses that drift fewer echoes are explained, and
# by chance more if these are read in another way.
_ENOUGH, _NEARLY_ALL = 0.5, 0.9
_BETTER, _FAR_BETTER = 0.5, 1.5
# A mistake for which there is nearly as much evidence may be it, too.
_AS_GOOD = 0.97


def _explains(after: Consistency, gain: float) -> bool:
    """Return True if a correction explains the echoes, and clearly more of them than before."""
    least = _BETTER if after.share > _NEARLY_ALL else _FAR_BETTER
    return after.share > _ENOUGH and gain > least * after.weight


def _gain(tried: Consistency, scale: float) -> float:
    """Take the evidence in the unit in which ranges were read: densities are those of readings as read."""
    return tried.gain + tried.weight * math.log(scale)


def _trials(sweeps: Sequence[Sweep], rig: Rig, conventions: Conventions, before: Consistency) -> Iterator[Remedy]:
    """Yield one remedy a mistake, not yet tried."""
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


# Signs and offsets of servos: as they are, clockwise, and of 0 to 180 degrees with 90 ahead, either way round.
_SERVOS = tuple(
    {"servo_sign": sign, "servo_offset": offset} for sign, offset in ((1, 0.0), (-1, 0.0), (1, -_HALF), (-1, _HALF))
)


def _written(cause: Cause, now: Conventions, changes: Iterable[Mapping[str, Any]]) -> Iterator[Remedy]:
    """Yield other values of some conventions."""
    for change in changes:
        conventions = replace(now, **change)
        if conventions != now:
            yield Remedy(cause=cause, conventions=conventions)


def _named(metres: float) -> float:
    """Round a unit to one that has a name, if it is that."""
    return next((unit for unit in UNITS.values() if math.isclose(unit, metres, rel_tol=SAME_UNIT)), metres)


# A length in one unit that was taken for a metric one is off by one of these.
_FACTORS = sorted({one / UNITS[other] for one, other in product(UNITS.values(), ("m", "cm", "mm"))} - {1.0})
# Readings that must lie within reach, places that must be as far apart as robots are moved: shares and reaches.
_WITHIN, _NEAREST, _FARTHEST = 0.9, 0.02, 2.0


def _range_factors(sweeps: Sequence[Sweep], rig: Rig) -> list[float]:
    ranges = np.concatenate([sweep.ranges for sweep in sweeps])
    sensors = rig.indices(np.concatenate([sweep.sensor_ids for sweep in sweeps]))
    detected = np.isfinite(ranges)
    low, high = rig.min_ranges[sensors][detected], rig.max_ranges[sensors][detected]

    def fits(factor: float) -> bool:
        return bool(np.mean((factor * ranges[detected] >= low) & (factor * ranges[detected] <= high)) > _WITHIN)

    return [factor for factor in _FACTORS if fits(factor)] if detected.any() else []


def _position_factors(sweeps: Sequence[Sweep], rig: Rig) -> list[float]:
    places = np.array([sweep.station[:2] for sweep in sweeps])
    strides = np.hypot(*np.diff(places, axis=0).T)
    stride, reach = float(np.median(strides[strides > 0])) if strides.any() else 0.0, float(rig.max_ranges.max())
    return [factor for factor in _FACTORS if _NEAREST * reach < factor * stride < _FARTHEST * reach]


def _turned_about(rig: Rig, trial: Remedy) -> Rig:
    """Turn the sensor about that is tried so."""
    if trial.sensor_id is None:
        return rig
    turned = (replace(each, yaw=trial.yaw) if each.sensor_id == trial.sensor_id else each for each in rig.sensors)
    return replace(rig, sensors=tuple(turned))
