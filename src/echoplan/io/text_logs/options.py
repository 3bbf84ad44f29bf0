"""What a person states about a text log, as the command line has it."""

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from echoplan.arrays import checked_number
from echoplan.errors import InputError, UnknownNameError
from echoplan.io.text_logs.decoding import read_lines
from echoplan.model import UNITS, Heading, Rig

__all__ = [
    "ANGLE_UNITS",
    "MICROSECONDS",
    "LogOptions",
    "Place",
    "angle_unit",
    "length_unit",
    "parse_angles",
    "parse_heading",
    "parse_length",
    "parse_place",
    "read_places",
]

# Radians in each unit of angle that may be named.
ANGLE_UNITS = {"deg": math.pi / 180.0, "rad": 1.0, "grad": math.pi / 200.0}
# The unit of the time between ping and echo, which a sketch may print instead of a distance.
MICROSECONDS = "us"


@dataclass(frozen=True, slots=True, kw_only=True)
class Place:
    """Where the robot stood, in the units and with the headings of the log.

    Parameters
    ----------
    x, y : float
        Position.
    heading : float
        Direction.
    """

    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LogOptions:
    """How a text log is to be read; what is left out is read from the log, or has a default.

    Parameters
    ----------
    columns : str, optional
        Roles of the columns, such as ``"angle,range,-"``.
    angle_unit, heading_unit : str, optional
        ``"deg"``, ``"rad"``, ``"grad"``, or degrees per count, of the sensor's angles and of headings.
    range_unit, position_unit : str, optional
        ``"m"``, ``"cm"``, ``"mm"``, ``"in"`` or ``"ft"``; of ranges also ``"us"``, microseconds there and back.
    center : float, optional
        Angle that looks straight ahead, in the unit of angles.
    clockwise : bool, optional
        Whether the angles of the sensor grow clockwise seen from above.
    heading : Heading, optional
        How headings are counted.
    no_echo : tuple of float, optional
        Readings that mean no echo; None to recognise them.
    places : tuple of Place, optional
        Where the robot stood, for logs without places: one for all, one a file, or one a sweep.
    angles : tuple of float, optional
        First angle and step, for logs of plain distances.
    tick : float, optional
        Way of a wheel from one count of its encoder to the next [m].
    wheel_base : float, optional
        Distance between the wheels [m].
    period : float, optional
        Time from one ping to the next where the log has no times [s].
    decimal_comma : bool, optional
        Whether numbers have a decimal comma.
    rig : Rig, optional
        The sensors; None for HC-SR04.

    Raises
    ------
    InvalidValueError
        If the period is not positive.
    """

    columns: str = ""
    angle_unit: str = ""
    heading_unit: str = ""
    range_unit: str = ""
    position_unit: str = ""
    center: float | None = None
    clockwise: bool = False
    heading: Heading | None = None
    no_echo: tuple[float, ...] | None = None
    places: tuple[Place, ...] = field(default=())
    angles: tuple[float, float] | None = None
    tick: float | None = None
    wheel_base: float | None = None
    # As long as hobby projects wait for the echoes of one ping to die away before the next.
    period: float = 0.06
    decimal_comma: bool = False
    rig: Rig | None = None

    def __post_init__(self) -> None:
        checked_number(self.period, name="period", above=0.0)


def angle_unit(text: str, *, option: str) -> float:
    """Return the radians in a unit of angle: a name, or the degrees per count of a stepper."""
    if text in ANGLE_UNITS:
        return ANGLE_UNITS[text]
    try:
        degrees = float(text)
    except ValueError:
        degrees = math.nan
    if not (math.isfinite(degrees) and degrees):
        remedy = f"write {', '.join(ANGLE_UNITS)}, or the degrees per count, such as 1.8"
        raise InputError(option, f"{text!r} is no unit of angle", remedy=remedy)
    return math.radians(degrees)


