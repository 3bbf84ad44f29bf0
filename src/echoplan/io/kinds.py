"""What the fields of a table hold: one grammar for each kind of column, and which numbers may stand there."""

import reprlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal
from math import isinf
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from echoplan.arrays import BoolArray
from echoplan.io.units import FARTHEST, LARGEST_ANGLE
from echoplan.model.sweep import COLDEST, HOTTEST

__all__ = ["ANGLE", "COUNT", "NUMBER", "POSITION", "READING", "SECONDS", "TEMPERATURE", "WHOLE", "Kind"]

Column: TypeAlias = NDArray[Any]

_LATEST_SECOND = 9_000_000_000  # 64 bits of nanoseconds hold a little more


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """What the fields of a column hold.

    Parameters
    ----------
    noun : str
        What to call it.
    remedy : str
        What to write where something else stands.
    stored : str
        NumPy type in which the column is kept.
    parse : callable
        From the text of one field to its number; raises ``ValueError`` or ``ArithmeticError`` if it is none.
    allows : callable
        Which numbers may stand there.
    """

    noun: str
    remedy: str
    stored: str
    parse: Callable[[str], float]
    allows: Callable[[Column], BoolArray]

    def read(self, texts: Sequence[str]) -> Column:
        """Read a column.

        Parameters
        ----------
        texts : sequence of str
            The fields without surrounding blanks.

        Returns
        -------
        ndarray, shape (n,)
            Fields of the type ``stored``.

        Raises
        ------
        ValueError or ArithmeticError
            If one of them is something else, or not allowed.
        """
        # Python reads digits of all scripts, and 1_000 as a thousand; a table of numbers holds neither.
        together = "".join(texts)
        if "_" in together or not together.isascii():
            raise ValueError(self.noun)
        column = np.array(list(map(self.parse, texts)), dtype=self.stored)
        if not self.allows(column).all():
            raise ValueError(self.noun)
        return column

    def fault(self, text: str) -> str:
        """Say what is wrong with one field; nothing if all is well.

        Parameters
        ----------
        text : str
            The field without surrounding blanks.

        Returns
        -------
        str
            The problem, ready for an error.
        """
        try:
            self.read([text])
        except (ValueError, ArithmeticError):
            return f"{reprlib.repr(text)} is no {self.noun}" if text else "the field is empty"
        return ""


def _parse_whole(text: str) -> int:
    number = Decimal(text)
    if number % 1:
        raise ValueError(text)
    return int(number)


def _parse_seconds(text: str) -> int:
    seconds = Decimal(text)
    # Decimals reach to 10^999999, and a whole number of so many digits takes its time.
    if abs(seconds) > _LATEST_SECOND:
        raise ValueError(text)
    # Through floats, the nanoseconds of a present-day date would be lost.
    return round(seconds * 1_000_000_000)


def _parse_measured(text: str) -> float:
    number = float(text or "nan")
    if isinf(number) and "inf" not in text.lower():
        raise OverflowError(text)
    return number


def _fits_the_memory(numbers: Column) -> BoolArray:
    fits: BoolArray = np.abs(numbers) <= 1_000_000_000 * _LATEST_SECOND
    return fits


SECONDS = Kind(
    noun="time",
    remedy="write seconds, with a decimal point",
    stored="i8",
    parse=_parse_seconds,
    allows=_fits_the_memory,
)
WHOLE = Kind(
    noun="whole number",
    remedy="write a whole number",
    stored="i8",
    parse=_parse_whole,
    allows=_fits_the_memory,
)
COUNT = Kind(
    noun="count",
    remedy="write a whole number, 0 or greater",
    stored="i8",
    parse=_parse_whole,
    allows=lambda numbers: _fits_the_memory(numbers) & np.greater_equal(numbers, 0),
)
NUMBER = Kind(
    noun="number",
    remedy="write a finite number, with a decimal point",
    stored="f8",
    parse=float,
    allows=np.isfinite,
)
POSITION = Kind(
    noun="number",
    remedy="write a finite number of metres, with a decimal point",
    stored="f8",
    parse=float,
    # In whatever unit rig.toml names, millimetres at the finest.
    allows=lambda numbers: np.abs(numbers) <= 1000 * FARTHEST,
)
ANGLE = Kind(
    noun="number",
    remedy=f"write a finite number of radians, with a decimal point, at most {LARGEST_ANGLE:.0f}",
    stored="f8",
    parse=float,
    allows=lambda numbers: np.abs(numbers) <= LARGEST_ANGLE,
)
READING = Kind(
    noun="range",
    remedy="write metres with a decimal point, inf for no echo, -inf for too close, nan for a fault",
    stored="f8",
    parse=_parse_measured,
    allows=lambda numbers: ~(np.isfinite(numbers) & np.less(numbers, 0)),
)
TEMPERATURE = Kind(
    noun="temperature of air",
    remedy="write degrees Celsius with a decimal point, nan or nothing where it was not measured",
    stored="f8",
    parse=_parse_measured,
    allows=lambda numbers: np.isnan(numbers) | ((numbers >= COLDEST) & (numbers <= HOTTEST)),
)
