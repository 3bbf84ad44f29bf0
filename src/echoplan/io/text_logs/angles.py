"""Angles of the servo: their unit, where they look ahead, and which way they grow."""

import math
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.text_logs.columns import Role
from echoplan.io.text_logs.facts import Fact, Origin, stated_fact
from echoplan.io.text_logs.options import LogOptions, angle_unit
from echoplan.io.text_logs.plausibility import looks_like_radians
from echoplan.io.text_logs.records import Reading, Records
from echoplan.model import Conventions

__all__ = ["understood_angles", "understood_unit_of_angle"]

# Beyond a turn, what is logged are steps of a motor or microseconds of a servo's pulse, unless a unit is stated [rad].
_TURN = 2.0 * math.pi
_QUARTER = math.pi / 2.0


def understood_angles(records: Records, options: LogOptions, *, source: str) -> tuple[FloatArray, tuple[Fact, ...]]:
    """Return the angles of the readings, shape (n,) [rad]; zeros and no facts where the sensors do not turn."""
    raw, written = _recorded(records, options, source=source)
    if raw is None:
        return np.zeros(len(records.readings)), ()
    unit, fact = understood_unit_of_angle(raw, subject="angles", given=options.angle_unit, written=written)
    span = f"{raw.min():g} to {raw.max():g}"
    is_stated = fact.origin in (Origin.OPTION, Origin.STATED)
    _check_turn(unit * raw, options, source=source, span=span, is_stated=is_stated)
    direction = _direction(records, options)
    sign = 1 if direction.origin is Origin.DEFAULT else -1
    conventions = Conventions(servo_sign=sign, servo_offset=-sign * unit * (options.center or 0.0))
    center = Fact(
        subject="straight ahead",
        value=f"{options.center or 0.0:g}",
        origin=Origin.DEFAULT if options.center is None else Origin.OPTION,
    )
    facts = (replace(fact, value=f"{span} {fact.value}"), center, direction, *_counted(records, options))
    return conventions.servo_angles(unit * raw), facts


def _direction(records: Records, options: LogOptions) -> Fact:
    """Return how angles grow: clockwise only if that is given, or if the name of the column says so."""
    column = records.column(Role.ANGLE)
    origin = Origin.STATED if column and column.is_clockwise else Origin.DEFAULT
    origin = Origin.OPTION if options.clockwise else origin
    value = "counter-clockwise" if origin is Origin.DEFAULT else "clockwise"
    return Fact(subject="angles grow", value=value, origin=origin)


def _check_turn(angles: FloatArray, options: LogOptions, *, source: str, span: str, is_stated: bool) -> None:
    """Refuse angles [rad] that do not show their unit, or which of them looks ahead."""
    if float(np.abs(angles).max()) > _TURN + 1e-9 and not is_stated:
        remedy = "give --angle-unit with the degrees per count, such as 1.8, or --angle-unit deg if it turns on and on"
        raise InputError(source, f"angles from {span} are more than a turn in degrees", remedy=remedy)
    if angles.min() >= -1e-9 and angles.max() > _QUARTER + 1e-9 and options.center is None:
        problem = f"angles from {span} do not say which of them looks ahead"
        raise InputError(source, problem, remedy="give --center 90 if 90 is straight ahead, or --center 0")


def _recorded(records: Records, options: LogOptions, *, source: str) -> tuple[FloatArray | None, str]:
    """Return the angles as they were written or are implied by ``--angles``, and the unit that the log states."""
    raw = np.array([reading.angle for reading in records.readings])
    if options.angles is None:
        return (raw if records.column(Role.ANGLE) else None), records.unit(Role.ANGLE)
    if records.column(Role.ANGLE):
        raise InputError(source, "it has angles of its own", remedy="leave out --angles")
    first, step = options.angles
    return first + step * _numbers_of_lines(records), ""


def _numbers_of_lines(records: Records) -> FloatArray:
    """Return the number of the line of each reading since the last place or the beginning of the file, shape (n,).

    A line that was skipped was a reading, and keeps its number.
    """
    numbers: list[float] = []
    for items in records.files:
        start = next((item.position for item in items if isinstance(item, Reading)), 0)
        for item in items:
            if isinstance(item, Reading):
                numbers.append(item.position - start)
            else:
                start = item.position + 1
    return np.array(numbers)


def _counted(records: Records, options: LogOptions) -> list[Fact]:
    """State that lines were counted as readings although they are none: each of them moves the angles behind it."""
    lost = sum(bool(line.text) for line in records.skipped)
    if options.angles is None or not lost:
        return []
    return [Fact(subject="skipped lines", value=f"{lost}, counted as readings", origin=Origin.GUESSED, option="--yes")]


def understood_unit_of_angle(raw: FloatArray, *, subject: str, given: str, written: str) -> tuple[float, Fact]:
    """Return the radians in the unit of angles or headings: given, written, or visibly radians; else degrees."""
    option = "--angle-unit" if subject == "angles" else "--heading-unit"
    fact = stated_fact(subject, given=given, written=written)
    if fact is None and looks_like_radians(raw):
        fact = Fact(subject=subject, value="rad", origin=Origin.GUESSED, option=f"{option} rad")
    fact = fact or Fact(subject=subject, value="deg", origin=Origin.DEFAULT)
    return angle_unit(fact.value, option=option), fact
