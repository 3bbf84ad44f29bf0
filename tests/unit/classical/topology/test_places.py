"""Places and passages in free space that is drawn by hand."""

import numpy as np
import pytest

from echoplan.classical.topology import FreeSpace, PlaceSettings, find_places


def plan(text: str, *, resolution: float = 0.2) -> FreeSpace:
    """Free space as drawn: the first line is the highest, dots are free."""
    rows = [list(line.strip()) for line in text.strip().splitlines()]
    return FreeSpace(origin_xy=np.array([1.0, -2.0]), resolution=resolution, data=(np.array(rows) == ".")[::-1])


TWO_ROOMS = plan(
    """
    #########################
    #........###............#
    #........###............#
    #........###............#
    #.......................#
    #.......................#
    #........###............#
    #........###............#
    #........###............#
    #........###............#
    #########################
    """
)


def test_two_rooms_joined_by_a_door_are_two_places_and_a_passage() -> None:
    graph = find_places(TWO_ROOMS)
    assert len(graph.places) == 2
    (passage,) = graph.passages
    assert passage.position_xy == pytest.approx([1.0 + 10.5 * 0.2, -2.0 + 6.0 * 0.2], abs=0.4)
    assert passage.width == pytest.approx(0.4, abs=0.25)


def test_places_share_all_that_is_free() -> None:
    graph = find_places(TWO_ROOMS)
    assert sum(place.area for place in graph.places) == pytest.approx(TWO_ROOMS.area)


def test_the_middle_of_a_place_is_where_there_is_most_room() -> None:
    larger, smaller = find_places(TWO_ROOMS).places
    assert larger.clearance >= smaller.clearance
    assert larger.center_xy[0] == pytest.approx(1.0 + 18 * 0.2, abs=0.8)
    assert smaller.center_xy == pytest.approx([1.0 + 5 * 0.2, -2.0 + 5.5 * 0.2], abs=0.3)
    assert smaller.clearance == pytest.approx(0.8, abs=0.15)


def test_three_rooms_in_a_row_are_a_chain() -> None:
    rooms = plan(
        """
        ##########################
        #......##......##........#
        #......##......##........#
        #........................#
        #......##......##........#
        #......##......##........#
        ##########################
        """
    )
    graph = find_places(rooms)
    by_x = sorted(range(3), key=lambda number: graph.places[number].center_xy[0])
    assert len(graph.passages) == 2
    assert graph.neighbours(by_x[1]) == tuple(sorted((by_x[0], by_x[2])))
    assert graph.neighbours(by_x[0]) == (by_x[1],)


def test_rooms_without_a_door_are_not_joined() -> None:
    apart = plan("############\n#....##....#\n#....##....#\n#....##....#\n#....##....#\n############", resolution=0.4)
    graph = find_places(apart)
    assert (len(graph.places), graph.passages) == (2, ())


def test_one_room_is_one_place_even_if_it_is_long() -> None:
    hall = FreeSpace(origin_xy=np.zeros(2), resolution=0.1, data=np.ones((15, 120), dtype=np.bool_))
    graph = find_places(hall)
    assert (len(graph.places), graph.passages) == (1, ())


def test_a_niche_is_no_place() -> None:
    niche = plan(
        "#########\n#.......#\n#.......#\n#.......#\n#.......#\n####.####\n###...###\n####.####\n#########",
        resolution=0.4,
    )
    assert len(find_places(niche).places) == 1


def test_a_narrowing_that_is_wide_enough_parts_nothing() -> None:
    assert len(find_places(TWO_ROOMS, PlaceSettings(max_narrowing=0.1)).places) == 1


def test_the_same_rooms_turned_about_give_the_same_graph() -> None:
    turned = FreeSpace(origin_xy=np.zeros(2), resolution=0.2, data=TWO_ROOMS.data.T)
    graph, other = find_places(TWO_ROOMS), find_places(turned)
    assert [place.area for place in graph.places] == pytest.approx([place.area for place in other.places], abs=0.3)
    assert graph.passages[0].width == pytest.approx(other.passages[0].width)


def test_where_nothing_is_free_there_is_no_place() -> None:
    nothing = FreeSpace(origin_xy=np.zeros(2), resolution=0.1, data=np.zeros((3, 4), dtype=np.bool_))
    graph = find_places(nothing)
    assert (graph.places, graph.passages) == ((), ())
