import re
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from echoplan.arrays import (
    FloatArray,
    checked_covariance,
    checked_floats,
    checked_integers,
    checked_number,
    chosen_items,
    store,
)
from echoplan.errors import InvalidValueError

LARGEST = 2**63 - 1


@pytest.mark.parametrize(
    ("value", "bounds", "message"),
    [
        (np.inf, {}, "radius must be finite, not inf"),
        (np.nan, {}, "radius must be finite, not nan"),
        ("wide", {}, "radius must be a number, not 'wide'"),
        (None, {}, "radius must be a number, not None"),
        (0, {"above": 0}, "radius must be greater than 0, not 0"),
        (-0.5, {"minimum": 0}, "radius must be at least 0, not -0.5"),
        (3.1415927, {"maximum": np.pi}, "radius must be at most 3.14159265359, not 3.1415927"),
    ],
)
def test_a_number_out_of_bounds_is_refused_with_name_and_value(
    value: Any, bounds: dict[str, float], message: str
) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        checked_number(value, name="radius", **bounds)


def test_a_number_on_its_bounds_passes_as_a_float() -> None:
    assert checked_number(2, name="radius", minimum=2, maximum=2) == 2.0
    assert isinstance(checked_number(2, name="radius"), float)


def test_checked_arrays_are_read_only_copies() -> None:
    floats, integers, covariance = np.array([1.0, 2.0]), np.array([1, 2]), np.eye(2)
    copies = (
        checked_floats(floats, name="a", shape=(2,)),
        checked_integers(integers, name="a", shape=(2,)),
        checked_covariance(covariance, name="a", size=2),
    )
    for copy, given in zip(copies, (floats, integers, covariance), strict=True):
        assert np.array_equal(copy, given)
        assert not np.shares_memory(copy, given)
        with pytest.raises(ValueError, match="read-only"):
            copy[0] = 7


@pytest.mark.parametrize(
    ("value", "message"),
    [
        ([[1.0, 2.0, 3.0]], "points must have shape (n, 2), not (1, 3)"),
        ([1.0, 2.0], "points must have shape (n, 2), not (2,)"),
        ([["a", "b"]], "points must hold numbers, not [['a', 'b']]"),
        ([[1.0], [2.0, 3.0]], "points must hold numbers, not [[1.0], [2.0, 3.0]]"),
        ([[1.0, np.nan], [np.inf, 0.0]], "points must be finite, not nan"),
    ],
)
def test_floats_of_the_wrong_shape_or_kind_are_refused(value: Any, message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        checked_floats(value, name="points", shape=(None, 2))


def test_floats_may_be_infinite_where_that_has_a_meaning() -> None:
    readings = checked_floats([1.0, np.inf, -np.inf, np.nan], name="ranges", shape=(None,), finite=False)
    assert np.array_equal(readings, [1.0, np.inf, -np.inf, np.nan], equal_nan=True)


@pytest.mark.parametrize(
    "value", [[0.5], [np.nan], [np.inf], [2.0**63], [-1e300], [LARGEST + 1], ["1"], [True], [[1], [2, 3]]]
)
def test_what_is_no_whole_number_of_64_bits_is_refused(value: Any) -> None:
    with pytest.raises(InvalidValueError, match=f"^ids must hold whole numbers, not {re.escape(repr(value))}$"):
        checked_integers(value, name="ids", shape=(None,))


def test_integers_of_the_wrong_shape_are_refused() -> None:
    with pytest.raises(InvalidValueError, match=re.escape("ids must have shape (3), not (2,)")):
        checked_integers([1, 2], name="ids", shape=(3,))


def test_whole_numbers_pass_unchanged_whatever_type_they_come_in() -> None:
    for value in ([-3, LARGEST], [-3.0, 4.0], np.array([1, 2], dtype=np.uint8), []):
        checked = checked_integers(value, name="ids", shape=(None,))
        assert checked.dtype == np.int64
        assert checked.tolist() == list(value)


@pytest.mark.parametrize(
    ("matrix", "message"),
    [
        ([[1.0, 0.5], [0.4, 1.0]], "covariance must be symmetric, not [[1.0, 0.5], [0.4, 1.0]]"),
        ([[1.0, 2.0], [2.0, 1.0]], "covariance must have no negative eigenvalue, not [[1.0, 2.0], [2.0, 1.0]]"),
        (
            [[1e-9, 2e-9], [2e-9, 1e-9]],
            "covariance must have no negative eigenvalue, not [[1e-09, 2e-09], [2e-09, 1e-09]]",
        ),
        ([[1.0]], "covariance must have shape (2, 2), not (1, 1)"),
    ],
)
def test_what_is_no_covariance_is_refused(matrix: list[list[float]], message: str) -> None:
    with pytest.raises(InvalidValueError, match=f"^{re.escape(message)}$"):
        checked_covariance(matrix, name="covariance", size=2)


@pytest.mark.parametrize("scale", [0.0, 1e-12, 1.0])
def test_a_singular_covariance_passes_at_any_scale(scale: float) -> None:
    matrix = scale * np.outer([1.0, 3.0], [1.0, 3.0])
    assert np.array_equal(checked_covariance(matrix, name="covariance", size=2), matrix)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Places:
    """Points with weights, checked as the values of the model are."""

    points_xy: FloatArray
    weights: FloatArray

    def __post_init__(self) -> None:
        store(self, points_xy=checked_floats(self.points_xy, name="points_xy", shape=(len(self.weights), 2)))


@pytest.mark.parametrize("chosen", [np.array([True, False, True]), np.array([0, 2]), slice(0, 3, 2)])
def test_of_each_array_the_same_items_are_kept(chosen: Any) -> None:
    kept = chosen_items(Places(points_xy=np.arange(6.0).reshape(3, 2), weights=np.arange(3.0)), chosen)
    assert isinstance(kept, Places)
    assert kept.points_xy.tolist() == [[0.0, 1.0], [4.0, 5.0]]
    assert kept.weights.tolist() == [0.0, 2.0]
    assert not kept.points_xy.flags.writeable
