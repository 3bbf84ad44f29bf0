"""Dialect: what separates the cells of a line, and what the decimals of a number."""

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.errors import InputError
from echoplan.io.text_logs.cells import Cell, labelled_cells, read_cell
from echoplan.io.text_logs.lines import Line

__all__ = ["Dialect", "Row", "check_thousands", "recognise_dialect", "rows_of"]

# In the order of preference where several explain the lines: a blank also lies about other separators.
_SEPARATORS = ("\t", ";", "|", ",", " ", ":")
_SEPARATOR_NAMES = {"\t": "tab", ";": "semicolon", "|": "bar", ",": "comma", " ": "blanks", ":": "colon", "": "none"}
# Lines that are looked at; they are taken from all over the log.
_SAMPLE = 2000
# Share of lines that end in a separator from which it belongs to the line end.
_TRAILING = 0.9


@dataclass(frozen=True, slots=True, kw_only=True)
class Dialect:
    """Separator of cells (empty if each line is one cell), decimal sign, and whether a separator ends every line."""

    separator: str
    decimal: str
    is_trailing: bool = False

    @property
    def name(self) -> str:
        """Both in words."""
        return f"{_SEPARATOR_NAMES[self.separator]}, decimal {'comma' if self.decimal == ',' else 'point'}"

    def split(self, text: str) -> list[str]:
        """Split a line into cells."""
        if self.separator == " ":
            return text.split()
        # A quotation mark behind a number alone means inches.
        cells = [re.sub(r"^(['\"])(.*)\1$", r"\2", cell.strip()).strip() for cell in self._split(text)]
        return cells[:-1] if self.is_trailing and not cells[-1] else cells

    def _split(self, text: str) -> list[str]:
        """Split a line at the separator, except in quotation marks: -90,"59,7" are two cells."""
        if '"' in text and self.separator and len(text) < csv.field_size_limit():
            (cells,) = csv.reader([text], delimiter=self.separator, skipinitialspace=True)
            return cells
        return text.split(self.separator) if self.separator else [text]


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A line in cells, with the labels that stood before them, and what the cells mean; None for words."""

    line: Line
    cells: tuple[str, ...]
    names: tuple[str, ...] = ()
    numbers: tuple[Cell | None, ...] = ()


def recognise_dialect(lines: Sequence[Line], *, decimal_comma: bool) -> Dialect:
    """Return the dialect in which most lines without labels are cells of numbers."""
    rows = [_row(line, Dialect(separator="", decimal=".")) for line in lines[:: max(1, len(lines) // _SAMPLE)]]
    texts = [row.line.text for row in rows if not row.names]
    decimals = (",",) if decimal_comma else (".", ",")
    dialects = [Dialect(separator=each, decimal=decimal) for each in (*_SEPARATORS, "") for decimal in decimals]
    best = max(dialects, key=lambda dialect: _score(dialect, texts))
    best = _with_places(best, texts)
    ends = sum(text.rstrip(" ").endswith(best.separator) for text in texts)
    return replace(best, is_trailing=bool(best.separator.strip()) and ends > _TRAILING * len(texts))


def check_thousands(rows: Sequence[Row], dialect: Dialect, *, source: str) -> None:
    """Refuse numbers in quotation marks such as "1,234", whose comma may separate thousands or decimals."""
    if (dialect.separator, dialect.decimal) != (",", ","):
        return
    cells = [cell for row in rows for cell in row.cells if "," in cell]
    if cells and all(re.fullmatch(r"-?[1-9]\d{0,2},\d{3}", cell) for cell in cells):
        remedy = "write them without it, or give --decimal-comma if it stands before decimals"
        raise InputError(source, f"the comma in numbers such as {cells[0]!r} may separate thousands", remedy=remedy)


def rows_of(lines: Sequence[Line], dialect: Dialect) -> list[Row]:
    """Split all lines; a line of labels before numbers is split at these, and lines of one label each are joined."""
    rows: list[Row] = []
    leader: tuple[str, ...] = ()
    for row in (_row(line, dialect) for line in lines):
        is_one = len(row.names) == 1
        leader = leader or (row.names if is_one else ())
        # "Angle: 10" and below it "Distance: 20 cm" are one reading; each begins with the label that came first.
        is_next = is_one and row.names != leader and bool(rows) and rows[-1].names[:1] == leader
        if is_next and row.names[0] not in rows[-1].names:
            begun = rows[-1]
            rows[-1] = replace(
                begun,
                cells=begun.cells + row.cells,
                names=begun.names + row.names,
                numbers=begun.numbers + row.numbers,
            )
        else:
            rows.append(row)
    return rows


def _row(line: Line, dialect: Dialect) -> Row:
    """Split a line and read its cells."""
    if ":" in line.text or "=" in line.text:
        labelled = labelled_cells(line.text, decimal=dialect.decimal) or labelled_cells(line.text, decimal=",")
        if labelled:
            names, cells = labelled
            # Behind a label it is clear where a number with a decimal comma begins.
            numbers = [read_cell(cell, decimal=dialect.decimal) or read_cell(cell, decimal=",") for cell in cells]
            return Row(line=line, cells=tuple(cells), names=names, numbers=tuple(numbers))
    cells = dialect.split(line.text)
    return Row(line=line, cells=tuple(cells), numbers=tuple(read_cell(each, decimal=dialect.decimal) for each in cells))


def _with_places(dialect: Dialect, texts: Sequence[str]) -> Dialect:
    """Return the dialect of lines of one number, with the separator of the places that may stand between them."""
    if dialect != Dialect(separator="", decimal="."):
        return dialect
    others = [replace(dialect, separator=separator) for separator in _SEPARATORS[:-1]]
    # Of three numbers the score of a line is 1.
    places = [sum(len(other.split(text)) == 3 and _score(other, [text]) == 1.0 for text in texts) for other in others]
    return others[int(np.argmax(places))] if any(places) else dialect


def _score(dialect: Dialect, texts: Sequence[str]) -> float:
    """Count the lines that are all numbers; a line that is half so counts half, for columns of words.

    A line of one cell counts half, too: "59,7" is rather two cells, and the layout asks what they are.
    """
    score = 0.0
    for text in texts:
        cells = dialect.split(text)
        numbers = sum(read_cell(cell, decimal=dialect.decimal) is not None for cell in cells)
        is_possible = len(cells) > 1 or not dialect.separator
        weight = 1.0 if numbers == len(cells) > 1 else 0.5
        score += weight * is_possible * (2 * numbers >= len(cells))
    return score
