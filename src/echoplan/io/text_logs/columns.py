"""Columns: what each number of a line means, by ``--columns``, by a header, or by labels."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from itertools import groupby

from echoplan.errors import InputError, UnknownNameError
from echoplan.io.text_logs.cells import unit_of
from echoplan.io.text_logs.options import ANGLE_UNITS, MICROSECONDS
from echoplan.model import UNITS

__all__ = ["TIME_UNITS", "Column", "Role", "columns_named", "parse_columns", "spelled"]


class Role(StrEnum):
    """What a column holds, as ``--columns`` names it."""

    TIME = "t"
    ANGLE = "angle"
    RANGE = "range"
    X = "x"
    Y = "y"
    HEADING = "heading"
    LEFT = "left"
    RIGHT = "right"
    LEFT_STEP = "dleft"
    RIGHT_STEP = "dright"
    IGNORED = "-"


@dataclass(frozen=True, slots=True, kw_only=True)
class Column:
    """A column: its role, the unit that the log or an option states, where its sensor points, and how angles grow.

    One without a role may say which sensor a line is of.
    """

    role: Role
    unit: str = ""
    yaw: float | None = None
    is_clockwise: bool = False
    is_sensor: bool = False


# Names in headers and labels, without units and numbers, in English and German.
_NAMES = {
    Role.ANGLE: {
        *("angle", "ang", "servo", "servo angle", "servo pos", "pan", "bearing", "azimuth", "theta", "phi", "degree"),
        *("degrees", "deg", "direction", "winkel", "servowinkel"),
    },
    Role.RANGE: {
        *(
            "distance",
            "dist",
            "range",
            "ranges",
            "sonar",
            "ultrasonic",
            "ultrasound",
            "echo",
            "reading",
            "ping",
            "d",
            "r",
        ),
        *("us", "cm", "mm", "inches", "duration", "pulse", "abstand", "entfernung"),
    },
    Role.TIME: {"t", "time", "timestamp", "stamp", "millis", "ms", "seconds", "sec", "zeit"},
    Role.X: {"x", "pos x", "x pos", "robot x"},
    Role.Y: {"y", "pos y", "y pos", "robot y"},
    Role.LEFT: {"left", "left ticks", "left count", "left encoder", "ticks left", "encoder left", "enc left"},
    Role.RIGHT: {"right", "right ticks", "right count", "right encoder", "ticks right", "encoder right", "enc right"},
    Role.HEADING: {"heading", "yaw", "orientation", "robot heading", "robot yaw"},
}
_ROLES = {name: role for role, names in _NAMES.items() for name in names}
# What says of which sensor a line is.
_SENSOR_NAMES = ("sensor", "sensor id", "sensor no", "sensor number", "id", "channel", "ch", "device", "node")
# Columns of a ring of sensors: S1, S2, ...
_NUMBERED = re.compile(r"(s|u|us|d|r|sonar|sensor|range|dist|distance|echo|ultrasonic) ?#?(\d+)")
TIME_UNITS = {"s": 1.0, "ms": 1e-3, MICROSECONDS: 1e-6}
_UNITS_OF = {
    Role.TIME: tuple(TIME_UNITS),
    Role.ANGLE: tuple(ANGLE_UNITS),
    Role.HEADING: tuple(ANGLE_UNITS),
    Role.RANGE: (*UNITS, MICROSECONDS),
    Role.X: tuple(UNITS),
    Role.Y: tuple(UNITS),
}


def parse_columns(text: str, *, option: str) -> tuple[Column, ...]:
    """Read a list such as ``dleft,dright,heading,range@0:cm,range@180:cm,-*4``."""
    columns: list[Column] = []
    for word in text.split(","):
        name, _, count = word.strip().partition("*")
        if count and not re.fullmatch(r"[1-9]\d{0,2}", count):
            raise InputError(option, f"{word.strip()!r} is no number of columns", remedy="write range*24, say")
        columns += [_parsed(name.strip(), option)] * int(count or 1)
    return tuple(columns)


def _parsed(word: str, option: str) -> Column:
    name, _, unit = word.partition(":")
    name, _, direction = name.partition("@")
    if name not in set(Role):
        raise UnknownNameError(f"column in {option}", name, known=[role.value for role in Role])
    known = _UNITS_OF.get(Role(name), ("none",))
    if unit and unit not in known:
        raise InputError(option, f"{unit!r} is no unit of {name!r}", remedy=f"write one of {', '.join(known)}")
    if not re.fullmatch(r"(range@-?\d+(\.\d+)?)?", f"{name}@{direction}" if direction else ""):
        raise InputError(option, f"{word!r} is no range with a direction", remedy="write range@90, say, in degrees")
    return Column(role=Role(name), unit=unit, yaw=math.radians(float(direction)) if direction else None)


def columns_named(names: Sequence[str]) -> tuple[Column, ...]:
    """Return what columns of these names hold; what has no known name is ignored."""
    columns = [_named(name) for name in names]
    roles = {column.role for column in columns}
    if not roles & {Role.HEADING, Role.RANGE} and {Role.X, Role.Y} <= roles:
        # Where x and y are logged alone, theta is the heading.
        columns = _renamed(columns, old=Role.ANGLE, new=Role.HEADING)
    if not roles & {Role.ANGLE, Role.X}:
        # A heading without a position is the direction in which the sensor was turned.
        columns = _renamed(columns, old=Role.HEADING, new=Role.ANGLE)
    return tuple(columns)


def _renamed(columns: Sequence[Column], *, old: Role, new: Role) -> list[Column]:
    return [replace(column, role=new) if column.role is old else column for column in columns]


def spelled(columns: Sequence[Column]) -> str:
    """Write columns as ``--columns`` has them."""
    words = []
    for column in columns:
        yaw = "" if column.yaw is None else f"@{math.degrees(column.yaw):g}"
        words.append(f"{column.role}{yaw}{f':{column.unit}' if column.unit else ''}")
    counts = ((word, len([*group])) for word, group in groupby(words))
    return ",".join(word if count == 1 else f"{word}*{count}" for word, count in counts)


def _named(name: str) -> Column:
    """Read a name such as ``distance_cm``, ``Angle (deg)`` or ``bearing_deg_cw``."""
    words = [word for word in re.split(r"[\s_/()\[\].\-]+", name.strip().strip('"').lower()) if word]
    units = []
    while len(words) > 1 and (unit_of(words[-1]) or words[-1] in ("cw", "ccw")):
        units.append(words.pop())
    plain = " ".join(words)
    role = Role.RANGE if _NUMBERED.fullmatch(plain) else _ROLES.get(plain, Role.IGNORED)
    # A column named "ms" or "cm" states its unit by its name.
    known = [unit_of(word) for word in (*units, plain)]
    unit = next((each for each in known if each in _UNITS_OF.get(role, ())), "")
    return Column(role=role, unit=unit, is_clockwise="cw" in units, is_sensor=plain in _SENSOR_NAMES)
