"""Dialect: what separates the cells of a line, and what the decimals of a number."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.io.text_logs.cells import labelled_cells, read_cell
from echoplan.io.text_logs.lines import Line

__all__ = ["Dialect", "Row", "recognise_dialect", "rows_of"]

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
        cells = [cell.strip() for cell in text.split(self.separator)] if self.separator else [text.strip()]
        # A quotation mark behind a number alone means inches.
        cells = [cell[1:-1].strip() if re.fullmatch(r"\"[^\"]*\"|'[^']*'", cell) else cell for cell in cells]
        return cells[:-1] if self.is_trailing and not cells[-1] else cells


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A line in cells, with the labels that stood before them."""

    line: Line
    cells: tuple[str, ...]
    names: tuple[str, ...] = ()


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
            rows[-1] = replace(rows[-1], cells=rows[-1].cells + row.cells, names=rows[-1].names + row.names)
        else:
            rows.append(row)
    return rows


def _row(line: Line, dialect: Dialect) -> Row:
    if ":" in line.text or "=" in line.text:
        labelled = labelled_cells(line.text, decimal=dialect.decimal) or labelled_cells(line.text, decimal=",")
        if labelled:
            names, cells = labelled
            return Row(line=line, cells=tuple(cells), names=names)
    return Row(line=line, cells=tuple(dialect.split(line.text)))


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
