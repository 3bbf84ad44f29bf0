"""The random rooms in which benchmarks measure methods."""

from functools import cache

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import distances_to_segments
from echoplan.simulation import Simulation
from library.rooms import random_simulation

SEEDS = (2, 5)


@cache
def simulation(seed: int, stations: int = 14) -> Simulation:
    found = random_simulation(seed, stations=stations)
    assert isinstance(found, Simulation)
    return found


def right_angles(segments_xy: FloatArray) -> bool:
    ways = segments_xy[:, 1] - segments_xy[:, 0]
    return bool(np.allclose(np.abs(ways).min(axis=1), 0.0))


def test_a_seed_makes_the_same_room_again() -> None:
    again = random_simulation(5)
    np.testing.assert_array_equal(again.world.segments_xy, simulation(5).world.segments_xy)
    np.testing.assert_array_equal(again.route.map_from_base, simulation(5).route.map_from_base)
    assert again.settings == simulation(5).settings


def test_even_seeds_make_right_angles_and_odd_ones_do_not() -> None:
    assert right_angles(simulation(2).world.segments_xy)
    assert not right_angles(simulation(5).world.segments_xy)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_robot_can_stand_at_every_station(seed: int) -> None:
    world, stations_xy = simulation(seed).world, simulation(seed).route.map_from_base[:, :2]
    assert len(stations_xy) == 14
    assert distances_to_segments(stations_xy, world.segments_xy).min() > 0.33
    for pillar in world.pillars:
        assert np.hypot(*(stations_xy - pillar.center_xy).T).min() > 0.33 + pillar.radius


@pytest.mark.parametrize("seed", SEEDS)
def test_everything_stands_inside_the_room(seed: int) -> None:
    world = simulation(seed).world
    room, *boxes = (polyline.points_xy for polyline in world.polylines)
    inside = np.vstack([*boxes, *(pillar.center_xy for pillar in world.pillars)])
    assert (inside > room.min(axis=0)).all()
    assert (inside < room.max(axis=0)).all()
    assert 1 <= len(world.pillars) <= 3


def test_more_stations_stand_closer_together_in_the_same_room() -> None:
    few, many = simulation(2), simulation(2, stations=40)
    np.testing.assert_array_equal(few.world.segments_xy, many.world.segments_xy)
    assert len(many) == 40
    assert np.unique(many.route.map_from_base[:, :2], axis=0).shape == (40, 2)
