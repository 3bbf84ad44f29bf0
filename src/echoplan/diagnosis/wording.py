"""Sentences about the measures of a verdict: one per reason, and the next step."""

import math
from collections.abc import Iterator
from dataclasses import fields
from typing import TYPE_CHECKING

from echoplan.diagnosis.causes import SAME_UNIT, Cause, Remedy
from echoplan.diagnosis.findings import faults_in_words
from echoplan.diagnosis.stations import Misplaced
from echoplan.model import UNITS, Axes, Conventions, Heading
from echoplan.preprocessing import RecordingFaultKind

if TYPE_CHECKING:
    from echoplan.diagnosis.assessment import Measures

__all__ = ["next_step", "reasons"]

_ELSEWHERE = "Run echoplan info on the recording to check the readings, and check {mountings} and the poses."
# Bags and simulations have neither file; a recording that is made of one has both.
_CONVERT = " It has no such file yet: echoplan convert SOURCE --to rec/ writes pings.csv and rig.toml. Map rec/ then."
_RECORD = "Record again as the first reason says."
_POINTS = "Map it with --method point-plot, whose map nothing checks."
_COMPARE = "Measure some walls of the room to check the map: nothing else checks it."
_JOINT = "Map it with --method joint, which checks its map against the echoes."
_FINDINGS = "Correct the sensor or its program as the first reason says, and record again."
_HEADINGS = {
    Heading.COUNTER_CLOCKWISE: "headings seem to grow counter-clockwise from +x",
    Heading.CLOCKWISE: "headings seem to grow clockwise",
    Heading.COMPASS: "headings seem to be those of a compass, clockwise from +y",
}
_AXES = {
    Axes.XY: "y seems to point left of x",
    Axes.YX: "x and y seem to be swapped",
    Axes.Y_DOWN: "y seems to point right of x, as on a screen",
}


def reasons(measures: "Measures", now: Conventions) -> tuple[str, ...]:
    """Return the reasons why a map is not good: causes before symptoms."""
    findings = faults_in_words(measures.faults)
    empty = () if measures.features else ("No wall, corner or cylinder was found.",)
    if measures.remedies:
        best = measures.remedies[0]
        shares = f"{_percent(best.share)} of the echoes fit together then, instead of {_percent(best.share_before)}"
        return (f"{_capital(_problem(best, now))}: {shares}.", *findings, *empty)
    return (*findings, *empty, *_symptoms(measures))


def _symptoms(measures: "Measures") -> Iterator[str]:
    yield from (_misplaced(each) for each in measures.misplaced)
    if measures.odd_sensor is not None:
        yield f"Few echoes of sensor {measures.odd_sensor} fit what the other sensors detect."
    yield from _shares(measures) if measures.features else ()
    if measures.crossed:
        walls = "1 wall lies" if measures.crossed == 1 else f"{measures.crossed} walls lie"
        yield f"{walls} across the path of the robot."
    # An empty map has nothing to check.
    if measures.unchecked and measures.features:
        yield _unchecked(measures)


def _unchecked(measures: "Measures") -> str:
    """Report that nothing checks the map; recordings with faults are not tested with other conventions either."""
    rest = "" if measures.faults.recording else ": only the poses and conventions were checked"
    return f"{measures.unchecked} does not say how well its map explains the echoes{rest}."


def _shares(measures: "Measures") -> Iterator[str]:
    if measures.is_unexplained:
        yield f"Only {_percent(measures.share)} of the echoes fit together."
    if measures.is_unconfirmed:
        yield f"Only {_percent(measures.confirmed)} of the echoes come from something that two stations detect."


def next_step(measures: "Measures", now: Conventions, *, has_rig_file: bool = True) -> str:
    """Return what to do about the first reason, in the files of the recording if it has any."""
    convert = "" if has_rig_file else _CONVERT
    if measures.remedies:
        best, *rivals = measures.remedies
        otherwise = "".join(f" If {_problem(each, now)}, {_what_to_set(each, now)} instead." for each in rivals[:1])
        return f"{_capital(_what_to_set(best, now))} and map again.{otherwise}{convert}"
    if measures.faults.recording:
        return _otherwise_recorded(measures)
    if measures.misplaced:
        sweeps = " and ".join(str(each.sweep) for each in measures.misplaced)
        return f"Check x, y and yaw of sweep {sweeps} in pings.csv, or leave the sweep out, and map again.{convert}"
    return _what_to_check(measures, has_rig_file=has_rig_file)


