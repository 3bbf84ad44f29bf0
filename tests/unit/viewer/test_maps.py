from dataclasses import replace

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.patches import Circle, Ellipse, Polygon

from echoplan.model import Changes, Corner, CornerKind, FeatureClass, FeatureMap
from echoplan.viewer.maps import (
    draw_corners,
    draw_cylinders,
    draw_ellipses,
    draw_openings,
    draw_plan,
    draw_stations,
    draw_truth,
    draw_walls,
)
from echoplan.viewer.palette import COLORS, MARKERS, TRUTH
from echoplan.viewer.plan import Plan
from echoplan.viewer.uncertainty import error_ellipse
from helpers.canvas import axes_of, color, data, legend, line, lines, names, notes
from helpers.drawings import STATIONS, full_plan, gapped_map
from helpers.maps import NOWHERE, ROOM, corner, cylinder, drawn, wall

INSIDE = np.array([[2.0, 1.0]])
WALLS = (wall([0.0, 0.0], [4.0, 0.0]), wall([4.0, 0.0], [4.0, 3.0]))
EDGE = Corner(position_xy=np.array([2.0, 1.5]), kind=CornerKind.CONVEX, covariance=np.eye(2))


@pytest.fixture(scope="module")
def whole() -> Axes:
    return axes_of(lambda axes: draw_plan(axes, full_plan()))


def patches(axes: Axes, kind: type) -> list[object]:
    return [each for each in axes.patches if type(each) is kind]


def middle(patch: Circle | Ellipse) -> list[float]:
    return [float(each) for each in np.ravel(patch.get_center())]


def test_walls_are_filled_from_their_faces_backwards() -> None:
    axes = axes_of(lambda axes: draw_walls(axes, WALLS[:1], INSIDE, thickness=0.1))
    (body,) = axes.patches
    assert isinstance(body, Polygon)
    np.testing.assert_allclose(body.get_xy()[:4], [[0.0, 0.0], [4.0, 0.0], [4.0, -0.1], [0.0, -0.1]], atol=1e-12)
    assert to_hex(body.get_facecolor()) == COLORS[FeatureClass.WALL]


def test_of_many_walls_one_is_explained() -> None:
    axes = axes_of(lambda axes: draw_walls(axes, WALLS, INSIDE, thickness=0.1))
    assert [each.get_label() for each in axes.patches].count("wall") == 1
    assert len(axes.patches) == 2


@pytest.mark.parametrize("number", range(2))
def test_the_sides_of_all_walls_are_drawn_from_where_they_were_detected(number: int) -> None:
    axes = axes_of(lambda axes: draw_walls(axes, WALLS, INSIDE, thickness=0.1))
    body = axes.patches[number]
    assert isinstance(body, Polygon)
    np.testing.assert_allclose(body.get_xy()[:2], WALLS[number].endpoints_xy)
    assert not body.get_path().contains_point(tuple(INSIDE[0]))


def test_concave_corners_are_full_and_convex_ones_hollow() -> None:
    axes = axes_of(lambda axes: draw_corners(axes, [corner([0.0, 0.0]), EDGE, corner([4.0, 0.0])]))
    concave, convex = line(axes, "concave corner"), line(axes, "convex corner")
    np.testing.assert_allclose(data(concave), [[0.0, 0.0], [4.0, 0.0]])
    np.testing.assert_allclose(data(convex), [[2.0, 1.5]])
    assert to_hex(str(concave.get_markerfacecolor())) == COLORS[FeatureClass.CORNER]
    assert convex.get_markerfacecolor() == "white"
    assert {concave.get_marker(), convex.get_marker()} == {MARKERS[FeatureClass.CORNER]}
    assert color(convex) == COLORS[FeatureClass.CORNER]


def test_a_kind_of_corner_that_is_not_there_is_not_explained() -> None:
    axes = axes_of(lambda axes: draw_corners(axes, [EDGE]))
    assert [each.get_label() for each in axes.lines] == ["convex corner"]


