"""Wrong units are reported where they are certain, and only there."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.io.units import check_extent, looks_like_degrees, possible_length_units

DEGREES = {
    "servo": np.arange(-45.0, 46.0),
    "compass": np.array([0.0, 90.0, 180.0, 270.0]),
    "stepper": np.arange(0.0, 90.0, 1.8),
    "one": np.array([35.0]),
}
RADIANS = {
    "servo": np.deg2rad(np.arange(-180.0, 181.0)),
    "ten turns": np.deg2rad(np.arange(0.0, 3600.0)).round(4),
    "one decimal": np.array([0.0, 1.6, 3.1, 4.7, 6.3]),
    "still": np.zeros(4),
    "none": np.zeros(0),
}


@pytest.mark.parametrize("name", DEGREES)
def test_degrees_are_recognised(name: str) -> None:
    assert looks_like_degrees(DEGREES[name])


@pytest.mark.parametrize("name", RADIANS)
def test_radians_are_not_mistaken_for_degrees(name: str) -> None:
    assert not looks_like_degrees(RADIANS[name])


def units_of(ranges: FloatArray) -> tuple[str, ...]:
    return possible_length_units(ranges, min_ranges=np.full(len(ranges), 0.2), max_ranges=np.full(len(ranges), 3.0))


METRES = np.array([0.4, 0.85, 1.2, np.inf, 2.9, -np.inf, np.nan])


@pytest.mark.parametrize(
    ("scale", "units"), [(1.0, ()), (100.0, ("cm",)), (1000.0, ("mm",)), (1.0 / 0.0254, ("cm", "in"))]
)
def test_ranges_beyond_the_maximum_show_which_units_they_may_have(scale: float, units: tuple[str, ...]) -> None:
    assert units_of(scale * METRES) == units


@pytest.mark.parametrize(
    "ranges",
    [
        np.array([3.5, 5.0, 5.5]),  # somewhat beyond the reach
        np.array([0.5] + 9 * [999.0]),  # a number that stands for no echo
        np.array([np.inf, np.nan]),
        np.zeros(0),
    ],
)
def test_odd_ranges_are_not_mistaken_for_another_unit(ranges: FloatArray) -> None:
    assert not units_of(ranges)


def test_what_is_wider_than_any_building_is_refused() -> None:
    check_extent([[5e5, 5e6], [5.05e5, 5e6]], name="the map")
    check_extent([], name="the map")
    with pytest.raises(InvalidValueError, match="the map is 1e\\+06 m wide, and 10000 m are the most; correct its"):
        check_extent([[0.0, 0.0], [0.0, 1e6]], name="the map")