def _what_to_check(measures: "Measures", *, has_rig_file: bool) -> str:
    """Return what to check where no cause is known."""
    if measures.faults.sensors:
        return _FINDINGS
    if measures.odd_sensor is not None:
        return f"Check where sensor {measures.odd_sensor} is mounted and looks, and its wiring; then map again."
    elsewhere = _ELSEWHERE.format(mountings="rig.toml" if has_rig_file else "where the sensors are mounted")
    return _JOINT if measures.unchecked else elsewhere


def _otherwise_recorded(measures: "Measures") -> str:
    """Return what to do about a fault of the recording."""
    if measures.faults.recording[0].kind is not RecordingFaultKind.NARROW_BEAM:
        return _RECORD
    return _COMPARE if measures.unchecked == "point-plot" else _POINTS


def _problem(remedy: Remedy, now: Conventions) -> str:
    then = remedy.conventions
    words = {
        Cause.SERVO: lambda: f"the servo seems to {_servo(then, now)}",
        Cause.HEADING: lambda: _HEADINGS[then.heading],
        Cause.AXES: lambda: _AXES[then.axes],
        Cause.RANGE_UNIT: lambda: f"the ranges seem to be {_mistaken(then.range_unit / now.range_unit)}",
        Cause.POSITION_UNIT: lambda: f"x and y seem to be {_mistaken(then.position_unit / now.position_unit)}",
        Cause.SENSOR: lambda: f"sensor {remedy.sensor_id} seems to look the other way",
    }
    return words[remedy.cause]()


def _servo(then: Conventions, now: Conventions) -> str:
    turning = f"turn {'clockwise' if then.servo_sign < 0 else 'counter-clockwise'}"
    if then.servo_offset == now.servo_offset:
        return turning
    ahead = f"look ahead at {-then.servo_sign * math.degrees(then.servo_offset):.0f} degrees"
    return ahead if then.servo_sign == now.servo_sign else f"{ahead} and to {turning}"


_UNITS = {"m": "metres", "cm": "centimetres", "mm": "millimetres", "in": "inches", "ft": "feet"}


def _mistaken(factor: float) -> str:
    """Name the confused units that make lengths too small by a factor; pairs with centimetres are preferred."""
    factors = {(one, other): UNITS[one] / UNITS[other] for one in UNITS for other in UNITS if one != other}
    # With the tolerance to which a remedy is rounded to a unit.
    pairs = [pair for pair, ratio in factors.items() if math.isclose(ratio, factor, rel_tol=SAME_UNIT)]
    if not pairs:
        return "in another unit"
    one, other = next((pair for pair in pairs if "cm" in pair), pairs[0])
    return f"{_UNITS[one]} that were taken for {_UNITS[other]}"


def _what_to_set(remedy: Remedy, now: Conventions) -> str:
    if remedy.sensor_id is not None:
        return f"set yaw = {remedy.yaw:.5f} of sensor {remedy.sensor_id} in rig.toml"
    lines = [
        f"{field.name} = {_toml(field.name, getattr(remedy.conventions, field.name))}"
        for field in fields(Conventions)
        if getattr(remedy.conventions, field.name) != getattr(now, field.name)
    ]
    return f"set {' and '.join(lines)} under [conventions] in rig.toml"


def _toml(name: str, value: object) -> str:
    if isinstance(value, float):
        unit = next((unit for unit, metres in UNITS.items() if metres == value), None)
        return f'"{unit}"' if unit and name.endswith("unit") else f"{value:.6g}"
    return f'"{value}"' if isinstance(value, str) else str(value)


def _misplaced(station: Misplaced) -> str:
    turn, way = math.degrees(station.turn), "left" if station.turn > 0.0 else "right"
    moves = [f"{station.distance:.2f} m elsewhere"] if station.distance > _VISIBLE else []
    turns = [f"turned {abs(turn):.0f} degrees to the {way}"] if abs(turn) > 1.0 else []
    return f"Sweep {station.sweep} does not fit the others: it would fit {' and '.join((*moves, *turns))}."


# Distance from which it is mentioned [m].
_VISIBLE = 0.02


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]
