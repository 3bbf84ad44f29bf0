"""Doors of flats, from readings to the file of the map: found where the robot drove, and never drawn shut."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import crosses_segments
from echoplan.io import read_map, write_map
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Odometry, Opening
from echoplan.simulation import OdometryNoise, Simulation
from echoplan.sources import find_rig, find_route, find_world
from helpers.simulated_worlds import array, simulation, turning, world

# The jambs of the door of the two-room flat, midway between the faces of its wall.
JAMBS = np.array([[3.96, 1.6], [3.96, 2.45]])
DRIFT = {"along": 0.02, "lateral": 0.01, "yaw_per_metre": float(np.radians(1.0))}


@cache
def flat() -> FeatureMap:
    drive = Simulation(
        world=find_world("two-room-flat"), rig=find_rig("rotary-array"), route=find_route("two-room-flat"), seed=1
    )
    return map_sweeps(JointMapper(drive.rig), tuple(drive))


def small_flat(seed: int) -> tuple[Simulation, FloatArray]:
    """A drive from one room into another, the first one by drifting odometry, and the jambs of the door between."""
    rng = np.random.default_rng(seed)
    height, west, east, thickness = rng.uniform([2.2, 2.0, 2.0, 0.09], [2.8, 2.6, 2.6, 0.15])
    low = rng.uniform(0.5, height - 1.4)
    high, wall, end = low + rng.uniform(0.7, 0.9), west + thickness, west + thickness + east
    outline = [[0.0, 0.0], [west, 0.0], [west, low], [wall, low], [wall, 0.0], [end, 0.0]]
    outline += [[end, height], [wall, height], [wall, high], [west, high], [west, height], [0.0, height]]
    door = 0.5 * (low + high)
    way = [[0.5, height - 0.5], [0.5, 0.5 * height], [0.5, 0.5], [0.5 * west, 0.5], [west - 0.4, door]]
    way += [[west + 0.5 * thickness, door], [wall + 0.4, door], [wall + 0.5 * east, height - 0.5]]
    way += [[end - 0.5, height - 0.5], [end - 0.5, 0.5 * height], [end - 0.5, 0.5], [wall + 0.5 * east, 0.5]]
    ahead = np.diff(way, axis=0, append=[way[-1]])
    poses = np.column_stack([way, np.arctan2(ahead[:, 1], ahead[:, 0])])
    odometry = OdometryNoise(**({} if seed else DRIFT))
    rig = replace(array(), servo=turning(-45, 45, 3), odometry=None if seed else Odometry(**DRIFT))
    drive = simulation(world(outline, closed=True), using=rig, poses=poses, seed=seed, odometry=odometry)
    return drive, np.array([low, high])


def crossed_walls(found: FeatureMap) -> int:
    """How many walls the path between the poses crosses."""
    path, walls = found.poses[:, :2], np.array([each.endpoints_xy for each in found.walls])
    return int(crosses_segments(path[:-1], path[1:], walls).any(axis=0).sum())


def sigma_at(found: FeatureMap, door: Opening, y: float) -> float:
    """How surely the walls beside a door end there."""
    (sigma, *_) = {
        float(sigma)
        for wall in (found.walls[each] for each in door.walls)
        for sigma, end in zip(wall.endpoint_sigmas, wall.endpoints_xy, strict=True)
        if abs(end[1] - y) < 1e-6
    }
    return sigma


def test_the_door_of_a_flat_is_found_where_the_robot_drove_through() -> None:
    found = flat()
    (door,) = found.openings
    assert door.passed
    ends = door.endpoints_xy[np.argsort(door.endpoints_xy[:, 1])]
    assert ends[:, 0] == pytest.approx(JAMBS[:, 0], abs=0.02)
    for end, jamb in zip(ends, JAMBS, strict=True):
        assert abs(end[1] - jamb[1]) < max(0.05, 1.96 * sigma_at(found, door, end[1]))
    assert abs(door.width - 0.85) < max(0.05, 1.96 * door.width_sigma)
    assert found.unobserved == ()


def test_the_walls_beside_a_door_end_at_its_jambs() -> None:
    found = flat()
    (door,) = found.openings
    assert len(door.walls) == 4
    for number in door.walls:
        gaps = np.abs(found.walls[number].endpoints_xy[:, None, 1] - door.endpoints_xy[None, :, 1])
        assert gaps.min() < 1e-6


def test_no_wall_of_a_flat_is_drawn_where_the_robot_drove() -> None:
    assert crossed_walls(flat()) == 0
    # All faces but the stubs that no station faced are there: the door is not free because nothing was found.
    assert len(flat().walls) >= 16


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_random_flat_has_one_door_where_the_robot_drove(seed: int) -> None:
    drive, jambs = small_flat(seed)
    found = map_sweeps(JointMapper(drive.rig), tuple(drive))
    assert crossed_walls(found) == 0
    (door,) = found.openings
    assert door.passed
    assert len(found.walls) >= 8
    assert abs(door.width - np.ptp(jambs)) < max(0.05, 1.96 * door.width_sigma)


def test_openings_survive_a_round_trip_through_a_file(tmp_path: Path) -> None:
    write_map(tmp_path / "map.json", flat())
    for before, after in zip(flat().openings, read_map(tmp_path / "map.json").openings, strict=True):
        assert after.endpoints_xy == pytest.approx(before.endpoints_xy)
        assert after.width_sigma == pytest.approx(before.width_sigma)
        assert (after.walls, after.passed) == (before.walls, before.passed)
