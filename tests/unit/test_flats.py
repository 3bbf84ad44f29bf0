"""The random flats in which benchmarks measure methods."""

from functools import cache
from pathlib import Path

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import crosses_segments, distances_to_segments
from echoplan.io import read_recording, read_truth
from echoplan.simulation import OdometryNoise, Simulation
from flats import write
from library.flats import Flat, random_flat, random_plan
from library.tours import find_route

# Exact poses and right angles; drifting; oblique; both.
SEEDS = (0, 5, 2, 11)


@cache
def simulation(seed: int) -> Simulation:
    return random_flat(seed)


@cache
def plan(seed: int) -> Flat:
    return random_plan(np.random.default_rng(seed), oblique=seed % 2 == 1)


def path_points(seed: int) -> FloatArray:
    stations = simulation(seed).route.map_from_base[:, :2]
    shares = np.linspace(0.0, 1.0, 101)[:, None, None]
    points: FloatArray = ((1.0 - shares) * stations[:-1] + shares * stations[1:]).reshape(-1, 2)
    return points


def clearances(points_xy: FloatArray, seed: int) -> FloatArray:
    world = simulation(seed).world
    to_discs = [np.hypot(*(points_xy - disc[:2]).T) - disc[2] for disc in world.discs]
    nearest: FloatArray = np.min([distances_to_segments(points_xy, world.segments_xy).min(axis=1), *to_discs], axis=0)
    return nearest


def test_a_seed_makes_the_same_flat_again() -> None:
    again = random_flat(11)
    np.testing.assert_array_equal(again.world.segments_xy, simulation(11).world.segments_xy)
    np.testing.assert_array_equal(again.route.map_from_base, simulation(11).route.map_from_base)
    assert again.settings == simulation(11).settings


def test_odometry_drifts_in_every_other_flat_and_walls_are_oblique_in_two_of_four() -> None:
    for seed in SEEDS:
        segments = simulation(seed).world.polylines[0].segments_xy
        assert (simulation(seed).settings.odometry == OdometryNoise()) == (seed % 2 == 0)
        ways = np.abs(segments[:, 1] - segments[:, 0])
        assert np.allclose(ways.min(axis=1), 0.0) == (seed // 2 % 2 == 0)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_robot_has_room_all_along_its_route(seed: int) -> None:
    assert clearances(path_points(seed), seed).min() > 0.33


@pytest.mark.parametrize("seed", SEEDS)
def test_legs_are_neither_short_nor_long(seed: int) -> None:
    lengths = np.hypot(*np.diff(simulation(seed).route.map_from_base[:, :2], axis=0).T)
    assert lengths.min() >= 0.4
    assert lengths.max() <= 1.1


@pytest.mark.parametrize("seed", range(8))
def test_doors_and_walls_are_within_their_limits(seed: int) -> None:
    for door in plan(seed).doors:
        first, second = door.jambs_xy
        assert 0.7 <= door.width <= 1.4
        thicknesses = np.hypot(*(first - second[::-1]).T)
        assert thicknesses.min() >= 0.08
        assert thicknesses.max() <= 0.16
        for jambs, room in zip(door.jambs_xy, door.rooms, strict=True):
            corners = plan(seed).rooms[room].corners_xy
            assert np.linalg.norm(jambs[:, None] - corners, axis=2).min() >= 0.3


@pytest.mark.parametrize("seed", range(8))
def test_an_outline_shows_each_door_twice_and_crosses_none(seed: int) -> None:
    flat = plan(seed)
    segments = flat.world("flat").segments_xy
    for door in flat.doors:
        np.testing.assert_allclose(distances_to_segments(door.jambs_xy.reshape(-1, 2), segments).min(axis=1), 0.0)
        before, behind = door.jambs_xy.mean(axis=1)
        assert not crosses_segments(before[None], behind[None], segments).any()


@pytest.mark.parametrize("seed", SEEDS)
def test_the_route_leads_through_every_door_and_stops_in_every_room_ten_to_sixteen_times(seed: int) -> None:
    # The generator gives up flats that have no route: this one is the first that has one.
    flat, world = flat_of(seed)
    np.testing.assert_array_equal(world, simulation(seed).world.segments_xy)
    points = path_points(seed)
    for door in flat.doors:
        assert np.hypot(*(points - door.center_xy).T).min() < 0.02
    stations = simulation(seed).route.map_from_base[:, :2]
    counts = [sum(is_inside(room.corners_xy, *station) for station in stations) for room in flat.rooms]
    assert 2 <= len(counts) <= 4
    assert min(counts) >= 10
    assert max(counts) <= 16


def flat_of(seed: int) -> tuple[Flat, FloatArray]:
    rng = np.random.default_rng(seed)
    while True:
        flat = random_plan(rng, oblique=seed // 2 % 2 == 1)
        world = flat.world("flat")
        if find_route(flat, world, rng) is not None:
            return flat, world.segments_xy


def is_inside(corners_xy: FloatArray, x: float, y: float) -> bool:
    starts, stops = corners_xy, np.roll(corners_xy, -1, axis=0)
    ways, to_point = stops - starts, np.array([x, y]) - starts
    return bool((ways[:, 0] * to_point[:, 1] - ways[:, 1] * to_point[:, 0] > 0.0).all())


def test_a_flat_is_written_as_a_recording_with_truth(tmp_path: Path) -> None:
    seed = 11
    write(tmp_path / "flat11", seed)
    truth = read_truth(tmp_path / "flat11" / "truth.json")
    assert len(read_recording(tmp_path / "flat11")) == len(truth.poses) == len(simulation(seed).route.map_from_base)
    np.testing.assert_array_equal(truth.poses, simulation(seed).route.map_from_base)
    assert truth.walls_detected_by.max() > 5
    assert not np.array_equal(truth.poses, truth.given)