def test_cylinders_are_circles_of_their_radius() -> None:
    axes = axes_of(lambda axes: draw_cylinders(axes, [cylinder([1.0, 2.0], 0.25), cylinder([3.0, 0.5], 0.1)]))
    first, second = axes.patches
    assert isinstance(first, Circle)
    assert isinstance(second, Circle)
    assert [*middle(first), first.get_radius()] == [1.0, 2.0, 0.25]
    assert [*middle(second), second.get_radius()] == [3.0, 0.5, 0.1]
    assert to_hex(first.get_facecolor()) == COLORS[FeatureClass.CYLINDER]
    assert len(lines(axes, "cylinder")) == 1


def test_stations_are_joined_in_their_order_and_named() -> None:
    axes = axes_of(lambda axes: draw_stations(axes, drawn(poses=STATIONS)))
    way, marks = axes.lines
    places = [[x, y] for x, y, _ in STATIONS]
    np.testing.assert_allclose(data(way), places)
    np.testing.assert_allclose(data(marks), places)
    assert (way.get_linestyle(), marks.get_linestyle()) == (":", "None")
    assert marks.get_label() == "station"
    assert [note.get_text() for note in notes(axes)] == ["A", "B", "C"]
    np.testing.assert_allclose([note.xy for note in notes(axes)], places)


def test_the_paths_of_two_recordings_are_not_joined() -> None:
    found = replace(drawn(poses=STATIONS), changes=(Changes(first_sweep=1),))
    first, second, marks = axes_of(lambda axes: draw_stations(axes, found)).lines
    assert [len(data(line)) for line in (first, second, marks)] == [1, 2, 3]


def test_of_a_thousand_stations_a_few_are_named() -> None:
    axes = axes_of(lambda axes: draw_stations(axes, drawn(poses=np.zeros((1000, 3)))))
    assert len(data(axes.lines[1])) == 1000
    assert [note.get_text() for note in notes(axes)] == [str(number) for number in range(0, 1000, 39)]


def test_the_true_room_is_dashed_and_explained_once() -> None:
    axes = axes_of(lambda axes: draw_truth(axes, ROOM))
    assert len(axes.lines) == 6 + 2
    assert len(lines(axes, "true room")) == 1
    assert {color(each) for each in axes.lines} == {TRUTH}
    for drawn_wall, face in zip(axes.lines, ROOM.walls_xy, strict=False):
        np.testing.assert_allclose(data(drawn_wall), face)
        assert drawn_wall.is_dashed()


def test_true_cylinders_are_closed_circles() -> None:
    axes = axes_of(lambda axes: draw_truth(axes, ROOM))
    for drawn_circle, (x, y, radius) in zip(axes.lines[6:], ROOM.cylinders, strict=True):
        around = data(drawn_circle)
        np.testing.assert_allclose(np.hypot(*(around - [x, y]).T), radius)
        np.testing.assert_allclose(around[0], around[-1])


def test_a_room_of_nothing_is_not_drawn() -> None:
    assert len(axes_of(lambda axes: draw_truth(axes, NOWHERE)).lines) == 0


def test_ellipses_are_drawn_in_full_width_and_against_the_clock() -> None:
    leaning = error_ellipse([1.0, 2.0], [[2e-4, 1e-4], [1e-4, 2e-4]])
    axes = axes_of(lambda axes: draw_ellipses(axes, [leaning]))
    (patch,) = axes.patches
    assert isinstance(patch, Ellipse)
    assert middle(patch) == [1.0, 2.0]
    assert patch.get_width() == pytest.approx(2 * leaning.semi_axes[0])
    assert patch.get_height() == pytest.approx(2 * leaning.semi_axes[1])
    assert patch.get_width() > patch.get_height()
    assert patch.get_angle() % 180 == pytest.approx(45)
    assert not patch.get_fill()


@pytest.mark.parametrize(
    ("times", "name"),
    [(1, "95 % ellipse"), (2, "95 % ellipse, enlarged 2 times"), (10, "95 % ellipse, enlarged 10 times")],
)
def test_enlarged_ellipses_say_so(times: int, name: str) -> None:
    one = error_ellipse([0.0, 0.0], np.diag([4e-4, 1e-4]))
    axes = axes_of(lambda axes: draw_ellipses(axes, [one], magnification=times))
    (patch,) = axes.patches
    assert isinstance(patch, Ellipse)
    assert patch.get_width() == pytest.approx(2 * times * one.semi_axes[0])
    assert len(lines(axes, name)) == 1


