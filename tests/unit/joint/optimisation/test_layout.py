import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS, Layout

KINDS = np.array([Kind.WALL, Kind.CYLINDER, Kind.CORNER, Kind.CYLINDER, Kind.EDGE], dtype=np.int64)


def test_only_cylinders_have_a_third_parameter() -> None:
    assert Layout(kinds=KINDS).counts.tolist() == [2, 3, 2, 3, 2]


def test_landmarks_are_contiguous_in_the_layout() -> None:
    layout = Layout(kinds=KINDS)
    places = [list(range(layout.size))[layout.feature(number)] for number in range(len(KINDS))]
    assert [each for place in places for each in place] == list(range(layout.sonar))
    assert layout.starts.tolist() == [place[0] for place in places]


def test_columns_are_the_positions_of_the_parameters() -> None:
    columns = Layout(kinds=KINDS).columns
    assert columns.tolist() == [[0, 1, -1], [2, 3, 4], [5, 6, -1], [7, 8, 9], [10, 11, -1], [-1, -1, -1]]


def test_the_layout_is_landmarks_then_sonar_then_poses() -> None:
    trusted, free = Layout(kinds=KINDS), Layout(kinds=KINDS, poses=4)
    assert trusted.sonar == free.sonar == 12
    assert trusted.pose == free.pose == 12 + len(SONAR_UNKNOWNS)
    assert trusted.size == trusted.pose
    assert free.size == free.pose + 3 * 4


def test_without_landmarks_only_the_sonar_is_variable() -> None:
    layout = Layout(kinds=np.zeros(0, dtype=np.int64))
    assert (layout.sonar, layout.size) == (0, len(SONAR_UNKNOWNS))
    assert layout.starts.tolist() == []
    assert layout.steps(np.ones(layout.size)).shape == (0, 3)


def test_a_step_is_split_by_landmark() -> None:
    layout = Layout(kinds=KINDS, poses=2)
    steps = layout.steps(np.arange(1.0, layout.size + 1))
    assert steps.tolist() == [[1, 2, 0], [3, 4, 5], [6, 7, 0], [8, 9, 10], [11, 12, 0]]
