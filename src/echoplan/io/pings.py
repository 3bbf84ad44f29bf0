"""The rows of ``pings.csv``: their columns, and what must hold between them and the rig."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from echoplan.errors import InputError
from echoplan.io.kinds import ANGLE, COUNT, POSITION, READING, SECONDS, TEMPERATURE, WHOLE, Kind
from echoplan.io.table import Rows, Table
from echoplan.io.text import format_seconds
from echoplan.io.units import WIDEST, looks_like_degrees, possible_length_units
from echoplan.model import UNITS, Conventions, Rig

__all__ = ["MEASURED", "PING_COLUMNS", "REQUIRED", "checked_pings"]

PING_COLUMNS: Mapping[str, Kind] = {
    "t": SECONDS,
    "sweep": COUNT,
    "sensor": WHOLE,
    "servo": ANGLE,
    "range": READING,
    "x": POSITION,
    "y": POSITION,
    "yaw": ANGLE,
    "temperature": TEMPERATURE,
}
# What is there if somebody measured it, and what must be there.
MEASURED = ("temperature",)
REQUIRED = tuple(name for name in PING_COLUMNS if name not in MEASURED)
# Stations farther apart than this many reaches of the sensors have no object in common.
_LONGEST_STRIDE = 10.0
# A servo_gain below this is near pi / 180: it makes radians of recorded degrees.
_LEAST_GAIN_OF_RADIANS = 0.1


def checked_pings(table: Table, rig: Rig, conventions: Conventions) -> Iterator[Rows]:
    """Read pings in chunks, each checked before it is given away.

    Parameters
    ----------
    table : Table
        The pings.
    rig : Rig
        What made them.
    conventions : Conventions
        How they are written.

    Yields
    ------
    Rows
        Rows in SI and REP 103, in the order of time and of sweeps, of sensors that the rig has.

    Raises
    ------
    InputError
        If a row cannot be, is out of order or in a wrong unit, or no ping of all has a reading.
    """
    first, last, silent = None, None, True
    for recorded in table:
        rows = _converted(recorded, conventions)
        first = rows.data[0] if first is None else first
        _check_way(rows, first)
        _check_sensors(rows, rig)
        if not rows.first:
            with np.errstate(over="ignore"):
                _check_units(recorded, rows, rig, conventions)
        _check_order(rows, rows.data[0] if last is None else last)
        last = rows.data[-1]
        silent = silent and bool(np.isnan(rows.data["range"]).all())
        yield rows
    if silent:
        problem, remedy = "no ping has a reading", "check the wiring of the sensors"
        raise InputError(table.path, problem, place="column range", remedy=remedy)


def _converted(rows: Rows, conventions: Conventions) -> Rows:
    """Convert rows to SI and REP 103."""
    if conventions == Conventions():
        return rows
    data = rows.data.copy()
    data["servo"] = conventions.servo_angles(data["servo"])
    data["range"] = conventions.ranges(data["range"])
    poses = conventions.poses(np.column_stack([data["x"], data["y"], data["yaw"]]))
    data["x"], data["y"], data["yaw"] = poses.T
    return replace(rows, data=data)


def _check_sensors(rows: Rows, rig: Rig) -> None:
    strange = np.flatnonzero(~np.isin(rows.data["sensor"], rig.sensor_ids))
    if strange.size:
        problem = f"sensor {rows.data['sensor'][strange[0]]} is not in rig.toml"
        known = ", ".join(map(str, rig.sensor_ids))
        raise rows.refusal(int(strange[0]), "sensor", problem, remedy=f"add it there; known are {known}")


def _check_way(rows: Rows, first: np.void) -> None:
    for column in ("x", "y"):
        far = np.flatnonzero(np.abs(rows.data[column] - first[column]) > WIDEST)
        if far.size:
            problem = f"the robot is more than {WIDEST:g} m from where it began"
            raise rows.refusal(int(far[0]), column, problem, remedy="correct the pose, here or in the first row")


def _check_order(rows: Rows, last: np.void) -> None:
    for column, written, remedy in (
        ("t", format_seconds, "sort the rows by t"),
        ("sweep", str, "number the sweeps in the order of time and let none overlap"),
    ):
        numbers = np.append(last[column], rows.data[column])
        falls = np.flatnonzero(np.diff(numbers) < 0)
        if falls.size:
            before, after = map(written, numbers[falls[0] :][:2].tolist())
            raise rows.refusal(int(falls[0]), column, f"{column} {after} comes after {before}", remedy=remedy)


def _check_units(recorded: Rows, rows: Rows, rig: Rig, conventions: Conventions) -> None:
    """Check the first rows, before and after conversion, against the rig: a wrong unit is wrong from the start."""
    _check_ranges(recorded, rig, conventions.range_unit)
    _check_positions(rows, rig)
    for column, gain in (("servo", conventions.servo_gain), ("yaw", 1.0)):
        if gain >= _LEAST_GAIN_OF_RADIANS and looks_like_degrees(recorded.data[column]):
            raise rows.refusal(0, column, "the angles look like degrees", remedy="write radians")


def _check_ranges(recorded: Rows, rig: Rig, unit: float) -> None:
    """Check ranges, recorded in a unit of so many metres, against the reach of the sensors."""
    sensors = rig.indices(recorded.data["sensor"])
    least, most = rig.min_ranges[sensors], rig.max_ranges[sensors]
    others = possible_length_units(recorded.data["range"], min_ranges=least, max_ranges=most, unit=unit)
    if others:
        named = " or ".join(f'"{other}"' for other in others)
        present = next((f'"{name}"' for name, metres in UNITS.items() if metres == unit), f"{unit:g}")
        problem = "no metres" if unit == 1.0 else f"not in the range_unit that is set, {present}"
        remedy = f"set range_unit = {named} under [conventions] in rig.toml, whichever the program writes"
        raise recorded.refusal(
            0, "range", f"the ranges are {problem}: max_range of rig.toml puts them out of reach", remedy=remedy
        )


def _check_positions(rows: Rows, rig: Rig) -> None:
    strides = np.hypot(np.diff(rows.data["x"]), np.diff(rows.data["y"]))
    stride = np.median(strides[strides > 0]) if strides.any() else 0.0
    reach = rig.max_ranges.max()
    if stride > _LONGEST_STRIDE * reach:
        problem = f"the robot moves by {stride:g} at a time, but its sensors reach {reach:g} m"
        raise rows.refusal(
            0, "x", problem, remedy="write x and y in metres, or set position_unit under [conventions] in rig.toml"
        )