@pytest.mark.parametrize("draw", [draw_corners, draw_cylinders, draw_ellipses])
def test_what_is_not_there_is_neither_drawn_nor_explained(draw: object) -> None:
    axes = axes_of(lambda axes: draw(axes, []))  # type: ignore[operator]
    assert not axes.lines
    assert not axes.patches


def test_a_whole_map_explains_all_that_is_on_it(whole: Axes) -> None:
    assert set(legend(whole)) == {
        "wall",
        "cylinder",
        "true room",
        "station",
        "95 % ellipse, enlarged 5 times",
        "concave corner",
        "convex corner",
    }


def test_a_whole_map_has_one_mark_for_each_thing(whole: Axes) -> None:
    assert len(patches(whole, Polygon)) == 6
    assert len(patches(whole, Circle)) == 1
    assert len(patches(whole, Ellipse)) == 3


def test_a_whole_map_is_in_metres_with_both_directions_alike(whole: Axes) -> None:
    assert names(whole) == ("x (m)", "y (m)")
    assert whole.get_aspect() == 1.0


def test_the_axes_of_a_map_hold_all_of_it(whole: Axes) -> None:
    (low_x, high_x), (low_y, high_y) = whole.get_xlim(), whole.get_ylim()
    low, high = full_plan().bounds_xy
    assert low_x <= low[0] <= high[0] <= high_x
    assert low_y <= low[1] <= high[1] <= high_y


def test_a_map_without_a_truth_draws_none() -> None:
    axes = axes_of(lambda axes: draw_plan(axes, replace(full_plan(), truth=None)))
    assert "true room" not in legend(axes)
    assert TRUTH not in {color(each) for each in axes.lines}


def test_a_map_of_nothing_has_axes_and_no_legend() -> None:
    axes = axes_of(lambda axes: draw_plan(axes, Plan(feature_map=FeatureMap(method="none"))))
    assert names(axes) == ("x (m)", "y (m)")
    assert legend(axes) == []


def test_a_map_of_one_feature_explains_just_that() -> None:
    axes = axes_of(lambda axes: draw_plan(axes, Plan(feature_map=drawn(wall([0.0, 0.0], [2.0, 1.0])))))
    assert legend(axes) == ["wall"]


def test_a_map_with_gaps_explains_them_and_writes_the_width_of_its_doorway() -> None:
    axes = axes_of(lambda axes: draw_plan(axes, Plan(feature_map=gapped_map())))
    assert {"wall", "inferred wall end", "unobserved", "opening"} <= set(legend(axes))
    assert [each.get_text() for each in notes(axes) if each.get_text().endswith(" m")] == ["0.90 m"]
    np.testing.assert_allclose(data(line(axes, "unobserved")), [[4.0, 0.0], [4.5, 0.0]])


def test_inferred_wall_ends_are_dashed_and_not_filled() -> None:
    found = gapped_map()
    axes = axes_of(lambda axes: draw_walls(axes, found.walls[-1:], INSIDE, thickness=0.1))
    (body,) = axes.patches
    assert isinstance(body, Polygon)
    assert body.get_xy()[:, 0].max() == pytest.approx(5.5)
    face, back = axes.lines
    np.testing.assert_allclose(data(face), [[5.5, 0.0], [6.0, 0.0]])
    np.testing.assert_allclose(data(back), [[6.0, -0.1], [5.5, -0.1]])
    assert all(each.is_dashed() for each in (face, back))


def test_openings_have_a_threshold_and_two_jambs() -> None:
    axes = axes_of(lambda axes: draw_openings(axes, gapped_map(), thickness=0.1))
    threshold, *jambs = axes.lines[:3]
    np.testing.assert_allclose(data(threshold), [[1.0, 0.0], [1.9, 0.0]])
    assert [data(each)[:, 0].tolist() for each in jambs] == [[1.0, 1.0], [1.9, 1.9]]
