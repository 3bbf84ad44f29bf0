"""Layout: which lines are readings, which are places, and what their numbers mean."""

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import InputError
from echoplan.io.text_logs.columns import Column, Role, columns_named, parse_columns, spelled
from echoplan.io.text_logs.dialect import Dialect, Row
from echoplan.io.text_logs.facts import Fact, Origin
from echoplan.io.text_logs.options import LogOptions

__all__ = ["POSE_ROLES", "Layout", "recognise_layout"]

# How two kinds of rows differ: the labels before their numbers, or how many cells they have.
Key = tuple[str, ...] | int

POSE_ROLES = (Role.X, Role.Y, Role.HEADING)
_PLACE = tuple(Column(role=role) for role in POSE_ROLES)
_ANGLE, _RANGE = Column(role=Role.ANGLE), Column(role=Role.RANGE)
# Rows without names, by how many numbers they have: one sensor on a servo, or four, each a quarter turn farther left.
_BARE = {2: (_ANGLE, _RANGE), 5: (_ANGLE, *[_RANGE] * 4)}
# Share of equal steps between angles from which a column is one of angles.
_REGULAR = 0.8
# Different distances of each sensor that is not dead, for each different angle: a temperature has fewer values.
_FEWEST_DIFFERENT = 0.2
# Part of a step by which rounding changes it: 5.5555 and 5.5556 are one size.
_ROUNDING = 0.02
# Numbers of a line that an example of ``--columns`` names one by one.
_MOST_NAMED = 10
# Lines before the header: what a board prints when it starts.
_PREAMBLE = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class Layout:
    """Columns of each kind of row, by its labels or its number of cells; header lines; how the columns are known."""

    columns: Mapping[Key, tuple[Column, ...]]
    origin: Origin
    headers: frozenset[tuple[str, ...]] = field(default=frozenset())

    def of(self, row: Row) -> tuple[Column, ...]:
        """Return the columns of a row; none if it is of no known kind."""
        return self.columns.get(row.names or len(row.cells), ())

    @property
    def readings(self) -> tuple[Column, ...]:
        """Columns of the rows that hold readings."""
        return next(columns for columns in self.columns.values() if _has_range(columns))

    def with_readings(self, columns: tuple[Column, ...]) -> "Layout":
        """Return the layout with other columns of the rows that hold readings."""
        changed = {key: columns if each == self.readings else each for key, each in self.columns.items()}
        return replace(self, columns=changed)

    @property
    def fact(self) -> Fact:
        """The columns as ``--columns`` has them."""
        kinds = [spelled(columns) for columns in self.columns.values() if columns != _PLACE]
        option = f"--columns {spelled(self.readings)}"
        return Fact(subject="columns", value="; ".join(kinds), origin=self.origin, option=option)


def recognise_layout(rows: Sequence[Row], dialect: Dialect, *, options: LogOptions, source: str) -> Layout:
    """Return what the numbers of the rows mean; ask for ``--columns`` where the log does not say."""
    numeric = [*filter(_is_numeric, rows)]
    layout = _given(rows, options, source=source) if options.columns else _labels(rows)
    if not any(map(_has_range, layout.columns.values())) and not options.columns:
        layout = _header(rows, numeric, dialect=dialect, source=source) or _unnamed(
            rows, numeric, options=options, source=source
        )
    _check(layout, source)
    _check_sensors(rows, layout, source=source)
    # Lines of three numbers between readings are places, unless three numbers are a reading.
    places: dict[Key, tuple[Column, ...]] = {len(row.cells): _PLACE for row in numeric if len(row.cells) == len(_PLACE)}
    return replace(layout, columns={**places, **layout.columns})


def _unnamed(rows: Sequence[Row], numeric: Sequence[Row], *, options: LogOptions, source: str) -> Layout:
    """Recognise rows by their numbers alone; refuse labels that name no distance."""
    labels = Counter(row.names for row in rows if row.names)
    if labels.total() > len(numeric):
        names = labels.most_common(1)[0][0]
        problem = f"none of its labels names a distance: {', '.join(map(repr, names))}"
        remedy = f"say what they are, such as --columns {'-,' * (len(names) - 1)}range"
        raise InputError(source, problem, remedy=remedy)
    return _bare(numeric, options=options, source=source)


def _given(rows: Sequence[Row], options: LogOptions, *, source: str) -> Layout:
    """Apply ``--columns`` to the rows that have so many cells; to labelled ones only if there are no others."""
    columns = parse_columns(options.columns, option="--columns")
    found = [row for row in rows if len(row.cells) == len(columns)]
    if not found:
        common = Counter(len(row.cells) for row in rows).most_common(1)[0][0]
        problem = f"--columns names {len(columns)} columns, but no line has so many"
        raise InputError(source, problem, remedy=f"name {common}, with - for a column that is not needed")
    keys = Counter[Key](row.names or len(row.cells) for row in found)
    key = len(columns) if len(columns) in keys else keys.most_common(1)[0][0]
    headers = frozenset(row.cells for row in found if _are_words(row))
    return Layout(columns={key: columns}, origin=Origin.OPTION, headers=headers)


