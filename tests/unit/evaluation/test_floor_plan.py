from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

from echoplan.evaluation import FloorPlanScore, MatchingSettings, evaluate, floor_plan_tables
from echoplan.evaluation.floor_plan import match_openings
from echoplan.model import FeatureMap, Opening, Truth, Wall
from helpers import maps

# Two rooms, joined by a door of 0.9 m in a wall that is 0.2 m thick; the path leads through it.
DOOR = np.array([[4.1, 1.0], [4.1, 1.9]])
OUTLINE = np.array(
    [
        *([4.0, 1.9], [4.0, 3.0], [0.0, 3.0], [0.0, 0.0], [4.0, 0.0], [4.0, 1.0]),
        *([4.2, 1.0], [4.2, 0.0], [8.0, 0.0], [8.0, 3.0], [4.2, 3.0], [4.2, 1.9]),
    ]
)
FLAT = Truth(
    walls_xy=np.stack([OUTLINE, np.roll(OUTLINE, -1, axis=0)], axis=1),
    walls_detected_by=np.full(len(OUTLINE), 5),
    poses=np.array([[2.0, 1.5, 0.0], [6.0, 1.5, 0.0]]),
)
WALLS = tuple(maps.wall(*ends) for ends in FLAT.walls_xy)


def opening(start: ArrayLike, end: ArrayLike, *, sigma: float = 0.01) -> Opening:
    return Opening(endpoints_xy=np.array([start, end], dtype=float), width_sigma=sigma, walls=())


def score(*walls: Wall, openings: tuple[Opening, ...] = (), truth: Truth = FLAT) -> FloorPlanScore:
    return evaluate(FeatureMap(method="by hand", walls=walls, openings=openings), truth).floor_plan


def test_the_true_floor_plan_is_right_in_everything() -> None:
    found = score(*WALLS, openings=(opening(*DOOR),))
    assert [found.lengths.recall, found.lengths.precision, found.lengths.walked_through] == pytest.approx([1, 1, 0])
    assert (found.openings.wanted, found.openings.recall, found.openings.precision) == (1, 1.0, 1.0)
    assert [found.opening_widths.mean, found.opening_widths.share_inside] == pytest.approx([0.0, 1.0])
    assert found.wall_ends.mean == pytest.approx(0.0, abs=1e-9)


def test_a_wall_across_a_doorway_is_wrong_there_and_walked_through() -> None:
    across = maps.wall((4.0, 0.0), (4.0, 3.0))
    found = score(across)
    assert found.lengths.walked_through == 1
    # Of 3 m, the door of 0.9 m is wrong, but for 5 cm beside each jamb.
    assert found.lengths.precision == pytest.approx(2.2 / 3, abs=0.01)
    assert found.openings.recall == 0.0
    assert score(across, truth=replace(FLAT, poses=np.zeros((0, 3)))).lengths.walked_through == 0


def test_only_walls_that_enough_stations_detect_count_for_the_length_recall() -> None:
    two = replace(FLAT, walls_detected_by=np.where(np.arange(len(WALLS)) < 2, 2, 1))
    assert score(WALLS[0], truth=two).lengths.recall == pytest.approx(1.1 / 5.1, abs=0.02)
    assert np.isnan(
        score(WALLS[0], truth=replace(FLAT, walls_detected_by=np.zeros(len(WALLS), dtype=int))).lengths.recall
    )
    assert np.isnan(score().lengths.precision)


@pytest.mark.parametrize("x", [4.0, 4.1, 4.2])
def test_an_opening_may_be_drawn_in_either_face_or_between_them(x: float) -> None:
    found = score(openings=(opening([x, 1.05], [x, 2.0], sigma=0.02),))
    assert (found.openings.right, found.openings.spurious) == (1, 0)
    assert found.opening_widths.bias == pytest.approx(0.05)
    assert found.opening_widths.share_inside == 0.0


@pytest.mark.parametrize(
    "ends",
    [([4.1, 1.45], [4.1, 2.35]), ([4.25, 1.0], [3.95, 1.9]), ([1.0, 1.0], [2.0, 1.0]), ([3.65, 1.45], [4.55, 1.45])],
)
def test_an_opening_elsewhere_or_askew_is_spurious(ends: tuple[ArrayLike, ArrayLike]) -> None:
    found = score(openings=(opening(*ends),)).openings
    assert (found.right, found.spurious, found.recall, found.precision) == (0, 1, 0.0, 0.0)


def test_the_nearest_of_two_openings_for_one_doorway_is_right_and_the_other_a_duplicate() -> None:
    estimates = (opening([4.2, 1.05], [4.2, 2.0]), opening(*DOOR))
    found = match_openings(estimates, FLAT, MatchingSettings())
    assert [match.estimate for match in found.right] == [1]
    assert found.tally.precision == 0.5


def test_a_doorway_that_no_station_faces_counts_neither_for_nor_against_a_map() -> None:
    apart = replace(FLAT, poses=np.array([[2.0, 0.5, 0.0], [1.0, 0.5, 0.0]]))
    for openings in ((), (opening(*DOOR),)):
        found = score(openings=openings, truth=apart).openings
        assert (found.wanted, found.right, found.spurious, found.duplicate) == (0, 0, 0, 0)
    assert score(openings=(opening([1.0, 1.0], [2.0, 1.0]),), truth=apart).openings.precision == 0.0


def test_as_many_stations_must_face_a_doorway_as_must_detect_a_wall() -> None:
    faced = replace(FLAT, poses=np.array([[2.0, 1.5, 0.0], [1.0, 1.5, 0.0]]))
    assert match_openings((), faced, MatchingSettings()).tally.wanted == 1
    assert match_openings((), faced, MatchingSettings(min_stations=3)).tally.wanted == 0
    assert match_openings((), faced, MatchingSettings(opening_reach=2.5)).tally.wanted == 0


def test_ends_of_walls_are_too_long_or_too_short_whichever_way_the_wall_is_drawn() -> None:
    wall = replace(maps.wall((4.02, 3.0), (0.05, 3.0)), endpoint_sigmas=np.array([0.02, 0.02]))
    ends = score(wall).wall_ends
    assert ends.errors == pytest.approx([0.02, -0.05])
    assert ends.share_inside == 0.5
    assert np.isnan(score(maps.wall((4.02, 3.0), (0.05, 3.0))).wall_ends.share_inside)


def test_scores_of_several_maps_add_up() -> None:
    both = score(*WALLS, openings=(opening(*DOOR),)) + score(maps.wall((4.0, 0.0), (4.0, 3.0)))
    assert both.lengths.walked_through == 1
    assert both.openings.recall == 0.5
    assert both.lengths.drawn == pytest.approx(sum(wall.length for wall in WALLS) + 3.0)
    assert len(both.wall_ends.errors) == 2 * len(WALLS)  # the wall across the doorway is of no true wall


def test_openings_have_a_table_only_where_there_are_any() -> None:
    (walls,) = floor_plan_tables({"joint": score(*WALLS, truth=maps.ROOM)}, rows="method")
    assert walls.rows[0][0] == "joint"
    _, openings = floor_plan_tables({"joint": score(openings=(opening([4.1, 1.0], [4.1, 1.88]),))}, rows="method")
    assert openings.rows == (("joint", "1", "100.0", "100.0", "20.0", "-20.0", "0.0"),)
    for table in (walls, openings):
        assert {len(row) for row in table.rows} == {len(table.columns)}
