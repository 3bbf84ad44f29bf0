"""Tidy TOML and JSON."""

import json
import tomllib

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.io.text import format_json, format_seconds, format_toml


@pytest.mark.parametrize(
    ("stamp_ns", "text"),
    [
        (0, "0.0"),
        (25_000_000, "0.025"),
        (-1, "-0.000000001"),
        (-1_500_000_000, "-1.5"),
        (1_700_000_000_123_456_789, "1700000000.123456789"),
    ],
)
def test_seconds_keep_every_nanosecond_and_no_idle_zero(stamp_ns: int, text: str) -> None:
    assert format_seconds(stamp_ns) == text


def test_json_keeps_on_a_line_what_fits_and_breaks_the_rest() -> None:
    value = {"short": [1.0, 2.0], "long": [{"x": number, "name": "a name of some length"} for number in range(4)]}
    text = format_json(value)
    assert text.splitlines()[1] == '  "short": [1.0, 2.0],'
    assert text.splitlines()[3] == '    {"x": 0, "name": "a name of some length"},'
    assert json.loads(text) == value


def test_json_takes_numbers_of_numpy() -> None:
    assert format_json({"pings": np.int64(3), "radius": np.float64(0.1)}) == '{"pings": 3, "radius": 0.1}'


@pytest.mark.parametrize("value", [float("nan"), float("inf"), {1, 2}, [object()]])
def test_json_refuses_what_it_cannot_hold(value: object) -> None:
    with pytest.raises(InvalidValueError, match="there is no JSON for this value"):
        format_json({"value": value})


def test_toml_leaves_out_none_and_nests_tables() -> None:
    table = {
        "empty": None,
        "stage": {"filter": {"seed": 3, "on": True}, "names": ["a", "b"], "limits": [[0.0, 1e-9], []]},
        "wall": [{"closed": False}, {"closed": True}],
        "none of these": [],
    }
    text = format_toml(table)
    assert tomllib.loads(text) == {key: value for key, value in table.items() if value is not None}
    assert "[stage.filter]" in text
    assert text.count("[[wall]]") == 2


def test_toml_takes_numbers_of_numpy() -> None:
    assert format_toml({"x": np.float64(0.1), "id": np.int64(2)}) == "x = 0.1\nid = 2\n"


@pytest.mark.parametrize("name", ['quo"ted', "back\\slash", "new\nline", "bell\x07", "delete\x7f", "é", "📐"])
def test_toml_escapes_what_must_be_escaped(name: str) -> None:
    assert tomllib.loads(format_toml({"name": name, name: {"x": 1}})) == {"name": name, name: {"x": 1}}
