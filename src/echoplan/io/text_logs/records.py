"""Records: readings and places in the order of the log, and the lines that are neither."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.text_logs.cells import Cell
from echoplan.io.text_logs.columns import TIME_UNITS, Column, Role
from echoplan.io.text_logs.dialect import Dialect, Row
from echoplan.io.text_logs.facts import Skipped
from echoplan.io.text_logs.layout import POSE_ROLES, Layout
from echoplan.io.text_logs.options import Place

__all__ = ["Grammar", "Item", "PlaceLine", "Reading", "Records", "items_of", "skipped_line", "with_units"]

# Share of the numbers of a column that must have the same unit beside them; the others are damaged lines.
_WITH_UNIT = 0.9
# Readings at a place by a robot that stops there.
_FEWEST = 3


@dataclass(frozen=True, slots=True, kw_only=True)
class Grammar:
    """How the lines of one file are read."""

    dialect: Dialect
    layout: Layout
    source: str
    # Units beside the numbers of each column of readings; empty where there are none.
    units: tuple[str, ...] = ()

    def units_of(self, columns: Sequence[Column]) -> Sequence[str | None]:
        """Return the units that must stand beside the numbers of columns; None where any may."""
        return self.units if columns == self.layout.readings else [None] * len(columns)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """The numbers of one line, by role, in the units of the log, and its position among all lines of its file."""

    place: str
    text: str
    numbers: Mapping[Role, float]
    cells: tuple[Cell, ...]
    stamp: float | None
    position: int

    @property
    def ranges(self) -> tuple[float, ...]:
        """The distances."""
        return tuple(cell.value for cell in self.cells)

    @property
    def decimals(self) -> set[int]:
        """Numbers of decimals of the distances; a program may write 0 for no echo, and distances with decimals."""
        return {cell.decimals for cell in self.cells if cell.value and cell.decimals is not None}

    @property
    def angle(self) -> float:
        """Angle of the servo; nan if there is none."""
        return self.numbers.get(Role.ANGLE, np.nan)


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceLine:
    """A line that says where the robot stands."""

    place: str
    text: str
    pose: Place
    position: int


Item = Reading | PlaceLine | Skipped


@dataclass(frozen=True, slots=True, kw_only=True)
class Records:
    """All of a log that can be used, in its order; columns of its readings; skipped lines; number of items a file."""

    items: tuple[Reading | PlaceLine, ...]
    columns: tuple[Column, ...]
    skipped: tuple[Skipped, ...]
    lines: int
    counts: tuple[int, ...]

    @property
    def readings(self) -> tuple[Reading, ...]:
        """The readings alone."""
        return tuple(item for item in self.items if isinstance(item, Reading))

    @property
    def files(self) -> tuple[tuple[Reading | PlaceLine, ...], ...]:
        """The items of each file."""
        ends = [*accumulate(self.counts)]
        return tuple(self.items[end - count : end] for count, end in zip(self.counts, ends, strict=True))

    @property
    def is_standing(self) -> bool:
        """Whether the robot stops at its places; one that moves all the time says where it is before each reading."""
        return (len(self.items) - len(self.readings)) * _FEWEST <= len(self.readings)

    @property
    def poses(self) -> FloatArray | None:
        """Places in columns beside the readings, in the units of the log, shape (n, 3); None if there are none."""
        if self.column(Role.X) is None or self.column(Role.Y) is None:
            return None
        return np.array([[reading.numbers.get(role, 0.0) for role in POSE_ROLES] for reading in self.readings])

    def joined(self, other: "Records") -> "Records":
        """Append the records of another file with the same columns."""
        return replace(
            self,
            items=self.items + other.items,
            skipped=self.skipped + other.skipped,
            lines=self.lines + other.lines,
            counts=self.counts + other.counts,
        )

    def column(self, role: Role) -> Column | None:
        """Return the first column of a role."""
        return next((column for column in self.columns if column.role is role), None)

    def unit(self, role: Role) -> str:
        """Return the unit that the log or ``--columns`` states for a role."""
        column = self.column(role)
        return column.unit if column else ""


def items_of(rows: Sequence[Row], grammar: Grammar) -> list[Item]:
    """Turn rows into readings, places, and lines to skip; header lines are left out."""
    return [
        _item(row, grammar, position=position)
        for position, row in enumerate(rows)
        if row.cells not in grammar.layout.headers
    ]


def _item(row: Row, grammar: Grammar, *, position: int) -> Item:
    """Read one row."""
    where, text = f"{grammar.source}, line {row.line.number}", row.line.text.strip()
    columns = grammar.layout.of(row)
    if not columns:
        return skipped_line(where, text, reason="it is neither a reading nor a place")
    pairs = _used_cells(row, columns, grammar=grammar)
    if isinstance(pairs, str):
        return skipped_line(where, text, reason=pairs)
    numbers = {column.role: cell.value for column, cell in pairs}
    if Role.RANGE not in numbers:
        pose = Place(**{str(role): numbers[role] for role in POSE_ROLES})
        return PlaceLine(place=where, text=text, pose=pose, position=position)
    return Reading(
        place=where,
        text=text,
        numbers=numbers,
        cells=tuple(cell for column, cell in pairs if column.role is Role.RANGE),
        stamp=_stamp(numbers, row, columns=columns),
        position=position,
    )


def _used_cells(row: Row, columns: Sequence[Column], *, grammar: Grammar) -> list[tuple[Column, Cell]] | str:
    """Return the cells of a row that have a meaning, or why it has none."""
    pairs = []
    for column, cell, unit in zip(columns, row.numbers, grammar.units_of(columns), strict=True):
        if column.role is Role.IGNORED:
            continue
        reason = _fault(cell, column.role, unit=unit)
        if reason or cell is None:
            return reason
        pairs.append((column, cell))
    return pairs


def _fault(cell: Cell | None, role: Role, *, unit: str | None) -> str:
    """Return why a cell cannot be used; empty if it can."""
    if cell is None or (role is not Role.RANGE and not np.isfinite(cell.value)):
        return "a number is missing or cannot be read"
    if cell.is_padded:
        return "a number begins with zeros, as where two lines ran together"
    is_other_unit = cell.decimals is not None and unit not in (None, cell.unit)
    return "a number has not the unit of the others" if is_other_unit else ""


def _stamp(numbers: Mapping[Role, float], row: Row, *, columns: Sequence[Column]) -> float | None:
    """Return the time of a reading [s]: by a column, or by the serial monitor."""
    if Role.TIME not in numbers:
        return row.line.stamp
    unit = next(column.unit for column in columns if column.role is Role.TIME)
    return TIME_UNITS.get(unit, 1.0) * numbers[Role.TIME]


def with_units(rows: Sequence[Row], grammar: Grammar) -> Grammar:
    """Return the grammar with the units that stand beside the numbers of readings."""
    layout = grammar.layout
    found = [row for row in rows if layout.of(row) == layout.readings and row.cells not in layout.headers]
    named, units = list[Column](), list[str]()
    for index, column in enumerate(layout.readings):
        unit = _common_unit(column, [row.numbers[index] for row in found], source=grammar.source)
        if unit not in ("", column.unit or unit):
            problem = f"numbers of the column {column.role.value!r} are in {unit!r}, not in {column.unit!r} as is said"
            raise InputError(grammar.source, problem, remedy="correct the header or --columns")
        named.append(replace(column, unit=column.unit or unit))
        units.append(unit)
    return replace(grammar, layout=layout.with_readings(tuple(named)), units=tuple(units))


def _common_unit(column: Column, cells: Sequence[Cell | None], *, source: str) -> str:
    """Return the unit beside the numbers of a column, or an empty text."""
    if column.role is Role.IGNORED:
        return ""
    counts = Counter(cell.unit for cell in cells if cell and cell.decimals is not None)
    unit, count = counts.most_common(1)[0] if counts else ("", 0)
    if count < _WITH_UNIT * counts.total():
        names = " and ".join(repr(each) for each in sorted(counts))
        problem = f"the numbers of a column have different units: {names}"
        raise InputError(source, problem, remedy="print one unit a column")
    return unit


def skipped_line(place: str, text: str, *, reason: str) -> Skipped:
    """Return a line that is skipped, without characters that a terminal obeys."""
    return Skipped(place=place, text="".join(each if each.isprintable() else "?" for each in text), reason=reason)
