import numpy as np

from echoplan.evaluation.vertices import true_vertices
from echoplan.model import Truth
from helpers import maps


def test_a_vertex_is_detected_as_often_as_the_less_detected_of_its_two_walls() -> None:
    vertices = true_vertices(maps.ROOM)
    assert vertices.positions_xy.tolist() == [[0, 0], [0, 3], [2, 1.5], [2, 3], [5, 0], [5, 1.5]]
    assert vertices.detected_by.tolist() == [1, 1, 2, 2, 4, 3]


def test_the_free_end_of_a_wall_and_the_meeting_of_three_do_not_count() -> None:
    spokes = Truth(walls_xy=[[[0, 0], [1, 0]], [[0, 0], [0, 2]], [[-3, 0], [0, 0]]], walls_detected_by=[5, 5, 5])  # type: ignore[arg-type]
    assert true_vertices(spokes).detected_by.tolist() == [0, 0, 0, 0]


def test_ends_that_differ_by_rounding_are_one_vertex() -> None:
    faces = np.array([[[0.0, 0.0], [1.0, 2.0]], [[1.00001, 1.99999], [3.0, 0.0]]])
    vertices = true_vertices(Truth(walls_xy=faces, walls_detected_by=np.array([3, 7])))
    assert vertices.positions_xy.tolist() == [[0, 0], [1, 2], [3, 0]]
    assert vertices.detected_by.tolist() == [0, 3, 0]


def test_an_empty_truth_has_no_vertices() -> None:
    assert true_vertices(maps.NOWHERE).positions_xy.shape == (0, 2)
