"""Walls that absorb sound are found, from three stations or more."""

from functools import cache

import numpy as np
import pytest

from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Wall
from library.populations import soft_room
from library.rooms import random_simulation

pytestmark = pytest.mark.slow

SEED = 203


@cache
def mapped(material: str, stations: int) -> FeatureMap:
    """Map a room of which the first wall is of a material."""
    simulation = soft_room(random_simulation(SEED), side=0, material=material)
    return map_sweeps(JointMapper(simulation.rig), list(simulation)[:stations])


def soft_walls(found: FeatureMap) -> list[Wall]:
    return [wall for wall in found.walls if wall.reflection_loss]


def first_wall() -> np.ndarray:
    points: np.ndarray = random_simulation(SEED).world.polylines[0].points_xy[:2]
    return points


@pytest.mark.parametrize(("material", "loss"), [("foam", 13.0), ("upholstery", 7.2)])
def test_a_soft_wall_is_found_with_its_reflection_loss(material: str, loss: float) -> None:
    (wall,) = soft_walls(mapped(material, 14))
    assert wall.reflection_loss == pytest.approx(loss, abs=2.0)
    assert np.abs(first_wall() @ wall.normal_xy - wall.offset).max() < 0.01


def test_hard_rooms_have_no_soft_walls() -> None:
    assert soft_walls(mapped("hard", 14)) == []


def test_two_stations_do_not_make_a_wall_soft() -> None:
    assert soft_walls(mapped("foam", 2)) == []
