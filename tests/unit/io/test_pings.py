"""Rows that cannot be are refused where they stand."""

import re
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest

from echoplan.errors import InputError
from echoplan.io import read_recording
from echoplan.io import table as table_module

Folder = Callable[..., Path]

HEADER = "t,sweep,sensor,servo,range,x,y,yaw"
FIRST = "0.025,3,0,-0.785398,1.2900,-2.63823,3.12315,-2.438584"


def with_field(row: str, column: str, text: str) -> str:
    fields = row.split(",")
    fields[HEADER.split(",").index(column)] = text
    return ",".join(fields)


def series(column: str, numbers: Iterable[float]) -> list[str]:
    return [with_field(with_field(FIRST, "sweep", str(k)), column, f"{number}") for k, number in enumerate(numbers)]


@pytest.mark.parametrize(
    ("column", "text", "problem"),
    [
        ("t", "0.020", "t 0.02 comes after 0.025; sort the rows by t"),
        ("t", "noon", "'noon' is no time; write seconds, with a decimal point"),
        ("t", "1700000000000", "'1700000000000' is no time; write seconds"),
        ("sweep", "2", "sweep 2 comes after 3; number the sweeps in the order of time and let none overlap"),
        ("sweep", "-1", "'-1' is no count"),
        ("sensor", "9", "sensor 9 is not in rig.toml; add it there; known are 0, 1, 2, 3"),
        ("servo", "", "the field is empty"),
        ("range", "-0.3", "'-0.3' is no range; write metres with a decimal point, inf for no echo, -inf for too close"),
        ("range", "far", "'far' is no range"),
        ("x", "nan", "'nan' is no number"),
        ("yaw", "0.5 rad", "'0.5 rad' is no number"),
        ("x", "1e300", "'1e300' is no number; write a finite number of metres, with a decimal point"),
        ("y", "500000", "the robot is more than 10000 m from where it began; correct the pose, here or in the first"),
        ("servo", "1e9", "'1e9' is no number; write a finite number of radians"),
    ],
)
def test_an_invalid_field_is_refused_with_line_and_column(folder: Folder, column: str, text: str, problem: str) -> None:
    path = folder(FIRST, "", with_field(FIRST, column, text), FIRST)
    with pytest.raises(InputError, match=rf"pings\.csv, line 4, column {column}: {re.escape(problem)}"):
        list(read_recording(path))


def test_sweeps_that_overlap_in_time_are_refused(folder: Folder) -> None:
    rows = [with_field(FIRST, "sweep", number) for number in ("3", "4", "3")]
    with pytest.raises(InputError, match=r"line 4, column sweep: sweep 3 comes after 4; .* let none overlap"):
        list(read_recording(folder(*rows)))


def test_order_holds_across_chunks(folder: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table_module, "_CHUNK", 1)
    with pytest.raises(InputError, match=r"line 3, column t: t 0\.024 comes after 0\.025"):
        list(read_recording(folder(FIRST, with_field(FIRST, "t", "0.024"))))


def test_a_recording_without_any_reading_is_refused(folder: Folder) -> None:
    rows = [with_field(FIRST, "range", text) for text in ("nan", "", "nan")]
    with pytest.raises(InputError, match=r"column range: no ping has a reading; check the wiring of the sensors"):
        list(read_recording(folder(*rows)))


def test_silence_is_a_reading(folder: Folder) -> None:
    assert len(list(read_recording(folder(with_field(FIRST, "range", "inf"))))) == 1


WRONG_UNITS = {
    "centimetres": (
        series("range", [30.5, 120.0, 85.5]),
        "range",
        'the ranges are no metres: .* set range_unit = "cm" or "mm" or "in"',
    ),
    "millimetres": (series("range", [305, 1200, 2855]), "range", 'the ranges are no metres: .* set range_unit = "mm"'),
    "pose in centimetres": (series("x", [0, 55, 110, 90]), "x", "the robot moves by 55 at a time, but its sensors"),
    "pose in millimetres": (series("y", [0, 550, 1100, 900]), "x", "the robot moves by 550 at a time"),
    "servo in degrees": (series("servo", range(-45, 46)), "servo", "the angles look like degrees; write radians"),
    "yaw in degrees": (series("yaw", [0, 90, 180, 270]), "yaw", "the angles look like degrees; write radians"),
}


@pytest.mark.parametrize("name", WRONG_UNITS)
def test_a_wrong_unit_is_refused(folder: Folder, name: str) -> None:
    rows, column, problem = WRONG_UNITS[name]
    with pytest.raises(InputError, match=rf"pings\.csv, line 2, column {column}: {problem}"):
        list(read_recording(folder(*rows)))


RIGHT_UNITS = {
    "readings beyond the reach": series("range", [3.2, 4.0, 5.5]),
    "a number that stands for no echo": series("range", [999, 999, 999, 1.2]),
    "a long way in short steps": series("x", [0.5 * step for step in range(1000)]),
    "one long leap": series("x", [0.0, 0.5, 1.0, 200.0, 200.5]),
    "yaw over many turns": series("yaw", [0.1 + 1.234 * step for step in range(100)]),
    "a servo that turns on and on": series("servo", [0.0174533 * step for step in range(1000)]),
}


@pytest.mark.parametrize("name", RIGHT_UNITS)
def test_what_is_merely_unusual_is_read(folder: Folder, name: str) -> None:
    rows = RIGHT_UNITS[name]
    assert len(list(read_recording(folder(*rows)))) == len(rows)


def test_units_are_judged_by_the_beginning_alone(folder: Folder, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(table_module, "_CHUNK", 3)
    assert len(list(read_recording(folder(*series("range", [0.5, 1.0, 1.5, 120.0, 130.0]))))) == 5
