"""Areas of rooms: right to the last digit where walls and openings close them, and nowhere else."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

from echoplan.model import FeatureMap, Opening, UnobservedStretch, Wall
from echoplan.viewer.rooms import closed_rooms
from helpers import maps

SQUARE = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]


def ring(corners: ArrayLike) -> list[Wall]:
    """Walls around a polygon."""
    points = np.array(corners, dtype=np.float64)
    return [maps.wall(start, end) for start, end in zip(points, np.roll(points, -1, axis=0), strict=True)]


def doorway(*, walls: tuple[int, ...], y: float = 0.0) -> Opening:
    """A doorway from 1.0 to 1.9 m."""
    return Opening(endpoints_xy=np.array([[1.0, y], [1.9, y]]), width_sigma=0.01, walls=walls, passed=True)


def floor_with_a_gap() -> FeatureMap:
    """The square, but for a gap of 0.9 m in its floor."""
    floor = [maps.wall([0.0, 0.0], [1.0, 0.0]), maps.wall([1.9, 0.0], [4.0, 0.0])]
    return maps.drawn(*floor, *ring(SQUARE)[1:], poses=[[2.0, 1.5, 0.0]])


def areas(found: FeatureMap) -> list[float]:
    return [room.area for room in closed_rooms(found)]


@pytest.mark.parametrize("poses", [[], [[1.0, 1.0, 0.0]]])
def test_a_room_of_4_by_3_metres_has_12_square_metres(poses: ArrayLike) -> None:
    assert areas(maps.drawn(*ring(SQUARE), poses=poses)) == pytest.approx([12.0])


def test_coordinates_of_surveyors_change_no_area() -> None:
    far = np.add(SQUARE, [412_345.678, 5_812_345.123])
    assert areas(maps.drawn(*ring(far))) == pytest.approx([12.0], abs=1e-6)


def test_an_l_shaped_room_has_the_area_of_both_its_parts() -> None:
    walls = [maps.wall(start, end) for start, end in maps.ROOM.walls_xy]
    assert areas(maps.drawn(*walls)) == pytest.approx([5.0 * 1.5 + 2.0 * 1.5])


def test_a_gap_leaves_a_room_open_and_an_opening_closes_it() -> None:
    assert areas(floor_with_a_gap()) == []
    closed = replace(floor_with_a_gap(), openings=(doorway(walls=(0, 1)),))
    assert areas(closed) == pytest.approx([12.0])


def test_an_unobserved_stretch_leaves_a_room_open() -> None:
    stretch = UnobservedStretch(endpoints_xy=np.array([[1.0, 0.0], [1.9, 0.0]]), walls=(0, 1))
    assert areas(replace(floor_with_a_gap(), unobserved=(stretch,))) == []


def test_a_doorway_in_a_partition_closes_the_rooms_on_both_sides_along_their_own_faces() -> None:
    upper = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]]
    lower = [[0.0, -2.1], [4.0, -2.1], [4.0, -0.1], [0.0, -0.1]]
    faces = [maps.wall([left, y], [right, y]) for y in (0.0, -0.1) for left, right in ((0.0, 1.0), (1.9, 4.0))]
    walls = [*faces, *ring(upper)[1:], *ring(lower)[:2], ring(lower)[3]]
    stations = [[2.0, 1.0, 0.0], [2.0, -1.0, 0.0]]
    found = replace(maps.drawn(*walls, poses=stations), openings=(doorway(walls=(0, 1, 2, 3), y=-0.05),))
    assert areas(found) == pytest.approx([12.0, 8.0])


def test_an_opening_without_walls_on_both_sides_closes_along_its_own_line() -> None:
    walls = [maps.wall([0.0, 0.0], [1.0, 0.0]), maps.wall([1.9, 0.0], [1.9, 3.0]), *ring(SQUARE)[2:]]
    found = replace(maps.drawn(*walls, poses=[[1.0, 1.0, 0.0]]), openings=(doorway(walls=(0,)),))
    assert areas(found) == pytest.approx([1.9 * 3.0])


def test_ends_that_miss_each_other_by_centimetres_meet_and_by_decimetres_do_not() -> None:
    for gap, expected in ((0.04, [12.0]), (0.2, [])):
        walls = [maps.wall([gap, 0.0], [4.0, 0.0]), *ring(SQUARE)[1:]]
        assert areas(maps.drawn(*walls)) == pytest.approx(expected)


def test_what_the_robot_drove_around_is_no_room_and_its_area_is_not_floor() -> None:
    shaft = ring([[1.0, 1.0], [3.0, 1.0], [3.0, 2.0], [1.0, 2.0]])
    assert areas(maps.drawn(*ring(SQUARE), *shaft, poses=[[0.5, 0.5, 0.0]])) == pytest.approx([10.0])


def test_furniture_of_which_one_end_is_free_takes_no_area() -> None:
    screen = maps.wall([2.0, 0.0], [2.0, 1.0])
    assert areas(maps.drawn(*ring(SQUARE), screen, poses=[[0.5, 0.5, 0.0]])) == pytest.approx([12.0])


def test_a_room_says_whether_its_walls_were_inferred() -> None:
    first, *rest = ring(SQUARE)
    for inferred in (0.0, 0.5):
        wall = replace(first, inferred=np.array([inferred, 0.0]))
        (room,) = closed_rooms(maps.drawn(wall, *rest))
        assert room.is_inferred is bool(inferred)


def test_a_map_without_walls_has_no_rooms() -> None:
    assert closed_rooms(FeatureMap(method="joint")) == ()
