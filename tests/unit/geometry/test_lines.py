import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import along, directions, feet, intersections, lines_through, path_crossings, signed_distances

# The line 3x + 4y = 10: its normal (0.6, 0.8), its offset 2.
LINE = (np.arctan2(4.0, 3.0), 2.0)


def test_a_line_through_two_points_has_its_normal_to_the_right_of_the_way() -> None:
    there, back = lines_through([[2.0, 1.0], [-2.0, 4.0]], [[-2.0, 4.0], [2.0, 1.0]])
    assert there == pytest.approx(LINE)
    assert np.cos(back[0] - LINE[0]) == pytest.approx(-1.0)
    assert back[1] == pytest.approx(-2.0)


def test_distances_are_positive_on_the_side_of_the_normal() -> None:
    assert signed_distances(LINE, [[0.0, 0.0], [3.0, 4.0], [2.0, 1.0]]) == pytest.approx([-2.0, 3.0, 0.0])


def test_coordinates_along_a_line_grow_a_quarter_turn_counter_clockwise_of_its_normal() -> None:
    assert along(LINE, [[1.2, 1.6], [-2.0, 4.0], [2.0, 1.0]]) == pytest.approx([0.0, 4.0, -1.0])


def test_the_foot_is_where_the_perpendicular_meets_the_line() -> None:
    assert feet(LINE, [0.0, 0.0]) == pytest.approx([1.2, 1.6])
    assert feet(LINE, [3.0 - 0.8, 4.0 + 0.6]) == pytest.approx([1.2 - 0.8, 1.6 + 0.6])


def test_lines_cross_in_the_point_on_both() -> None:
    assert intersections(LINE, (0.0, -2.0)) == pytest.approx([-2.0, 4.0])
    # The line 4x - 3y = 5.
    assert intersections((np.arctan2(-3.0, 4.0), 1.0), LINE) == pytest.approx([2.0, 1.0])


def test_parallel_lines_cross_nowhere() -> None:
    assert np.isnan(intersections(LINE, (LINE[0], 1.0))).all()
    assert np.isnan(intersections(LINE, (LINE[0] + np.pi, -2.0))).all()


def test_lines_and_points_broadcast_item_by_item() -> None:
    lines = np.array([LINE, (0.0, 1.0), (np.pi / 2, 1.0)])
    points = np.array([[0.0, 0.0], [5.0, 7.0]])
    distances = signed_distances(lines[:, None], points)
    assert distances == pytest.approx(np.array([[-2.0, 6.6], [-1.0, 4.0], [-1.0, 6.0]]))


def test_a_path_crosses_a_line_where_it_changes_sides() -> None:
    line, path = np.array([0.0, 2.0]), np.array([[0.0, 0.0], [4.0, 1.0], [4.0, 3.0], [1.0, 3.0], [1.0, 5.0]])
    assert path_crossings(line, path) == pytest.approx([0.5, 3.0])
    assert len(path_crossings(line, path[:1])) == len(path_crossings(line, path[:0])) == 0


@pytest.mark.parametrize("line", [np.array([0.7, 1.2]), np.array([-2.5, 0.4])])
def test_crossings_of_a_slanted_line_lie_on_the_path(line: FloatArray) -> None:
    path = np.array([[-3.0, -2.0], [3.0, 2.5]])
    (place,) = path_crossings(line, path)
    point = line[1] * directions(line[0]) + place * directions(line[0] + np.pi / 2)
    shares = (point - path[0]) / (path[1] - path[0])
    assert shares[0] == pytest.approx(shares[1])
