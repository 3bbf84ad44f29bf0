"""Conventions: recordings as people write them become SI and REP 103, and back."""

from dataclasses import replace
from itertools import product
from math import inf, pi

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.model import Axes, Conventions, Heading, Sweep

RECORDED = Sweep(
    index=3,
    stamps_ns=np.array([0, 1, 2]),
    sensor_ids=np.array([0, 0, 0]),
    servo_angles=np.array([0.0, pi / 2, pi]),
    ranges=np.array([1.0, inf, -inf]),
    map_from_base=np.array([[1.0, 2.0, 0.5]] * 3),
    temperature=21.0,
)
OTHER = Conventions(
    servo_sign=-1,
    servo_offset=0.3,
    servo_gain=0.94,
    range_unit=0.0254,
    position_unit=0.01,
    heading=Heading.COMPASS,
    axes=Axes.YX,
)


def test_what_is_in_si_stays_as_it_is() -> None:
    applied = Conventions().apply(RECORDED)
    for name in ("servo_angles", "ranges", "map_from_base"):
        np.testing.assert_array_equal(getattr(applied, name), getattr(RECORDED, name))


def test_a_servo_of_a_half_turn_looks_ahead_in_its_middle() -> None:
    assert Conventions(servo_offset=-pi / 2).apply(RECORDED).servo_angles == pytest.approx([-pi / 2, 0.0, pi / 2])
    mirrored = Conventions(servo_sign=-1, servo_offset=pi / 2)
    assert mirrored.apply(RECORDED).servo_angles == pytest.approx([pi / 2, 0.0, -pi / 2])


def test_a_servo_that_turns_less_than_commanded_is_scaled() -> None:
    assert Conventions(servo_gain=0.5).apply(RECORDED).servo_angles == pytest.approx([0.0, pi / 4, pi / 2])


def test_units_of_ranges_leave_missing_echoes_alone() -> None:
    assert Conventions(range_unit=0.0254).apply(RECORDED).ranges.tolist() == [0.0254, inf, -inf]


@pytest.mark.parametrize(
    ("heading", "yaw"), [(Heading.COUNTER_CLOCKWISE, 0.5), (Heading.CLOCKWISE, -0.5), (Heading.COMPASS, pi / 2 - 0.5)]
)
def test_headings_become_counter_clockwise(heading: Heading, yaw: float) -> None:
    assert Conventions(heading=heading).apply(RECORDED).map_from_base[0].tolist() == pytest.approx([1.0, 2.0, yaw])


@pytest.mark.parametrize(("axes", "xy"), [(Axes.XY, [1.0, 2.0]), (Axes.YX, [2.0, 1.0]), (Axes.Y_DOWN, [1.0, -2.0])])
def test_y_becomes_left_of_x(axes: Axes, xy: list[float]) -> None:
    assert Conventions(axes=axes).apply(RECORDED).map_from_base[0, :2].tolist() == xy


@pytest.mark.parametrize(("heading", "axes"), list(product(Heading, Axes)))
def test_undoing_brings_back_what_was_recorded(heading: Heading, axes: Axes) -> None:
    conventions = replace(OTHER, heading=heading, axes=axes)
    again = conventions.apply(conventions.undo(RECORDED))
    for name in ("servo_angles", "ranges", "map_from_base"):
        np.testing.assert_allclose(getattr(again, name), getattr(RECORDED, name), rtol=1e-12)
    assert (again.index, again.temperature) == (3, 21.0)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"servo_sign": 0}, "servo_sign must be 1 or -1, not 0"),
        ({"range_unit": 0.0}, "range_unit"),
        ({"servo_gain": -1.0}, "servo_gain"),
    ],
)
def test_impossible_conventions_are_refused(changes: dict[str, float], said: str) -> None:
    with pytest.raises(InvalidValueError, match=said):
        Conventions(**changes)  # type: ignore[arg-type]
