"""Each kind of column has one grammar, and what does not follow it is refused."""

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
def test_times_are_exact_to_the_nanosecond(text: str, stamp_ns: int) -> None:
    assert SECONDS.read([text]).tolist() == [stamp_ns]


@pytest.mark.parametrize(
    "text", ["40.-725", "31.  725", "31 .725", "3 1.725", "--1", "1.2.3", "1e", ".", "1,5", "0x10", "1_0", "\u0663"]
)
@pytest.mark.parametrize("kind", KINDS)
def test_what_only_resembles_a_number_is_refused(kind: str, text: str) -> None:
    assert KINDS[kind].fault(text) == f"{text!r} is no {KINDS[kind].noun}"


@pytest.mark.parametrize("text", ["9" * 5000, "1e999", "1e999999", "1e99999999999"])
@pytest.mark.parametrize("kind", KINDS)
def test_a_number_that_is_too_large_is_refused_at_once_and_quoted_in_short(kind: str, text: str) -> None:
    assert 0 < len(KINDS[kind].fault(text)) < 80


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
def test_a_fault_is_reported_in_one_line(kind: str, text: str, problem: str) -> None:
    assert KINDS[kind].fault(text) == problem


@pytest.mark.parametrize(("kind", "text"), [("seconds", "0.1"), ("whole", "-3"), ("count", "0"), ("reading", "-inf")])
def test_a_field_without_fault_has_no_fault(kind: str, text: str) -> None:
    assert not KINDS[kind].fault(text)
