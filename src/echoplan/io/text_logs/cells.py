"""Cells: a number with a label before it or a unit behind it, or a word for a reading that is missing."""

import math
import re
from dataclasses import dataclass

from echoplan.io.text_logs.options import MICROSECONDS

__all__ = ["Cell", "labelled_cells", "read_cell", "unit_of"]

_NUMBER = {
    ".": r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][-+]?\d+)?",
    ",": r"[-+]?\d+(?:,\d+)?",
}
# A zero before another digit may show two lines that ran together: "8,0" and "10,0.0".
_PADDED = re.compile(r"[-+]?0\d")
# In German "Grad" are degrees; a gon has the name "grad" in options only.
_UNITS = {
    "m": ("m", "meter", "meters", "metre", "metres"),
    "cm": ("cm", "cms", "centimeters", "centimetres"),
    "mm": ("mm", "millimeters", "millimetres"),
    "in": ("in", "inch", "inches", '"'),
    "ft": ("ft", "feet"),
    MICROSECONDS: ("us", "µs", "μs", "usec", "microseconds", "micros"),
    "ms": ("ms", "msec", "millis", "milliseconds"),
    "s": ("s", "sec", "seconds"),
    "deg": ("deg", "degs", "degree", "degrees", "grad", "°", "º"),
    "rad": ("rad", "radians"),
    "c": ("c", "°c"),
}
_UNIT_NAMES = {word: unit for unit, words in _UNITS.items() for word in words}
_UNIT = "|".join(sorted(map(re.escape, _UNIT_NAMES), key=len, reverse=True))
_CELL = {decimal: re.compile(rf"({number})\s*({_UNIT})?\.?", re.IGNORECASE) for decimal, number in _NUMBER.items()}
# What programs print where no echo came; "nan" is a faulty reading (REP 117).
_NO_ECHO = ("", "none", "null", "inf", "infinity", "-", "--", "n/a", "na", "timeout", "out of range", "no echo", "oor")
_WORDS = {**dict.fromkeys(_NO_ECHO, math.inf), "nan": math.nan, "-inf": -math.inf}
_WORD = "|".join(sorted((re.escape(word) for word in _WORDS if word), key=len, reverse=True))
_LABELLED = {
    decimal: re.compile(
        r"\s*([^\W\d][^:=,;|]*?)\s*[:=]\s*"
        rf"((?:{number}\s*(?:{_UNIT})?(?![\w°])|{_WORD})?)\s*(?:[,;|]\s*|$|(?=[^\W\d]))",
        re.IGNORECASE,
    )
    for decimal, number in _NUMBER.items()
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Cell:
    """A number as it was printed, perhaps padded with zeros; a word for a missing reading has no decimals."""

    value: float
    unit: str = ""
    decimals: int | None = None
    is_padded: bool = False


def read_cell(text: str, *, decimal: str) -> Cell | None:
    """Read one cell; None if it is neither a number nor a word for a missing one."""
    word = text.strip()
    match = _CELL[decimal].fullmatch(word)
    if match is None:
        value = _WORDS.get(word.lower())
        return None if value is None else Cell(value=value)
    number = match[1].replace(",", ".")
    _, _, fraction = number.partition(".")
    return Cell(
        value=float(number),
        unit=unit_of(match[2]) if match[2] else "",
        decimals=len(fraction),
        is_padded=bool(_PADDED.match(number)),
    )


def unit_of(word: str) -> str:
    """Return the unit that a word names, or an empty text."""
    return _UNIT_NAMES.get(word.lower(), "")


def labelled_cells(text: str, *, decimal: str) -> tuple[tuple[str, ...], list[str]] | None:
    """Split a line such as ``Angle: -90  Distance: 59.7 cm`` into names and cells; None if it is anything else."""
    names: list[str] = []
    cells: list[str] = []
    start = 0
    while start < len(text.rstrip()):
        match = _LABELLED[decimal].match(text, start)
        if match is None or match.end() == start:
            return None
        names.append(match[1].strip().lower())
        cells.append(match[2])
        start = match.end()
    return (tuple(names), cells) if names else None