def length_unit(text: str, *, option: str) -> float:
    """Return the metres in a unit of length: a name, or metres."""
    if text in UNITS:
        return UNITS[text]
    try:
        metres = float(text)
    except ValueError:
        metres = math.nan
    if not (math.isfinite(metres) and metres > 0.0):
        raise InputError(option, f"{text!r} is no unit of length", remedy=f"write {', '.join(UNITS)}, or metres")
    return metres


def parse_place(text: str, *, option: str) -> Place:
    """Read a place as it is written on the command line: x, y and heading between blanks or commas.

    Parameters
    ----------
    text : str
        Such as ``"60 60 30"``.
    option : str
        The option or the line to blame.

    Returns
    -------
    Place
        The place.

    Raises
    ------
    InputError
        If the text is anything else.
    """
    numbers = _numbers(text)
    if len(numbers) != 3:
        raise InputError(option, f"{text!r} is no place", remedy='write x, y and heading, such as "60 60 30"')
    return Place(x=numbers[0], y=numbers[1], heading=numbers[2])


def read_places(words: Sequence[str], path: Path | None) -> tuple[Place, ...]:
    """Read the places of a command line: from repeated options, or from a file with one in each line.

    Parameters
    ----------
    words : sequence of str
        Values of ``--place``.
    path : Path or None
        Value of ``--places``: lines ``x,y,heading``, with or without a name before, comments behind ``#`` and a header.

    Returns
    -------
    tuple of Place
        The places, those of the options first.

    Raises
    ------
    InputError
        If one of them is no place.
    """
    places = [parse_place(word, option="--place") for word in words]
    texts = read_lines(path)[0] if path else []
    for number, text in enumerate(texts, start=1):
        cells = re.split(r"[\s,;]+", text.partition("#")[0].strip())
        is_header = not places and not _numbers(cells[-1])
        if cells != [""] and not is_header:
            places.append(parse_place(" ".join(cells[-3:]), option=f"{path}, line {number}"))
    return tuple(places)


def parse_heading(text: str) -> Heading | None:
    """Read how headings are counted.

    Parameters
    ----------
    text : str
        Value of ``--heading``.

    Returns
    -------
    Heading or None
        The direction; None of an empty text.

    Raises
    ------
    UnknownNameError
        If there is no such direction.
    """
    if text and text not in set(Heading):
        raise UnknownNameError("value of --heading", text, known=[heading.value for heading in Heading])
    return Heading(text) if text else None


def parse_angles(text: str) -> tuple[float, float] | None:
    """Read the first angle and the step.

    Parameters
    ----------
    text : str
        Value of ``--angles``, such as ``"-90 2"``.

    Returns
    -------
    tuple of float or None
        Both; None of an empty text.

    Raises
    ------
    InputError
        If the text is anything else, or the step is zero.
    """
    if not text:
        return None
    numbers = _numbers(text)
    if len(numbers) != 2 or not numbers[1]:
        remedy = 'write the first angle and the step, such as --angles "-90 2"'
        raise InputError("--angles", f"{text!r} is not a first angle and a step", remedy=remedy)
    return numbers[0], numbers[1]


def parse_length(text: str, *, option: str) -> float | None:
    """Read a length with its unit.

    Parameters
    ----------
    text : str
        Such as ``"5mm"`` or ``"15 cm"``.
    option : str
        The option to blame.

    Returns
    -------
    float or None
        The length [m]; None of an empty text.

    Raises
    ------
    InputError
        If it is no positive length, or has no unit.
    """
    if not text:
        return None
    match = re.fullmatch(r"\s*(\d+(?:\.\d+)?|\.\d+)\s*([a-z]+)\s*", text)
    if match is None or match[2] not in UNITS or not float(match[1]):
        raise InputError(option, f"{text!r} is no length", remedy=f"write one with its unit, such as {option} 5mm")
    return float(match[1]) * UNITS[match[2]]


def _numbers(text: str) -> list[float]:
    """Read finite numbers between blanks or commas; none if there is anything else."""
    try:
        numbers = [float(word) for word in re.split(r"[\s,;]+", text.strip())]
    except ValueError:
        return []
    return numbers if all(map(math.isfinite, numbers)) else []
