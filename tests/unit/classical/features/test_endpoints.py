import numpy as np
import pytest

from echoplan.classical.features.endpoints import split_at_farthest, split_at_steps

X = np.linspace(0.0, 2.0, 21)
BENT = np.concatenate([np.column_stack([X, 0 * X]), np.column_stack([0 * X[1:] + 2.0, X[1:]])])


def pieces(points: np.ndarray, tolerance: float = 0.05) -> list[list[int]]:
    return [piece.tolist() for piece in split_at_farthest(points, tolerance=tolerance)]


def test_a_bent_chain_is_split_where_it_bends() -> None:
    assert pieces(BENT) == [list(range(21)), list(range(20, 41))]


def test_a_straight_chain_stays_whole() -> None:
    assert pieces(BENT[:21]) == [list(range(21))]


def test_noise_within_the_tolerance_splits_nothing() -> None:
    rough = BENT[:21] + np.random.default_rng(1).uniform(-0.02, 0.02, size=(21, 2))
    assert len(pieces(rough)) == 1
    assert len(pieces(rough, tolerance=0.001)) > 1


def test_a_closed_chain_is_split_though_its_ends_meet() -> None:
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]])
    assert pieces(square) == [[0, 1], [1, 2], [2, 3], [3, 4]]


@pytest.mark.parametrize("count", [1, 2])
def test_one_and_two_points_are_a_piece(count: int) -> None:
    assert pieces(BENT[:count]) == [list(range(count))]


def test_a_long_step_parts_a_chain() -> None:
    points = np.concatenate([BENT[:5], BENT[9:12]])
    assert [piece.tolist() for piece in split_at_steps(points, max_step=0.3)] == [[0, 1, 2, 3, 4], [5, 6, 7]]
    assert len(split_at_steps(points, max_step=0.6)) == 1
    assert split_at_steps(np.zeros((0, 2)), max_step=0.3) == []
