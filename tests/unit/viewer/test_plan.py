import string
from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.geometry import directions
from echoplan.model import Corner, CornerKind, Cylinder, FeatureMap, Opening, UnobservedStretch
from echoplan.viewer.plan import MOST_LABELS, Plan, station_labels
from helpers.maps import ROOM, corner, cylinder, drawn, wall

EMPTY = FeatureMap(method="none")
# The root of the quantile 0.95 of chi-squared with two degrees of freedom.
FACTOR = 2.447747


def plan(*features: object, **given: object) -> Plan:
    return Plan(feature_map=drawn(*features, poses=given.pop("poses", ())), **given)  # type: ignore[arg-type]


def test_an_empty_plan_is_bounded_by_a_square_metre() -> None:
    np.testing.assert_allclose(Plan(feature_map=EMPTY).bounds_xy, [[-0.0, -0.0], [1.0, 1.0]])


def test_walls_are_bounded_by_their_ends() -> None:
    one = plan(wall([-1.0, 0.5], [3.0, 2.0]), wall([0.0, -2.0], [1.0, 1.0]))
    np.testing.assert_allclose(one.bounds_xy, [[-1.0, -2.0], [3.0, 2.0]])


def test_cylinders_are_bounded_by_their_faces() -> None:
    one = plan(cylinder([0.0, 0.0], 0.5), cylinder([4.0, 3.0], 0.25))
    np.testing.assert_allclose(one.bounds_xy, [[-0.5, -0.5], [4.25, 3.25]])


def test_openings_and_unobserved_stretches_are_within_the_bounds() -> None:
    ends = np.array([[-1.0, 0.0], [7.0, 4.0]])
    for gap in (
        {"openings": (Opening(endpoints_xy=ends, width_sigma=0.0, walls=()),)},
        {"unobserved": (UnobservedStretch(endpoints_xy=ends, walls=()),)},
    ):
        np.testing.assert_allclose(Plan(feature_map=FeatureMap(method="m", **gap)).bounds_xy, ends)


def test_corners_and_stations_are_within_the_bounds() -> None:
    one = plan(corner([5.0, 1.0]), poses=[[-1.0, 4.0, 0.0]])
    np.testing.assert_allclose(one.bounds_xy, [[-1.0, 1.0], [5.0, 4.0]])


def test_the_true_room_is_within_the_bounds() -> None:
    room = replace(ROOM, cylinders=np.array([[5.0, 3.0, 0.5]]), cylinders_detected_by=np.array([1]))
    np.testing.assert_allclose(plan(corner([1.0, 1.0]), truth=room).bounds_xy, [[0.0, 0.0], [5.5, 3.5]])


def test_false_echoes_do_not_widen_the_map() -> None:
    one = plan(wall([0.0, 0.0], [4.0, 3.0]), echoes_xy=np.array([[90.0, -90.0]]))
    np.testing.assert_allclose(one.bounds_xy, [[0.0, 0.0], [4.0, 3.0]])


def test_echoes_bound_a_map_of_nothing_else() -> None:
    np.testing.assert_allclose(plan(echoes_xy=np.array([[2.0, 1.0], [-2.0, 4.0]])).bounds_xy, [[-2, 1], [2, 4]])


def test_a_single_point_lies_in_the_middle_of_a_square_metre() -> None:
    np.testing.assert_allclose(plan(corner([2.0, 3.0])).bounds_xy, [[1.5, 2.5], [2.5, 3.5]])


def test_only_a_side_shorter_than_a_metre_is_widened() -> None:
    np.testing.assert_allclose(plan(wall([0.0, 2.0], [4.0, 2.0])).bounds_xy, [[0.0, 1.5], [4.0, 2.5]])


def test_walls_are_drawn_in_proportion_to_the_greater_side() -> None:
    assert plan(wall([0.0, 0.0], [5.0, 2.0])).thickness == pytest.approx(0.06)
    assert plan(wall([0.0, 0.0], [2.0, 10.0])).thickness == pytest.approx(0.12)
    assert Plan(feature_map=EMPTY).thickness == pytest.approx(0.012)


def test_corners_have_their_ellipses_before_cylinders() -> None:
    one = plan(cylinder([1.0, 1.0], 0.1, sigma=0.02), corner([0.0, 0.0], sigma=0.03))
    np.testing.assert_allclose([each.center_xy for each in one.ellipses], [[0.0, 0.0], [1.0, 1.0]])
    np.testing.assert_allclose([each.semi_axes[0] for each in one.ellipses], FACTOR * np.array([0.03, 0.02]), rtol=1e-6)


