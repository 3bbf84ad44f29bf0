import numpy as np
import pytest
from numpy.testing import assert_allclose

from echoplan.kernels import doubled, median_of, order_of, solve_small, sort

LENGTHS = [1, 2, 3, 10, 57]


def drawn(length: int) -> np.ndarray:
    return np.random.default_rng(length).normal(size=length)


@pytest.mark.parametrize("length", [0, *LENGTHS])
def test_values_are_sorted_in_place(length: int) -> None:
    values = drawn(length)
    expected = np.sort(values)
    sort(values)
    assert values.tolist() == expected.tolist()


@pytest.mark.parametrize("length", [0, *LENGTHS])
def test_positions_are_in_the_order_of_their_keys(length: int) -> None:
    assert order_of(drawn(length)).tolist() == np.argsort(drawn(length)).tolist()


@pytest.mark.parametrize("length", LENGTHS)
def test_the_median_is_that_of_numpy_and_leaves_the_values(length: int) -> None:
    values = drawn(length)
    assert median_of(values) == np.median(values)
    assert values.tolist() == drawn(length).tolist()


def test_a_doubled_array_begins_with_the_values() -> None:
    values = doubled(np.array([3, 1]))
    assert values.dtype == np.int64
    assert (len(values), values[:2].tolist()) == (4, [3, 1])


def test_a_system_is_solved() -> None:
    factor = drawn(9).reshape(3, 3)
    matrix, right = factor @ factor.T + np.eye(3), drawn(3)
    assert_allclose(solve_small(matrix.copy(), right.copy()), np.linalg.solve(matrix, right), rtol=1e-12)
