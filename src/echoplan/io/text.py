"""Tidy text: TOML and JSON that people like to read and programs read back exactly."""

import csv
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import StringIO

import numpy as np

from echoplan.errors import InvalidValueError

__all__ = ["format_csv", "format_json", "format_seconds", "format_toml"]

_LINE_WIDTH = 110


def format_seconds(stamp_ns: int) -> str:
    """Write a time in seconds, exact to the nanosecond.

    Parameters
    ----------
    stamp_ns : int
        Time [ns].

    Returns
    -------
    str
        Decimal number [s], without idle zeros.

    Examples
    --------
    >>> format_seconds(1_700_000_000_025_000_001)
    '1700000000.025000001'
    """
    whole, rest = divmod(abs(stamp_ns), 1_000_000_000)
    sign = "-" if stamp_ns < 0 else ""
    return f"{sign}{whole}.{f'{rest:09d}'.rstrip('0') or '0'}"


def format_csv(rows: Iterable[Mapping[str, object]], *, columns: Sequence[str]) -> str:
    """Write a table for a spreadsheet.

    Parameters
    ----------
    rows : iterable of mapping of str to object
        The cells of each row by column; None is left empty.
    columns : sequence of str
        The columns in the order wanted.

    Returns
    -------
    str
        Comma-separated values with a header.

    Examples
    --------
    >>> print(format_csv([{"name": "=1+1", "walls": None}], columns=("name", "walls")))
    name,walls
    '=1+1,
    <BLANKLINE>
    """
    text = StringIO()
    writer = csv.DictWriter(text, fieldnames=columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: _no_formula(cell) for name, cell in row.items()} for row in rows)
    return text.getvalue()


def _no_formula(cell: object) -> object:
    # A spreadsheet computes a text that begins so, whatever a folder's name makes it do, and hides the apostrophe.
    return f"'{cell}" if isinstance(cell, str) and cell.startswith(("=", "+", "-", "@", "\t", "\r")) else cell


def format_json(value: object) -> str:
    """Write JSON that keeps on one line what fits on it.

    Parameters
    ----------
    value : object
        Mappings, sequences, strings, numbers, truth values and None.

    Returns
    -------
    str
        The text, floats in their shortest exact form.

    Raises
    ------
    InvalidValueError
        If a number is not finite or a value has no place in JSON.

    Examples
    --------
    >>> format_json({"corners": [], "radius": 0.1})
    '{"corners": [], "radius": 0.1}'
    """
    try:
        return _json(value, indent="")
    except (TypeError, ValueError) as error:
        raise InvalidValueError(f"there is no JSON for this value: {error}") from error


def format_toml(table: Mapping[str, object]) -> str:
    """Write TOML: plain keys first, then tables, one key a line.

    Parameters
    ----------
    table : mapping
        Keys and their values; those of None are left out.

    Returns
    -------
    str
        The text, floats in their shortest exact form.

    Examples
    --------
    >>> print(format_toml({"name": "ring", "turret": {"x": 0.0}, "sensor": [{"id": 0}, {"id": 1}]}))
    name = "ring"
    <BLANKLINE>
    [turret]
    x = 0.0
    <BLANKLINE>
    [[sensor]]
    id = 0
    <BLANKLINE>
    [[sensor]]
    id = 1
    <BLANKLINE>
    """
    return "\n".join(_toml_lines(table, path=())).lstrip("\n") + "\n"


def _json(value: object, *, indent: str) -> str:
    line = json.dumps(value, allow_nan=False, ensure_ascii=False, default=np.generic.item)
    if len(indent) + len(line) <= _LINE_WIDTH or not isinstance(value, Mapping | list | tuple):
        return line
    deeper = indent + "  "
    if isinstance(value, Mapping):
        items = [f"{json.dumps(key)}: {_json(item, indent=deeper)}" for key, item in value.items()]
        opening, closing = "{}"
    else:
        items = [_json(item, indent=deeper) for item in value]
        opening, closing = "[]"
    inner = f",\n{deeper}".join(items)
    return f"{opening}\n{deeper}{inner}\n{indent}{closing}"


def _toml_lines(table: Mapping[str, object], *, path: tuple[str, ...]) -> Iterator[str]:
    present = {key: value for key, value in table.items() if value is not None}
    plain = {key: value for key, value in present.items() if not _is_table(value)}
    yield from (f"{_toml_key(key)} = {_toml_value(value)}" for key, value in plain.items())
    for key, value in present.items():
        inner = (*path, _toml_key(key))
        if isinstance(value, Mapping):
            yield from ("", f"[{'.'.join(inner)}]", *_toml_lines(value, path=inner))
        elif key not in plain:
            assert isinstance(value, Sequence)
            for entry in value:
                yield from ("", f"[[{'.'.join(inner)}]]", *_toml_lines(entry, path=inner))


def _is_table(value: object) -> bool:
    if isinstance(value, list | tuple):
        return bool(value) and all(isinstance(entry, Mapping) for entry in value)
    return isinstance(value, Mapping)


def _toml_key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _toml_value(key)


def _toml_value(value: object) -> str:
    if isinstance(value, np.generic):
        return _toml_value(value.item())
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml_value, value))}]"
    if isinstance(value, str):
        # JSON escapes as TOML does, but for the one control character that it leaves as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(value).lower() if isinstance(value, bool) else repr(value)


def names_in(names: str | Iterable[str]) -> list[str]:
    """List names: those of a text are separated by commas."""
    listed = names.split(",") if isinstance(names, str) else names
    return [name.strip() for name in listed if name.strip()]
