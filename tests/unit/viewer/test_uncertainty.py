import math

import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.geometry import directions, signed_distances
from echoplan.model import Wall
from echoplan.viewer.uncertainty import (
    PROBABILITY,
    across_sigmas,
    error_ellipse,
    greatest_sigma,
    middle_sigma,
    sigma,
    wall_band,
)
from helpers.maps import wall

# Quantile 0.95 of chi-squared with two degrees of freedom, and 0.975 of the normal distribution, from tables.
CHI_SQUARED, NORMAL = 5.991465, 1.959964


def turned(angle: float, long: float, short: float) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Covariance of a point that is most uncertain in one direction."""
    axes = np.stack([directions(angle), directions(angle + np.pi / 2)], axis=1)
    return axes @ np.diag([long**2, short**2]) @ axes.T


def unsure(*, angle: float = 0.0, offset: float = 0.0, together: float = 0.0) -> Wall:
    """The wall x = 2 from y = 1 to y = 4, with these deviations and their covariance."""
    return Wall(
        normal_angle=0.0,
        offset=2.0,
        endpoints_xy=np.array([[2.0, 1.0], [2.0, 4.0]]),
        covariance=np.array([[angle**2, together], [together, offset**2]]),
    )


def test_the_probability_of_everything_drawn_is_95_per_cent() -> None:
    assert PROBABILITY == 0.95


def test_an_ellipse_lies_about_its_point() -> None:
    np.testing.assert_array_equal(error_ellipse([3.0, -1.0], np.eye(2)).center_xy, [3.0, -1.0])


def test_its_axes_are_deviations_times_the_root_of_a_quantile_of_chi_squared() -> None:
    ellipse = error_ellipse([0.0, 0.0], np.diag([0.04, 0.01]))
    np.testing.assert_allclose(ellipse.semi_axes, np.sqrt(CHI_SQUARED) * np.array([0.2, 0.1]), rtol=1e-6)


@pytest.mark.parametrize(("probability", "factor"), [(0.39346934, 1.0), (0.86466472, 2.0), (0.98889100, 3.0)])
def test_other_probabilities_give_other_sizes(probability: float, factor: float) -> None:
    ellipse = error_ellipse([0.0, 0.0], np.diag([0.25, 0.25]), probability=probability)
    np.testing.assert_allclose(ellipse.semi_axes, factor * 0.5, rtol=1e-6)


def test_the_long_axis_comes_first_even_if_it_is_y() -> None:
    ellipse = error_ellipse([0.0, 0.0], np.diag([0.01, 0.04]))
    assert ellipse.semi_axes[0] == pytest.approx(2 * ellipse.semi_axes[1])
    assert math.remainder(ellipse.angle, math.pi) == pytest.approx(math.pi / 2)


@pytest.mark.parametrize("degrees", [-80, -45, 0, 10, 30, 89])
def test_the_angle_is_that_of_the_long_axis(degrees: float) -> None:
    angle = math.radians(degrees)
    ellipse = error_ellipse([0.0, 0.0], turned(angle, 0.3, 0.1))
    assert math.remainder(ellipse.angle - angle, math.pi) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(ellipse.semi_axes, np.sqrt(CHI_SQUARED) * np.array([0.3, 0.1]), rtol=1e-6)


def test_a_point_that_is_sure_has_an_ellipse_of_no_size() -> None:
    np.testing.assert_array_equal(error_ellipse([1.0, 1.0], np.zeros((2, 2))).semi_axes, [0.0, 0.0])


def test_a_point_that_is_sure_in_one_direction_has_a_line_for_an_ellipse() -> None:
    long, short = error_ellipse([0.0, 0.0], turned(0.7, 0.2, 0.0)).semi_axes
    assert long == pytest.approx(0.2 * math.sqrt(CHI_SQUARED), rel=1e-6)
    assert short == pytest.approx(0.0, abs=1e-8)


@pytest.mark.parametrize("matrix", [[[1.0, 2.0], [0.0, 1.0]], [[1.0, 2.0], [2.0, 1.0]], [[1.0]], [[np.nan, 0], [0, 1]]])
def test_what_is_no_covariance_has_no_ellipse(matrix: list[list[float]]) -> None:
    with pytest.raises(InvalidValueError, match="covariance must"):
        error_ellipse([0.0, 0.0], matrix)


def test_an_ellipse_cannot_be_changed() -> None:
    ellipse = error_ellipse([0.0, 0.0], np.eye(2))
    with pytest.raises(ValueError, match="read-only"):
        ellipse.semi_axes[0] = 1.0


def test_a_wall_sure_of_its_direction_is_as_unsure_everywhere_as_of_its_offset() -> None:
    np.testing.assert_allclose(across_sigmas(unsure(offset=0.02), [[2.0, 1.0], [2.0, 2.5], [2.0, 4.0]]), 0.02)


def test_a_wall_sure_of_its_offset_is_the_less_sure_the_farther_from_the_foot_of_the_origin() -> None:
    sigmas = across_sigmas(unsure(angle=0.01), [[2.0, 0.0], [2.0, 1.0], [2.0, 4.0], [2.0, -4.0]])
    np.testing.assert_allclose(sigmas, [0.0, 0.01, 0.04, 0.04], atol=1e-12)


def test_errors_of_angle_and_offset_may_cancel() -> None:
    # Both come from a turn about the point at y = 2: d offset = 2 d angle.
    sigmas = across_sigmas(unsure(angle=0.01, offset=0.02, together=0.0002), [[2.0, 1.0], [2.0, 2.0], [2.0, 4.0]])
    np.testing.assert_allclose(sigmas, [0.01, 0.0, 0.02], atol=1e-9)


def test_deviations_across_agree_with_walls_drawn_by_chance() -> None:
    rng = np.random.default_rng(3)
    one = Wall(
        normal_angle=0.8,
        offset=1.5,
        endpoints_xy=1.5 * directions(0.8) + np.array([[-1.0], [2.0]]) * directions(0.8 + np.pi / 2),
        covariance=np.array([[4e-6, 3e-6], [3e-6, 9e-6]]),
    )
    drawn = rng.multivariate_normal([one.normal_angle, one.offset], one.covariance, size=20_000)
    for point in one.endpoints_xy:
        assert np.std(signed_distances(drawn, point)) == pytest.approx(float(across_sigmas(one, point)), rel=0.02)


def test_the_middle_of_a_wall_is_that_between_its_ends() -> None:
    assert middle_sigma(unsure(angle=0.01)) == pytest.approx(0.025)
    assert middle_sigma(unsure(angle=0.01, offset=0.025)) == pytest.approx(0.025 * math.sqrt(2))


def test_the_greatest_deviation_is_that_along_the_long_axis() -> None:
    assert greatest_sigma(turned(0.4, 0.3, 0.1)) == pytest.approx(0.3)
    assert greatest_sigma(np.zeros((2, 2))) == 0.0
    assert greatest_sigma(np.full((2, 2), -1e-18)) == 0.0


def test_the_deviation_of_one_parameter_is_the_root_of_its_variance() -> None:
    covariance = np.diag([4.0, 9.0, 16.0])
    assert [sigma(covariance, index) for index in range(3)] == [2.0, 3.0, 4.0]
    assert sigma(np.array([[-1e-20]]), 0) == 0.0


def test_a_band_goes_from_the_start_of_its_wall_to_its_end() -> None:
    along = wall_band(unsure(offset=0.01))[:, 0]
    assert along[0] == 0.0
    assert along[-1] == pytest.approx(3.0)
    assert (np.diff(along) > 0).all()


def test_half_the_width_of_a_band_is_a_quantile_times_the_deviation_there() -> None:
    band = wall_band(unsure(angle=0.01))
    np.testing.assert_allclose(band[:, 1], NORMAL * 0.01 * (1.0 + band[:, 0]), rtol=1e-6)


def test_bands_of_greater_probability_are_wider() -> None:
    narrow, wide = (wall_band(unsure(offset=0.01), probability=each)[:, 1] for each in (0.6826895, 0.9973002))
    np.testing.assert_allclose(narrow, 0.01, rtol=1e-5)
    np.testing.assert_allclose(wide, 0.03, rtol=1e-5)


def test_a_wall_that_runs_the_other_way_has_its_band_the_other_way_round() -> None:
    there, back = wall([2.0, 1.0], [2.0, 4.0]), wall([2.0, 4.0], [2.0, 1.0])
    np.testing.assert_allclose(wall_band(back)[:, 1], wall_band(there)[::-1, 1])
