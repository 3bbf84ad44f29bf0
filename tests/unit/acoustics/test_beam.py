import numpy as np
import pytest
from scipy.special import j1

from echoplan.acoustics import Air, directivity, half_angle, ka_for, two_way_loss, wavenumber
from helpers.oracles import first_null


@pytest.mark.parametrize(
    ("ka", "six", "twenty", "null"),
    [(4.39, 21.6, 38.4, 60.7), (5.13, 18.4, 32.2, 48.4), (5.86, 16.0, 27.8, 40.8), (13.2, 7.0, 12.0, 16.9)],
)
def test_pistons_open_as_wide_as_the_books_say(ka: float, six: float, twenty: float, null: float) -> None:
    np.testing.assert_allclose(np.degrees(half_angle([6.0, 20.0], ka)), [six, twenty], atol=0.11)
    assert np.degrees(first_null(ka)) == pytest.approx(null, abs=0.1)


def test_the_first_null_lies_at_0_61_wavelengths_over_the_radius() -> None:
    radius, frequency, speed = 0.008, 40_000.0, 343.0
    ka = wavenumber(frequency, speed) * radius
    assert np.sin(first_null(ka)) == pytest.approx(0.61 * speed / frequency / radius, rel=1e-3)


def test_a_tiny_piston_has_no_null() -> None:
    assert first_null(1.0) == pytest.approx(np.pi / 2)
    assert half_angle(60.0, 1.0) == pytest.approx(np.pi / 2)


def test_the_fitted_hc_sr04_loses_what_was_measured() -> None:
    ka = wavenumber(40_000.0, Air().speed_of_sound) * 0.0081
    losses = two_way_loss(np.radians([0, 5, 10, 15, 20, 25, 30]), ka)
    np.testing.assert_allclose(losses, [0.0, 0.6, 2.4, 5.4, 9.9, 16.1, 25.0], atol=0.25)


def test_the_pattern_is_even_one_on_the_axis_and_nothing_behind() -> None:
    angles = np.linspace(0.0, np.pi, 181)
    pattern = directivity(angles, 6.0)
    np.testing.assert_allclose(pattern, directivity(-angles, 6.0))
    assert pattern[0] == 1.0
    assert (pattern[angles > np.radians(90.5)] == 0).all()
    assert pattern[90] == pytest.approx(2 * j1(6.0) / 6.0)


def test_the_first_side_lobe_is_turned_over_and_17_6_db_down() -> None:
    pattern = directivity(np.linspace(0.0, np.pi / 2, 2001), 10.0)
    assert 20 * np.log10(-pattern.min()) == pytest.approx(-17.6, abs=0.05)


def test_a_loss_below_nothing_is_met_on_the_axis() -> None:
    assert half_angle([-3.0, 0.0], 5.0).tolist() == [0.0, 0.0]


def test_a_piston_made_for_an_angle_has_that_angle() -> None:
    ka = ka_for(np.radians(35.0), [10.0, 20.0, 40.0])
    np.testing.assert_allclose(two_way_loss(np.radians(35.0), ka), [10.0, 20.0, 40.0], rtol=1e-6)


def test_nulls_are_infinitely_deep() -> None:
    assert two_way_loss(np.pi, 5.0) == np.inf
    assert two_way_loss(first_null(8.0), 8.0) > 250
