"""What the fields of a table hold: how a whole column is read at once, and how one field with care."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from decimal import Decimal
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from echoplan.arrays import BoolArray, IntArray
from echoplan.model.sweep import COLDEST, HOTTEST

__all__ = ["COUNT", "NUMBER", "READING", "SECONDS", "TEMPERATURE", "WHOLE", "Kind"]

Column: TypeAlias = NDArray[Any]

_LATEST_SECOND = 9_000_000_000  # 64 bits of nanoseconds hold a little more


def _as_it_is(column: Column) -> Column:
    return column


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """What the fields of a column hold.

    Parameters
    ----------
    noun : str
        What to call it.
    remedy : str
        What to write where something else stands.
    raw, stored : str
        NumPy types in which the column is read and kept.
    parse : callable
        From the text of one field to its number; raises ``ValueError`` or ``ArithmeticError`` if it is none.
    convert : callable, optional
        From the raw column to the stored one; raises ``ValueError`` where one field needs care.
    allows : callable
        Which numbers may stand there.
    """

    noun: str
    remedy: str
    raw: str
    stored: str
    parse: Callable[[str], float]
    convert: Callable[[Column], Column] = _as_it_is
    allows: Callable[[Column], BoolArray]

    def take(self, raw: Column) -> Column:
        """Take a column as NumPy read it.

        Parameters
        ----------
        raw : ndarray, shape (n,)
            Fields of the type ``raw``.

        Returns
        -------
        ndarray, shape (n,)
            Fields of the type ``stored``.

        Raises
        ------
        ValueError
            If one of them is not plain enough, or not allowed.
        """
        return self._allowed(self.convert(raw))

    def read(self, texts: Iterable[str]) -> Column:
        """Read a column field by field.

        Parameters
        ----------
        texts : iterable of str
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
        return self._allowed(np.array(list(map(self.parse, texts)), dtype=self.stored))

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
            return f"{text!r} is no {self.noun}" if text else "the field is empty"
        return ""

    def _allowed(self, column: Column) -> Column:
        if not self.allows(column).all():
            raise ValueError(self.noun)
        return column


def _parse_whole(text: str) -> int:
    number = Decimal(text)
    if number % 1:
        raise ValueError(text)
    return int(number)


def _parse_seconds(text: str) -> int:
    return round(Decimal(text) * 1_000_000_000)


def _parse_measured(text: str) -> float:
    return float(text or "nan")


def _convert_seconds(texts: Column) -> Column:
    # Through floats, the nanoseconds of a present-day date would be lost.
    wholes, _, fractions = np.strings.partition(texts, b".")
    digits = np.strings.str_len(wholes), np.strings.str_len(fractions)
    if not (np.strings.isdigit(wholes) & (digits[0] <= 10) & (digits[1] <= 9)).all():
        raise ValueError("a time that is not written plainly")
    seconds = wholes.astype(np.int64)
    if (seconds > _LATEST_SECOND).any():
        raise ValueError("a time that nanoseconds cannot hold")
    stamps: IntArray = seconds * 1_000_000_000 + np.strings.ljust(fractions, 9, b"0").astype(np.int64)
    return stamps


def _fits_the_memory(numbers: Column) -> BoolArray:
    fits: BoolArray = np.abs(numbers) <= 1_000_000_000 * _LATEST_SECOND
    return fits


def _is_count(numbers: Column) -> BoolArray:
    return _fits_the_memory(numbers) & np.greater_equal(numbers, 0)


def _is_finite(numbers: Column) -> BoolArray:
    finite: BoolArray = np.isfinite(numbers)
    return finite


def _is_temperature(numbers: Column) -> BoolArray:
    temperature: BoolArray = np.isnan(numbers) | ((numbers >= COLDEST) & (numbers <= HOTTEST))
    return temperature


def _is_reading(numbers: Column) -> BoolArray:
    reading: BoolArray = ~(np.isfinite(numbers) & np.less(numbers, 0))
    return reading


SECONDS = Kind(
    noun="time",
    remedy="write seconds, with a decimal point",
    raw="S32",
    stored="i8",
    parse=_parse_seconds,
    convert=_convert_seconds,
    allows=_fits_the_memory,
)
WHOLE = Kind(
    noun="whole number",
    remedy="write a whole number",
    raw="i8",
    stored="i8",
    parse=_parse_whole,
    allows=_fits_the_memory,
)
COUNT = Kind(
    noun="count",
    remedy="write a whole number, 0 or greater",
    raw="i8",
    stored="i8",
    parse=_parse_whole,
    allows=_is_count,
)
NUMBER = Kind(
    noun="number",
    remedy="write a finite number, with a decimal point",
    raw="f8",
    stored="f8",
    parse=float,
    allows=_is_finite,
)
READING = Kind(
    noun="range",
    remedy="write metres with a decimal point, inf for no echo, -inf for too close, nan for a fault",
    raw="f8",
    stored="f8",
    parse=_parse_measured,
    allows=_is_reading,
)
TEMPERATURE = Kind(
    noun="temperature of air",
    remedy="write degrees Celsius with a decimal point, nan or nothing where it was not measured",
    raw="f8",
    stored="f8",
    parse=_parse_measured,
    allows=_is_temperature,
)