def test_the_ellipse_of_a_cylinder_is_that_of_its_axis() -> None:
    covariance = np.diag([4e-4, 1e-4, 9.0])
    found = Cylinder(center_xy=np.array([1.0, 2.0]), radius=0.1, covariance=covariance)
    (ellipse,) = plan(found).ellipses
    np.testing.assert_allclose(ellipse.semi_axes, FACTOR * np.array([0.02, 0.01]), rtol=1e-6)


@pytest.mark.parametrize(("sigma", "times"), [(0.001, 10), (0.010, 10), (0.0103, 5), (0.0204, 5), (0.03, 2), (0.06, 1)])
def test_ellipses_are_enlarged_while_none_is_longer_than_a_tenth_of_the_drawing(sigma: float, times: int) -> None:
    # 10 x 2 x 2.4477 x sigma stays below 0.1 x 5 m up to a sigma of 10.2 mm.
    assert plan(wall([0.0, 0.0], [5.0, 3.0]), corner([1.0, 1.0], sigma=sigma)).magnification == times


def test_the_longest_of_all_ellipses_decides() -> None:
    one = plan(wall([0.0, 0.0], [5.0, 3.0]), corner([1.0, 1.0], sigma=0.001), cylinder([2.0, 1.0], 0.1, sigma=0.03))
    assert one.magnification == 2


def test_an_ellipse_longer_than_the_room_is_not_made_smaller() -> None:
    huge = Corner(position_xy=np.zeros(2), kind=CornerKind.CONVEX, covariance=np.diag([100.0, 1e-6]))
    assert plan(huge).magnification == 1


def test_a_map_without_ellipses_would_enlarge_any() -> None:
    assert plan(wall([0.0, 0.0], [5.0, 3.0])).ellipses == []
    assert plan(wall([0.0, 0.0], [5.0, 3.0])).magnification == 10


def test_echoes_are_points() -> None:
    with pytest.raises(InvalidValueError, match="echoes_xy must have shape"):
        Plan(feature_map=EMPTY, echoes_xy=np.zeros((3, 3)))
    with pytest.raises(InvalidValueError, match="echoes_xy must be finite"):
        Plan(feature_map=EMPTY, echoes_xy=np.array([[0.0, np.inf]]))


def test_plans_do_not_share_their_echoes() -> None:
    assert Plan(feature_map=EMPTY).echoes_xy is not Plan(feature_map=EMPTY).echoes_xy
    assert Plan(feature_map=EMPTY).echoes_xy.shape == (0, 2)


def test_stations_are_named_by_letters_in_their_order_whatever_their_sweeps() -> None:
    assert station_labels(np.array([7, 3, 12]), np.zeros((3, 2))) == ["A", "B", "C"]
    assert station_labels(np.zeros(0, dtype=np.int64), np.zeros((0, 2))) == []


def test_a_station_where_another_one_was_has_no_letter() -> None:
    places = np.array([[0.0, 0.0], [2.0, 0.0], [2.02, 0.01], [1.9, 0.0]])
    assert station_labels(np.arange(4), places) == ["A", "B", "", "D"]


def around(count: int) -> FloatArray:
    """Places on a circle, as far apart as can be."""
    return directions(np.linspace(0.0, 2 * np.pi, count, endpoint=False))


def test_of_stations_beside_each_other_one_is_named() -> None:
    # There and back again on one line: names of the way back would stand on those of the way there.
    places = np.column_stack([np.abs(np.linspace(-6.0, 6.0, 200)), np.zeros(200)])
    named = [number for number, label in enumerate(station_labels(np.arange(200), places)) if label]
    assert 6 <= len(named) <= 13
    assert np.diff(np.sort(places[named, 0])).min() >= 0.5


def test_there_are_letters_for_26_stations() -> None:
    assert station_labels(np.arange(26), np.zeros((26, 2))) == list(string.ascii_uppercase)


def test_of_27_stations_every_other_is_named_by_its_sweep() -> None:
    labels = station_labels(np.arange(100, 127), around(27))
    assert labels[:4] == ["100", "", "102", ""]
    assert labels[-1] == "126"


@pytest.mark.parametrize("count", [27, 52, 53, 1000, 12_345])
def test_many_stations_have_no_more_names_than_there_are_letters(count: int) -> None:
    labels = station_labels(np.arange(count), around(count))
    named = [number for number, label in enumerate(labels) if label]
    assert len(labels) == count
    assert MOST_LABELS // 2 <= len(named) <= MOST_LABELS
    assert [labels[number] for number in named] == [str(number) for number in named]
    assert len(set(np.diff(named))) == 1
