import numpy as np
import pytest

from echoplan.geometry import circular_mean, directions, wrap

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
