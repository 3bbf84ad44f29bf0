import numpy as np
import pytest
from numpy.typing import ArrayLike

from echoplan.geometry import crosses_discs, crosses_segments, distances_to_segments, is_blocked, outward_normals

EYE = (-1.0, -0.5)
BOARD = [[[1.0, -1.0], [1.0, 2.0]]]


@pytest.mark.parametrize("target", [(3.0, 4.4), (3.0, 4.5), (1.1, 0.0)])
def test_a_sight_line_crosses_a_board_that_stands_between_up_to_its_very_end(target: tuple[float, float]) -> None:
    assert crosses_segments([EYE], [target], BOARD).tolist() == [[True]]


@pytest.mark.parametrize("target", [(3.0, 4.6), (3.0, -1.6), (0.9, 0.0), (-3.0, 0.0)])
def test_a_sight_line_past_a_board_or_before_it_crosses_nothing(target: tuple[float, float]) -> None:
    assert crosses_segments([EYE], [target], BOARD).tolist() == [[False]]


def test_a_board_hides_neither_what_is_on_it_nor_what_is_seen_from_it() -> None:
    assert not crosses_segments([EYE, (1.0, 0.5)], [(1.0, 0.5), EYE], BOARD).any()


def test_a_sight_line_along_a_board_does_not_cross_it() -> None:
    assert not crosses_segments([[1.0, -3.0]], [[1.0, 3.0]], BOARD).any()


def test_every_sight_line_is_checked_against_every_board() -> None:
    boards = [*BOARD, [[-1.0, 0.5], [-1.0, 1.0]]]
    crossed = crosses_segments([[0.0, 0.1]] * 3, [[2.0, 0.0], [-2.0, 0.0], [-2.0, 1.5]], boards)
    assert crossed.tolist() == [[True, False], [False, False], [False, True]]


def test_a_sight_line_passes_a_disc_that_it_only_touches() -> None:
    discs = [[1.0, 0.5, 0.5], [1.0, 0.5, 0.51], [3.0, 0.0, 0.5]]
    assert crosses_discs([[0.0, 0.0]], [[2.0, 0.0]], discs).tolist() == [[False, True, False]]


def test_distances_are_from_the_nearest_point_of_a_segment() -> None:
    segments = [[[1.0, 0.0], [4.0, 0.0]], [[2.0, 5.0], [2.0, 5.0]]]
    distances = distances_to_segments([[2.0, 1.0], [-2.0, 4.0], [8.0, -3.0]], segments)
    assert distances == pytest.approx(np.array([[1.0, 4.0], [5.0, np.hypot(4, 1)], [5.0, 10.0]]))


def test_nothing_hides_anything_in_an_empty_world() -> None:
    assert is_blocked([[0.0, 0.0]], [[2.0, 0.0]], segments_xy=[], discs=[]).tolist() == [False]


def test_a_view_is_blocked_by_a_segment_or_a_disc() -> None:
    blocked = is_blocked(
        [[0.0, 0.0]] * 3,
        [[2.0, 0.0], [0.0, 2.0], [-2.0, 0.0]],
        segments_xy=BOARD,
        discs=[[0.1, 1.0, 0.2]],
    )
    assert blocked.tolist() == [True, True, False]


FACE = [[0.0, 0.0], [4.0, 0.0]]


def outward(face: ArrayLike, stations: ArrayLike, *others: ArrayLike) -> list[float]:
    """The outward normal of a face among others; upwards where no station decides."""
    faces = np.array([face, *others])
    normals = outward_normals(faces, stations, normals_xy=np.tile([0.0, 1.0], (len(faces), 1)))
    return [round(float(each), 9) + 0.0 for each in normals[0]]


@pytest.mark.parametrize("face", [FACE, FACE[::-1]])
def test_the_outer_side_of_a_face_is_away_from_its_stations_whichever_way_it_runs(face: ArrayLike) -> None:
    assert outward(face, [[1.0, 2.0], [3.0, 1.0]]) == [0.0, -1.0]
    assert outward(face, [[1.0, -2.0], [9.0, 1.0], [-9.0, 1.0]]) == [0.0, 1.0]


def test_stations_behind_another_face_do_not_decide() -> None:
    behind, before = [[1.0, -2.0], [2.0, -2.0], [3.0, -2.0]], [[2.0, 1.0]]
    assert outward(FACE, behind + before) == [0.0, 1.0]
    assert outward(FACE, behind + before, [[0.0, -0.1], [4.0, -0.1]]) == [0.0, -1.0]


def test_where_no_station_decides_the_given_normal_does() -> None:
    assert outward(FACE, np.zeros((0, 2))) == [0.0, 1.0]
    assert outward(FACE, [[1.0, 1.0], [3.0, -1.0]]) == [0.0, 1.0]
    assert outward_normals([], [[0.0, 0.0]], normals_xy=[]).shape == (0, 2)