def _header(rows: Sequence[Row], numeric: Sequence[Row], *, dialect: Dialect, source: str) -> Layout | None:
    """Recognise rows by a header that names a range; None if there is none, or what a board says when it starts."""
    usual = int(np.bincount([0, *(len(row.cells) for row in numeric)]).argmax())
    for row in filter(_are_words, rows[:_PREAMBLE]):
        columns = columns_named(row.cells)
        roles = [column.role for column in columns]
        known = len(roles) - roles.count(Role.IGNORED)
        # "Sonar ready" has as many words as a line has numbers.
        is_table = dialect.separator != " "
        is_most = 2 * known > len(roles) - row.cells.count("")
        is_understood = any((is_most, is_table and Role.ANGLE in roles))
        if Role.RANGE in roles and any((is_understood, is_table and len(roles) == usual)):
            numbers = _numbers(numeric, width=len(columns))
            _check_header(row, columns, numbers=numbers, is_understood=is_understood, source=source)
            return Layout(columns={len(columns): columns}, origin=Origin.STATED, headers=frozenset([row.cells]))
    return None


def _check_header(
    row: Row, columns: Sequence[Column], *, numbers: FloatArray, is_understood: bool, source: str
) -> None:
    """Refuse a header of unknown names, and an unknown one over numbers, shape (n, width), that look like angles."""
    example, has_angle = [*columns], Role.ANGLE in {column.role for column in columns}
    for place, column in enumerate(columns):
        is_unknown = column.role is Role.IGNORED and not column.is_sensor and row.cells[place] != ""
        if is_unknown and not has_angle and len(numbers) > 1 and _is_regular(numbers[:, place]):
            example[place], has_angle = _ANGLE, True
    if example != [*columns] or not is_understood:
        problem = f"its header {row.line.text.strip()!r} has names that are not known"
        remedy = f"name the columns, such as --columns {spelled(example)}, with - for one that is not needed"
        raise InputError(source, problem, remedy=remedy)


def _check_sensors(rows: Sequence[Row], layout: Layout, *, source: str) -> None:
    """Refuse readings of several sensors one below the other; a number that is new in each line counts lines."""
    for place, column in enumerate(layout.readings):
        if column.is_sensor:
            found = [row.cells[place] for row in rows if layout.of(row) == layout.readings]
            names = sorted({*found} - {header[place] for header in layout.headers if len(header) > place})
            if 1 < len(names) <= len(found) / 2:
                problem = (
                    f"its lines are of {len(names)} sensors, {', '.join(map(repr, names[:4]))}, one below the other"
                )
                remedy = "write one column of distances for each sensor, or convert one log for each"
                raise InputError(source, problem, remedy=remedy)


def _labels(rows: Sequence[Row]) -> Layout:
    """Recognise rows by labels of readings and of places; without columns if no label names a range.

    A damaged line has other labels, so that only the commonest count.
    """
    readings: dict[Key, tuple[Column, ...]] = {}
    places: dict[Key, tuple[Column, ...]] = {}
    for names, _ in Counter(row.names for row in rows if row.names).most_common():
        columns = columns_named(names)
        if _has_range(columns):
            readings = readings or {names: columns}
        elif {column.role for column in columns} == set(POSE_ROLES):
            places = places or {names: columns}
    return Layout(columns=readings | places, origin=Origin.STATED)


def _bare(rows: Sequence[Row], *, options: LogOptions, source: str) -> Layout:
    """Recognise rows of numbers alone by how many there are, and by the column that goes up and down as angles do."""
    widths = Counter(len(row.cells) for row in rows)
    if not widths:
        remedy = 'print lines "angle,distance", and "x,y,heading" before each sweep'
        raise InputError(source, "there is no line of numbers in it", remedy=remedy)
    width = widths.most_common(1)[0][0]
    if options.angles is not None:
        return Layout(columns={width: (_RANGE,) * width}, origin=Origin.OPTION)
    places, width = widths[len(_PLACE)], max(_BARE, key=widths.__getitem__)
    if widths[width] < max(places, widths.total() - places - widths[width]):
        width = widths.most_common(1)[0][0]
        raise _unknown_columns(_numbers(rows, width=width), source)
    numbers = _numbers(rows, width=width)
    _check_angles(numbers, source)
    # Numbers of lines look like the angles of one sweep from 0 or 1 in steps of 1, if no option says they are.
    counts = places == 0 and numbers[0, 0] in (0.0, 1.0) and bool((np.diff(numbers[:, 0]) == 1.0).all())
    is_stated = options.center is not None or options.clockwise or bool(options.angle_unit)
    origins = {True: Origin.GUESSED, False: Origin.SEEN}
    return Layout(columns={width: _BARE[width]}, origin=origins[counts and not is_stated])


