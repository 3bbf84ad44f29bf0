import math

import numpy as np
import pytest

from echoplan.viewer.wording import SIGMA, decimal, in_degrees, in_metres, in_millimetres, in_percent, plural, point


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (1.0, 3, "1.000"),
        (-2.5, 1, "-2.5"),
        (1.23456, 3, "1.235"),
        (12.0, 0, "12"),
        (0.05, 2, "0.05"),
        (1234567.0, 1, "1234567.0"),
    ],
)
def test_a_number_has_the_requested_digits_after_the_point(value: float, digits: int, text: str) -> None:
    assert decimal(value, digits) == text


@pytest.mark.parametrize("value", [0.0, -0.0, -1e-9, -0.0004])
def test_what_rounds_to_nothing_has_no_sign(value: float) -> None:
    assert decimal(value, 3) == "0.000"


def test_what_does_not_round_to_nothing_keeps_its_sign() -> None:
    assert decimal(-0.0006, 3) == "-0.001"


def test_numbers_of_numpy_are_written_as_those_of_python() -> None:
    assert decimal(np.float64(-0.0001), 3) == "0.000"
    assert in_metres(np.float64(2.0)) == "2.000 m"


def test_lengths_are_written_to_the_millimetre() -> None:
    assert in_metres(5.0) == "5.000 m"
    assert in_metres(0.0005001) == "0.001 m"
    assert in_metres(-1.2345) in ("-1.234 m", "-1.235 m")


def test_small_lengths_are_written_to_a_tenth_of_a_millimetre() -> None:
    assert in_millimetres(0.01) == "10.0 mm"
    assert in_millimetres(0.00004) == "0.0 mm"
    assert in_millimetres(1.5) == "1500.0 mm"


def test_angles_are_written_in_degrees() -> None:
    assert in_degrees(math.pi) == "180.0°"
    assert in_degrees(-math.pi / 6) == "-30.0°"
    assert in_degrees(1.0, digits=2) == "57.30°"
    assert in_degrees(math.radians(44.6), digits=0) == "45°"


def test_an_angle_of_nothing_is_not_negative() -> None:
    assert in_degrees(-1e-6) == "0.0°"


def test_shares_are_written_in_whole_per_cent_without_the_sign() -> None:
    assert [in_percent(share) for share in (0.0, 0.014, 0.5, 0.996, 1.0)] == ["0", "1", "50", "100", "100"]


def test_a_point_has_both_coordinates_in_their_order_and_one_unit() -> None:
    assert point([1.0, -2.5]) == "(1.000, -2.500) m"
    assert point(np.array([-0.00001, 12.3456])) == "(0.000, 12.346) m"
    assert point((3, 4)) == "(3.000, 4.000) m"


def test_only_one_thing_is_singular() -> None:
    assert [plural(count, "station") for count in (0, 1, 2, 11)] == [
        "0 stations",
        "1 station",
        "2 stations",
        "11 stations",
    ]


def test_the_standard_deviation_has_its_greek_letter() -> None:
    assert ord(SIGMA) == 0x3C3
