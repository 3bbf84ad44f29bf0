"""A column is the same whether it is read as a whole or field by field."""

import numpy as np
import pytest

from echoplan.io.kinds import COUNT, NUMBER, READING, SECONDS, TEMPERATURE, WHOLE

KINDS = {
    "seconds": SECONDS,
    "whole": WHOLE,
    "count": COUNT,
    "number": NUMBER,
    "reading": READING,
    "temperature": TEMPERATURE,
}


@pytest.mark.parametrize(
    ("text", "stamp_ns"),
    [
        ("0.025", 25_000_000),
        ("7", 7_000_000_000),
        ("1700000000.123456789", 1_700_000_000_123_456_789),
        ("8999999999.999999999", 8_999_999_999_999_999_999),
    ],
)
def test_plain_times_are_exact_on_both_ways(text: str, stamp_ns: int) -> None:
    assert SECONDS.take(np.array([text.encode()])).tolist() == [stamp_ns]
    assert SECONDS.read([text]).tolist() == [stamp_ns]


@pytest.mark.parametrize("text", ["-0.5", "1e-3", "0.30000000000000004", "1.", "9300000000", "99999999999999999999"])
def test_times_that_are_not_plain_are_either_read_alike_or_left_to_the_careful_way(text: str) -> None:
    try:
        taken = SECONDS.take(np.array([text.encode()])).tolist()
    except ValueError:
        return
    assert taken == SECONDS.read([text]).tolist()


@pytest.mark.parametrize(
    ("text", "stamp_ns"),
    [("-0.5", -500_000_000), ("2.5e-2", 25_000_000), ("0.30000000000000004", 300_000_000), ("1.", 1_000_000_000)],
)
def test_times_in_any_notation_are_read_with_care(text: str, stamp_ns: int) -> None:
    assert SECONDS.read([text]).tolist() == [stamp_ns]


def test_whole_numbers_may_be_written_with_a_point() -> None:
    assert WHOLE.read(["3.0", "-2"]).tolist() == [3, -2]


def test_a_reading_may_be_missing_or_no_number() -> None:
    np.testing.assert_array_equal(
        READING.read(["1.5", "inf", "-inf", "nan", ""]), [1.5, np.inf, -np.inf, np.nan, np.nan]
    )


@pytest.mark.parametrize(
    ("kind", "text", "problem"),
    [
        ("seconds", "noon", "'noon' is no time"),
        ("seconds", "nan", "'nan' is no time"),
        ("seconds", "inf", "'inf' is no time"),
        ("seconds", "1700000000000", "'1700000000000' is no time"),
        ("whole", "1.5", "'1.5' is no whole number"),
        ("whole", "1e30", "'1e30' is no whole number"),
        ("count", "-1", "'-1' is no count"),
        ("number", "inf", "'inf' is no number"),
        ("number", "0,5", "'0,5' is no number"),
        ("number", "", "the field is empty"),
        ("reading", "-0.3", "'-0.3' is no range"),
        ("reading", "far\n", r"'far\n' is no range"),
    ],
)
def test_a_fault_is_told_in_one_line(kind: str, text: str, problem: str) -> None:
    assert KINDS[kind].fault(text) == problem


@pytest.mark.parametrize(("kind", "text"), [("seconds", "0.1"), ("whole", "-3"), ("count", "0"), ("reading", "-inf")])
def test_a_field_without_fault_is_told_so(kind: str, text: str) -> None:
    assert not KINDS[kind].fault(text)


@pytest.mark.parametrize(
    ("kind", "number"), [("count", -1), ("number", np.nan), ("reading", -0.1), ("whole", 2**63 - 1)]
)
def test_what_is_not_allowed_is_refused_as_a_column_too(kind: str, number: float) -> None:
    with pytest.raises(ValueError, match=KINDS[kind].noun):
        KINDS[kind].take(np.array([number]))
