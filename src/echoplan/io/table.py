"""Tables of numbers in CSV, read in chunks: one row a line, and a fault is reported with its line and column."""

import csv
import difflib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any, Self, TextIO

import numpy as np
from numpy.typing import NDArray

from echoplan.errors import InputError
from echoplan.io.files import open_text
from echoplan.io.kinds import Kind

__all__ = ["Rows", "Table"]

# Rows that are held as text at a time, about 40 MB.
_CHUNK = 65_536
# As long as Python's reader of CSV lets a field be; a row of ten numbers has 200.
_LONGEST_LINE = 131_072


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Rows:
    """Some rows of a table.

    Parameters
    ----------
    path : Path
        The file.
    first : int
        How many rows come before them.
    data : structured ndarray, shape (n,)
        The known columns by their names.
    """

    path: Path
    first: int
    data: NDArray[np.void]

    def refusal(self, row: int, column: str, problem: str, *, remedy: str) -> InputError:
        """Make the error that blames one field.

        Parameters
        ----------
        row : int
            Index into ``data``.
        column : str
            Name of the column.
        problem, remedy : str
            What is wrong and what to do about it.

        Returns
        -------
        InputError
            To be raised.
        """
        return _refusal(self.path, self.first + row, column, problem=problem, remedy=remedy)


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A CSV file of which some columns are known.

    Parameters
    ----------
    path : Path
        The file.
    header : tuple of str
        Names of all its columns, in their order.
    columns : mapping
        The known ones, each with its kind; all others are passed over.
    count : int, optional
        How many rows to read; None for all.
    """

    path: Path
    header: tuple[str, ...]
    columns: Mapping[str, Kind]
    count: int | None = None

    @classmethod
    def open(
        cls, path: Path, columns: Mapping[str, Kind], *, optional: Sequence[str] = (), count: int | None = None
    ) -> Self:
        """Read the header of a table.

        Parameters
        ----------
        path : Path
            The file.
        columns : mapping
            Kind of each column by its name.
        optional : sequence of str, optional
            Columns that may be missing.
        count : int, optional
            How many rows to read; None for all.

        Returns
        -------
        Table
            The table; its rows are not yet read.

        Raises
        ------
        InputError
            If the file cannot be read, is empty or lacks a column.
        """
        required = [name for name in columns if name not in optional]
        with open_text(path) as file:
            header = _header(path, *next(_filled(path, file), (0, "")), required)
        known = {name: columns[name] for name in header if name in columns}
        return cls(path=path, header=header, columns=known, count=count)

    def only(self, name: str) -> "Table":
        """Return the same table with all columns but one passed over."""
        return replace(self, columns={name: self.columns[name]})

    def __iter__(self) -> Iterator[Rows]:
        """Yield the rows in chunks that fit the memory.

        Raises
        ------
        InputError
            If a field cannot be read, or there is no row at all.
        """
        first = 0
        with open_text(self.path) as file:
            stop = None if self.count is None else 1 + self.count
            lines = (line for _, line in islice(_filled(self.path, file), 1, stop))
            while chunk := list(islice(lines, _CHUNK)):
                yield Rows(path=self.path, first=first, data=self._parse(chunk, first))
                first += len(chunk)
        if not first:
            raise InputError(self.path, "it holds a header but no rows", remedy="record again")

    def _parse(self, lines: list[str], first: int) -> NDArray[np.void]:
        rows = [self._fields(line, first + index) for index, line in enumerate(lines)]
        columns = dict(zip(self.header, zip(*rows, strict=True), strict=True))
        data = np.empty(len(rows), dtype=[(name, kind.stored) for name, kind in self.columns.items()])
        for name in self.columns:
            data[name] = self._parse_column(name, columns[name], first)
        return data

    def _fields(self, line: str, row: int) -> list[str]:
        try:
            fields = _split(line)
        except csv.Error as error:
            remedy = "close the quotation marks, or delete the row"
            raise _refusal(self.path, row, problem=f"the row is no CSV: {error}", remedy=remedy) from error
        if len(fields) != len(self.header):
            remedy = "complete it, or delete it if the recording was cut off here"
            if len(fields) > len(self.header):
                remedy = "write one field a column, and decimal points, not commas"
            problem = f"the row has {len(fields)} fields, but the header {len(self.header)}"
            raise _refusal(self.path, row, problem=problem, remedy=remedy)
        return fields

    def _parse_column(self, name: str, fields: Sequence[str], first: int) -> NDArray[Any]:
        kind, texts = self.columns[name], [field.strip() for field in fields]
        try:
            return kind.read(texts)
        except (ValueError, ArithmeticError) as error:
            faults = ((row, kind.fault(text)) for row, text in enumerate(texts, start=first))
            row, problem = next((row, problem) for row, problem in faults if problem)
            raise _refusal(self.path, row, name, problem=problem, remedy=kind.remedy) from error


def _filled(path: Path, file: TextIO) -> Iterator[tuple[int, str]]:
    """Yield the lines that are not blank, each with its number."""
    for number, line in enumerate(iter(partial(file.readline, _LONGEST_LINE + 1), ""), start=1):
        if len(line) > _LONGEST_LINE:
            problem = f"it is longer than {_LONGEST_LINE} characters"
            raise InputError(path, problem, place=f"line {number}", remedy="write one row a line")
        if not line.isspace():
            yield number, line.rstrip("\n")


def _split(line: str) -> list[str]:
    # Without quotation marks only commas separate, and that is three times as fast.
    return next(csv.reader([line], skipinitialspace=True, strict=True)) if '"' in line else line.split(",")


def _header(path: Path, number: int, line: str, required: Sequence[str]) -> tuple[str, ...]:
    if not number:
        raise InputError(path, "it is empty", remedy=f"begin it with the header {','.join(required)}")
    try:
        header = tuple(name.strip() for name in _split(line))
    except csv.Error as error:
        remedy = "close the quotation marks"
        raise InputError(path, f"the header is no CSV: {error}", place=f"line {number}", remedy=remedy) from error
    for problem, remedy in _header_faults(line, header, required):
        raise InputError(path, problem, place=f"line {number}", remedy=remedy)
    return header


def _header_faults(line: str, header: Sequence[str], required: Sequence[str]) -> Iterator[tuple[str, str]]:
    if len(header) == 1 and (separator := re.search(r"[;\t|]", line)):
        yield f"columns are separated by {separator[0]!r}", "separate them by commas, with decimal points"
    if all(re.fullmatch(r"[-+\d.e]+", name) for name in header):
        yield "there is no header", f"begin the file with {','.join(required)}"
    for name in required:
        if header.count(name) > 1:
            yield f"the column {name!r} occurs twice", "rename or delete one of them"
        if name not in header:
            yield f"the column {name!r} is missing", _remedy_for_missing(name, header, required)


def _remedy_for_missing(name: str, header: Sequence[str], required: Sequence[str]) -> str:
    strangers = {other.lower(): other for other in header if other not in required}
    near = difflib.get_close_matches(name, strangers, n=1)
    return f"rename {strangers[near[0]]!r} if that is it" if near else f"the header must have {','.join(required)}"


def _refusal(path: Path, row: int, column: str = "", *, problem: str, remedy: str) -> InputError:
    with open_text(path) as file:
        line_number, _ = next(islice(_filled(path, file), row + 1, None))
    place = f"line {line_number}, column {column}" if column else f"line {line_number}"
    return InputError(path, problem, place=place, remedy=remedy)