def _check_angles(numbers: FloatArray, source: str) -> None:
    """Refuse readings whose first number does not go up and down as angles do, shape (n, width)."""
    width, regular = numbers.shape[1], [_is_regular(column) for column in numbers.T]
    angles = len(np.unique(numbers[:, 0]))
    distances = [len(np.unique(column)) for column in numbers.T[2:] if column.any()]
    if min(distances, default=angles) < _FEWEST_DIFFERENT * angles:
        raise _unknown_columns(numbers, source)
    if width == 2 and regular == [False, True]:
        problem = "the second number of a line goes up and down in steps as an angle does, the first does not"
        raise InputError(source, problem, remedy="give --columns range,angle if it is the angle, else angle,range")
    if not regular[0]:
        problem = f"none of the {width} numbers of a line goes up and down in steps as an angle does"
        example = spelled(_BARE[width])
        remedy = f"name them: --columns {example} if the first is, or --decimal-comma if 12,5 is one number"
        raise InputError(source, problem, remedy=remedy)


def _unknown_columns(numbers: FloatArray, source: str) -> InputError:
    """Ask for ``--columns``, with an example for these numbers, shape (n, width)."""
    width, last = numbers.shape[1], numbers[:, -1]
    regular = [_is_regular(column) for column in numbers.T]
    if width == 1:
        problem = "each line is one number; the angles are not in the log"
        return InputError(source, problem, remedy='give the first angle and the step: --angles "-90 2"')
    if width == 3 and regular[0] and np.isin(last, range(10)).mean() > 0.9 and np.ptp(last) > 2.0:
        problem = 'lines such as "-90,59,7" have a comma between numbers and in numbers, which look the same'
        return InputError(source, problem, remedy="print a decimal point, or a semicolon between numbers")
    if width > _MOST_NAMED:
        remedy = f"name them: --columns range*{width} if all are distances, -*{width - 1},range if the last is one"
        return InputError(source, f"its lines have {width} numbers, and nothing says what they are", remedy=remedy)
    guess = [Role.IGNORED] * width
    angle = regular.index(True) if any(regular) else 0
    guess[angle], guess[0 if angle else 1] = Role.ANGLE, Role.RANGE
    problem = f"its lines have {width} numbers, and nothing says what they are"
    return InputError(source, problem, remedy=f"name them, such as --columns {','.join(guess)}")


def _is_regular(numbers: FloatArray) -> bool:
    """Whether most steps between successive numbers are of one size that is not zero."""
    steps = np.abs(np.diff(numbers))
    if not len(steps):
        return True
    step = np.median(steps)
    return bool(step > 0.0 and np.mean(np.abs(steps - step) <= _ROUNDING * step) >= _REGULAR)


def _numbers(rows: Sequence[Row], *, width: int) -> FloatArray:
    """Numbers of the rows of one width, shape (n, width); 0 for words in their place."""
    cells = [row.numbers for row in rows if len(row.numbers) == width]
    values = np.array([[cell.value if cell else 0.0 for cell in each] for each in cells])
    finite: FloatArray = np.where(np.isfinite(values), values, 0.0)
    return finite


def _is_numeric(row: Row) -> bool:
    """Whether a row is one of numbers without labels."""
    return not row.names and None not in row.numbers and any(cell.decimals is not None for cell in row.numbers if cell)


def _are_words(row: Row) -> bool:
    """Whether a row may be a header; the index of a table has no name."""
    return not row.names and any(row.cells) and all(re.search(r"[^\W\d]|^$", cell) for cell in row.cells)


def _has_range(columns: Sequence[Column]) -> bool:
    return any(column.role is Role.RANGE for column in columns)


def _check(layout: Layout, source: str) -> None:
    """Refuse columns without distances, and two columns for what there can be only one of."""
    if not any(map(_has_range, layout.columns.values())):
        raise InputError(source, "no column holds distances", remedy="name one: --columns angle,range, say")
    for columns in layout.columns.values():
        roles = Counter(column.role for column in columns if column.role not in (Role.RANGE, Role.IGNORED))
        role, count = roles.most_common(1)[0] if roles else (Role.IGNORED, 0)
        if count > 1:
            remedy = "name them with --columns, and - for those that are not needed"
            raise InputError(source, f"{count} columns hold {role.value!r}", remedy=remedy)
