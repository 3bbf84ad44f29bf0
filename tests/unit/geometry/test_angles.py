import numpy as np
import pytest

from echoplan.geometry import circular_mean, directions, rotation_step, wrap

HALF_TURN = np.pi


@pytest.mark.parametrize(
    ("angle", "wrapped"),
    [(0.25, 0.25), (HALF_TURN, -HALF_TURN), (-HALF_TURN, -HALF_TURN), (5.0, 5.0 - 2 * np.pi), (-9.0, 2 * np.pi - 9.0)],
)
def test_angles_wrap_into_one_turn_about_zero(angle: float, wrapped: float) -> None:
    assert wrap(angle) == pytest.approx(wrapped, abs=1e-14)


def test_an_angle_a_rounding_below_minus_pi_does_not_wrap_to_plus_pi() -> None:
    assert wrap(np.nextafter(-np.pi, -4.0)) == -np.pi


def test_the_mean_of_directions_on_both_sides_of_the_seam_lies_at_the_seam() -> None:
    assert circular_mean([HALF_TURN - 0.3, -HALF_TURN + 0.1]) == pytest.approx(HALF_TURN - 0.1)


def test_a_mean_of_half_a_turn_is_given_as_minus_pi_as_wrap_gives_it() -> None:
    assert circular_mean([np.pi]) == circular_mean([-np.pi]) == -np.pi


def test_directions_point_where_the_angles_say() -> None:
    assert directions([[0.0, np.pi / 2], [np.pi, np.arctan2(3.0, 4.0)]]) == pytest.approx(
        np.array([[[1.0, 0.0], [0.0, 1.0]], [[-1.0, 0.0], [0.8, 0.6]]]), abs=1e-15
    )


@pytest.mark.parametrize("start", [0.0, -HALF_TURN, 3.1])
def test_the_step_of_a_full_turn_is_that_of_its_pings_wherever_it_starts(start: float) -> None:
    assert rotation_step(start + np.radians(np.arange(0.0, 360.0, 1.8))) == pytest.approx(np.radians(1.8))


def test_the_step_of_a_sector_is_not_the_gap_that_it_leaves() -> None:
    assert rotation_step(np.radians(np.arange(-45.0, 45.5, 0.5))) == pytest.approx(np.radians(0.5))


def test_a_few_missing_pings_do_not_change_the_step() -> None:
    bearings = np.radians(np.delete(np.arange(360.0), [5, 6, 7, 100, 359]))
    assert rotation_step(np.random.default_rng(2).permutation(bearings)) == pytest.approx(np.radians(1.0))


def test_pings_of_one_direction_are_not_a_step_apart() -> None:
    bearings = np.radians([10.0, 10.0, 10.0, 40.0, 40.0, 40.0, 70.0, 70.0])
    assert rotation_step(bearings) == pytest.approx(np.radians(30.0))


def test_a_single_direction_comes_back_after_a_full_turn() -> None:
    assert rotation_step(np.array([1.0, 1.0])) == pytest.approx(2 * np.pi)
