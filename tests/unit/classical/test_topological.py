"""Rooms and doors from simulated echoes."""

import numpy as np
import pytest

from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper
from echoplan.classical.topological import TopologicalMapper
from echoplan.methods import map_sweeps
from echoplan.model import Recording
from helpers.simulated_worlds import array, simulation, world


@pytest.fixture(scope="module")
def two_rooms() -> Recording:
    """Two rooms of 2.4 m by 3 m, and a door of 0.7 m in the wall between them."""
    walls: list[list[float]] = [[0, 0], [2.4, 0], [2.4, 1.2], [2.6, 1.2], [2.6, 0], [5.2, 0]]
    walls += [[5.2, 3], [2.6, 3], [2.6, 1.9], [2.4, 1.9], [2.4, 3], [0, 3]]
    left = [[0.8, 0.8, 0.0], [0.8, 2.2, 0.4], [1.7, 2.3, 0.8], [1.6, 0.8, 0.1], [1.2, 1.6, 0.5]]
    right = [[3.9, 1.5, 0.1], [3.5, 0.8, 0.3], [3.4, 2.2, 0.9], [4.3, 0.8, 0.2], [4.4, 2.1, 0.4]]
    poses = [*left, [2.5, 1.55, 0.6], *right]
    made = simulation(world(walls, closed=True), using=array(), poses=poses, jitter=0.001)
    return Recording(name="two rooms", rig=made.rig, sweeps=tuple(made))


@pytest.fixture(scope="module")
def mapper(two_rooms: Recording) -> TopologicalMapper:
    made = TopologicalMapper(two_rooms.rig)
    for sweep in two_rooms:
        made.add(sweep)
    return made


def test_two_rooms_joined_by_a_door_are_two_places_and_one_passage(mapper: TopologicalMapper) -> None:
    graph = mapper.graph()
    assert sorted(place.center_xy[0] > 2.5 for place in graph.places) == [False, True]
    (passage,) = graph.passages
    assert np.hypot(*(passage.position_xy - [2.5, 1.55])) < 0.2
    assert graph.neighbours(0) == (1,)


def test_a_door_comes_out_wider_than_it_is(mapper: TopologicalMapper) -> None:
    (passage,) = mapper.graph().passages
    # Jambs are edges, which answer hardly at all: beams that slip past them show the space beside the door as free.
    assert 0.7 < passage.width < 1.5


def test_the_middle_of_each_room_is_free_and_the_world_outside_is_not(mapper: TopologicalMapper) -> None:
    free = mapper.free_space()
    assert free.at([[1.2, 1.5], [3.9, 1.5], [2.5, 1.55]]).all()
    assert not free.at([[2.5, 0.2], [2.5, 2.8], [-0.8, 1.5], [6.0, 1.5]]).any()


def test_the_walls_are_those_of_the_papers_method(mapper: TopologicalMapper, two_rooms: Recording) -> None:
    found, alone = mapper.result(), map_sweeps(MdpFuzzyMapper(two_rooms.rig), two_rooms)
    assert found.method == "topological"
    assert [wall.offset for wall in found.walls] == [wall.offset for wall in alone.walls]


def test_without_echoes_there_is_no_place(two_rooms: Recording) -> None:
    graph = TopologicalMapper(two_rooms.rig).graph()
    assert (graph.places, graph.passages) == ((), ())
