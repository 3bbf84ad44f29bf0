import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.viewer.sheet import Sheet

# What a sheet holds of A4 between its borders and above its foot [mm].
WIDEST, HIGHEST = 170.0, 245.0


def sheet(wide: float, high: float, *, left: float = 0.0, low: float = 0.0) -> Sheet:
    return Sheet(bounds_xy=np.array([[left, low], [left + wide, low + high]]))


@pytest.mark.parametrize(
    ("wide", "high", "scale"),
    [
        (1.0, 1.0, 10),
        (1.7, 1.0, 10),
        (1.71, 1.0, 20),
        (3.4, 3.0, 20),
        (4.0, 3.0, 25),
        (4.26, 3.0, 50),
        (5.0, 3.0, 50),
        (8.5, 12.25, 50),
        (8.5, 12.26, 100),
        (1.0, 2.45, 10),
        (1.0, 2.46, 20),
        (17.0, 17.0, 100),
        (100.0, 100.0, 1000),
        (0.17, 0.1, 1),
    ],
)
def test_the_scale_is_the_greatest_common_one_at_which_all_fits(wide: float, high: float, scale: float) -> None:
    assert sheet(wide, high).scale == scale


def test_the_scale_does_not_depend_on_where_the_map_lies() -> None:
    assert sheet(4.0, 3.0, left=-100.0, low=1000.0).scale == 25


def test_a_metre_is_as_long_as_the_scale_says() -> None:
    assert sheet(4.0, 3.0).millimetres == 40.0
    assert sheet(17.0, 3.0).millimetres == 10.0


def test_a_sheet_has_a_border_all_around_and_a_foot() -> None:
    np.testing.assert_allclose(sheet(4.0, 3.0).size, [4 * 40 + 20, 3 * 40 + 20 + 12])


@pytest.mark.parametrize(("wide", "high"), [(1.7, 2.45), (17.0, 24.5), (1.0, 200.0), (200.0, 1.0), (3.0, 2.0)])
def test_no_sheet_is_greater_than_what_a4_leaves_between_its_margins(wide: float, high: float) -> None:
    assert (sheet(wide, high).size <= np.array([190.0, 277.0]) + 1e-9).all()


def test_lower_left_of_the_map_is_lower_left_on_paper() -> None:
    np.testing.assert_allclose(sheet(4.0, 3.0).paper([0.0, 0.0]), [10, 10 + 120])


def test_upper_right_of_the_map_is_upper_right_on_paper() -> None:
    np.testing.assert_allclose(sheet(4.0, 3.0).paper([4.0, 3.0]), [10 + 160, 10])


def test_the_origin_may_lie_anywhere() -> None:
    np.testing.assert_allclose(sheet(4.0, 3.0, left=-2.0, low=-1.0).paper([0.0, 0.0]), [10 + 80, 10 + 80])


def test_a_metre_to_the_right_goes_right_and_a_metre_up_goes_up() -> None:
    paper = sheet(4.0, 3.0).paper([[1.0, 1.0], [2.0, 1.0], [1.0, 2.0]])
    np.testing.assert_allclose(paper[1] - paper[0], [40, 0])
    np.testing.assert_allclose(paper[2] - paper[0], [0, -40])


def test_points_keep_their_axes() -> None:
    one = sheet(4.0, 3.0)
    points = np.arange(24.0).reshape(3, 4, 2)
    assert one.paper(points).shape == (3, 4, 2)
    np.testing.assert_allclose(one.paper(points)[1, 2], one.paper(points[1, 2]))
    assert one.paper(np.zeros((0, 2))).shape == (0, 2)


@pytest.mark.parametrize(
    ("wide", "grid"), [(0.17, 0.05), (1.0, 0.5), (3.0, 0.5), (4.0, 1.0), (8.0, 2.0), (17.0, 5.0), (34.0, 5.0)]
)
def test_lines_of_the_grid_are_a_round_length_apart(wide: float, grid: float) -> None:
    assert sheet(wide, wide / 2).grid == pytest.approx(grid)


@pytest.mark.parametrize("wide", [0.3, 1.0, 2.2, 4.0, 9.0, 33.0, 70.0])
def test_lines_of_the_grid_never_crowd(wide: float) -> None:
    one = sheet(wide, 1.0)
    assert 25.0 <= one.grid * one.millimetres <= 50.0


def test_the_grid_lies_at_whole_multiples_within_the_map() -> None:
    x, y = sheet(4.2, 2.9, left=-1.1, low=0.05).lines
    np.testing.assert_allclose(x, [-1, 0, 1, 2, 3])
    np.testing.assert_allclose(y, [1, 2])


def test_lines_on_the_very_border_belong_to_the_grid() -> None:
    x, y = sheet(4.0, 3.0).lines
    np.testing.assert_allclose(x, [0, 1, 2, 3, 4])
    np.testing.assert_allclose(y, [0, 1, 2, 3])


def test_a_border_that_misses_a_line_by_rounding_has_it() -> None:
    x, _ = Sheet(bounds_xy=np.array([[1e-12, 0.0], [4.0 - 1e-12, 3.0]])).lines
    np.testing.assert_allclose(x, [0, 1, 2, 3, 4])


@pytest.mark.parametrize("bounds", [[[0.0, 0.0]], [0.0, 1.0], [[0.0, 0.0], [np.inf, 1.0]]])
def test_bounds_are_two_points(bounds: list[list[float]]) -> None:
    with pytest.raises(InvalidValueError, match="bounds_xy must"):
        Sheet(bounds_xy=np.array(bounds))
