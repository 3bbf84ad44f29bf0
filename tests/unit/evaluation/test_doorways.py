from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from echoplan.evaluation.doorways import count_stations, true_doorways
from echoplan.geometry import directions
from echoplan.model import EVERYWHERE, Truth


def truth(*polygons: Any, lines: Any = (), poses: Any = ()) -> Truth:
    """A floor plan of closed polygons and single walls."""
    closed = [np.stack([np.array(each), np.roll(each, -1, axis=0)], axis=1) for each in polygons]
    walls = np.concatenate([*closed, np.reshape(np.array(lines, dtype=float), (-1, 2, 2))])
    return Truth(
        walls_xy=walls,
        walls_detected_by=np.full(len(walls), 9),
        poses=np.reshape(np.array(poses, dtype=float), (-1, 3)),
    )


def rooms(*, thickness: float = 0.12, door: tuple[float, float] = (1.0, 1.8)) -> list[list[float]]:
    """Outline of two rooms beside each other, joined by a door."""
    low, high = door
    left, right = 4.0, 4.0 + thickness
    west = [[left, high], [left, 3.0], [0.0, 3.0], [0.0, 0.0], [left, 0.0], [left, low]]
    return [*west, [right, low], [right, 0.0], [8.0, 0.0], [8.0, 3.0], [right, 3.0], [right, high]]


def test_both_faces_of_a_thick_wall_are_one_doorway() -> None:
    (doorway,) = true_doorways(truth(rooms()))
    assert doorway.width == pytest.approx(0.8)
    assert np.sort(doorway.endpoints_xy, axis=0) == pytest.approx(np.array([[4.06, 1.0], [4.06, 1.8]]))
    assert sorted(doorway.middles_xy[:, 0]) == pytest.approx([4.0, 4.06, 4.12])


def test_a_doorway_is_found_whichever_way_walls_are_drawn_and_turned() -> None:
    turned = np.array([directions(0.4), directions(0.4 + np.pi / 2)])
    plan = truth(np.array(rooms()) @ turned)
    plan = replace(plan, walls_xy=np.array([wall[:: (-1) ** k] for k, wall in enumerate(plan.walls_xy)]))
    (doorway,) = true_doorways(plan)
    assert doorway.width == pytest.approx(0.8)
    assert doorway.endpoints_xy.mean(axis=0) == pytest.approx(np.array([4.06, 1.4]) @ turned)


def test_a_gap_in_a_wall_without_thickness_is_a_doorway() -> None:
    outline = [[0, 0], [8, 0], [8, 3], [0, 3]]
    (doorway,) = true_doorways(truth(outline, lines=[[[4, 0], [4, 1]], [[4, 3], [4, 1.9]]]))
    assert doorway.width == pytest.approx(0.9)
    assert len(doorway.faces_xy) == 1


@pytest.mark.parametrize("depth", [-0.8, -0.4, 0.2, 0.4, 0.8])
def test_neither_a_niche_nor_a_pier_is_a_doorway(depth: float) -> None:
    assert true_doorways(truth([[0, 0], [1, 0], [1, -depth], [2, -depth], [2, 0], [4, 0], [4, 3], [0, 3]])) == ()


def test_a_gap_between_a_box_and_a_wall_is_no_doorway() -> None:
    box = [[1.0, 0.6], [2.0, 0.6], [2.0, 1.2], [1.0, 1.2]]
    assert true_doorways(truth([[0, 0], [4, 0], [4, 3], [0, 3]], box)) == ()


@pytest.mark.parametrize("depth", [0.3, 0.8])
def test_aligned_boxes_have_no_doorway_between_them(depth: float) -> None:
    boxes = [[[x, 1.0], [x + 0.8, 1.0], [x + 0.8, 1.0 + depth], [x, 1.0 + depth]] for x in (1.0, 2.5)]
    assert true_doorways(truth([[0, 0], [5, 0], [5, 4], [0, 4]], *boxes)) == ()


def test_a_box_in_line_with_a_wall_has_no_doorway_beside_it() -> None:
    room = [[0, 0], [2, 0], [2, -1], [5, -1], [5, 3], [0, 3]]
    assert true_doorways(truth(room, [[2, 1.0], [2.5, 1.0], [2.5, 1.5], [2, 1.5]])) == ()


def test_two_doors_in_one_wall_are_two_doorways() -> None:
    outline = [[0, 0], [8, 0], [8, 4], [0, 4]]
    thin = [[[4, 0], [4, 0.6]], [[4, 1.5], [4, 2.5]], [[4, 3.4], [4, 4]]]
    assert [doorway.width for doorway in true_doorways(truth(outline, lines=thin))] == pytest.approx([0.9, 0.9])


@pytest.mark.parametrize("door", [(1.0, 1.3), (0.0, 3.0)])
def test_a_slit_and_an_open_side_are_no_doorways(door: tuple[float, float]) -> None:
    assert true_doorways(truth(rooms(door=door))) == ()


@pytest.mark.parametrize(
    "wall", [[[4.06, 1.2], [4.06, 1.6]], [[3.8, 1.4], [3.9, 1.4]], [[3.7, 0.5], [3.7, 2.5]], [[4.0, 1.0], [4.0, 1.8]]]
)
def test_a_doorway_with_something_in_it_does_not_count(wall: Any) -> None:
    assert true_doorways(truth(rooms(), lines=[wall])) == ()


def stations(*poses: Any, reach: float = 4.0, lines: Any = ()) -> int:
    plan = truth(rooms(), lines=lines, poses=[[*xy, 0.0] for xy in np.array(poses)])
    (count,) = count_stations(true_doorways(plan), plan, reach=reach)
    return int(count)


def test_stations_face_a_doorway_if_their_perpendicular_ends_between_the_jambs() -> None:
    assert stations([1.0, 1.1], [2.0, 1.7], [2.0, 1.9], [2.0, 0.9]) == 2
    assert stations([1.0, 1.1], [2.0, 1.7], reach=2.5) == 1


def test_stations_behind_another_wall_do_not_face_a_doorway() -> None:
    assert stations([1.0, 1.1], [3.0, 1.7], lines=[[[2.0, 0.5], [2.0, 2.0]]]) == 1


def test_a_doorway_on_the_path_counts_from_everywhere() -> None:
    assert stations([3.0, 0.5], [5.0, 2.1]) == EVERYWHERE
    assert stations([3.0, 0.5], [4.06, 1.4], [3.0, 0.5]) == EVERYWHERE
    assert stations([3.0, 0.5], [3.5, 2.5]) == 0


def test_without_poses_every_doorway_counts() -> None:
    plan = truth(rooms())
    assert count_stations(true_doorways(plan), plan, reach=4.0).tolist() == [EVERYWHERE]
