"""What comes with echoplan can be simulated as it is."""

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.errors import UnknownNameError
from echoplan.geometry import distances_to_segments
from echoplan.io import builtin_rig, builtin_route, builtin_world, rig_names, route_names, world_names
from echoplan.model import World

CLEARANCE = 0.3


def test_every_world_has_a_route() -> None:
    assert route_names() == world_names()
    assert {"square", "paper-room", "office", "hexagon", "corridor", "cylinders"} <= set(world_names())


def test_an_unknown_name_is_refused_with_the_nearest() -> None:
    with pytest.raises(UnknownNameError, match="unknown rig 'ring16'; did you mean 'ring-16'"):
        builtin_rig("ring16")
    with pytest.raises(UnknownNameError, match="unknown world 'attic'; known: corridor, "):
        builtin_world("attic")
    with pytest.raises(UnknownNameError, match=r"unknown route '\.\./rigs/ring-16'"):
        builtin_route("../rigs/ring-16")


@pytest.mark.parametrize("name", rig_names())
def test_a_rig_has_all_that_a_simulator_needs(name: str) -> None:
    rig = builtin_rig(name)
    assert rig.firing is not None
    assert rig.firing.sensor_ids == set(rig.sensor_ids.tolist())
    assert rig.transducer is not None


def test_the_rotary_array_is_that_of_the_paper() -> None:
    rig = builtin_rig("rotary-array")
    arms = np.hypot(*rig.turret_from_sensors[:, :2].T)
    np.testing.assert_allclose(arms, 0.05)
    np.testing.assert_allclose(np.diff(np.unwrap(rig.turret_from_sensors[:, 2])), np.pi / 2, atol=1e-6)
    assert rig.servo is not None
    np.testing.assert_allclose(rig.servo.angles, np.deg2rad(np.arange(-45, 46)), atol=1e-4)
    assert (rig.min_ranges.tolist(), rig.max_ranges.tolist()) == ([0.03] * 4, [3.0] * 4)


@pytest.mark.parametrize("name", rig_names())
def test_sensors_look_outwards(name: str) -> None:
    x, y, yaw = builtin_rig(name).turret_from_sensors.T
    np.testing.assert_allclose(np.cos(np.arctan2(y, x) - yaw), 1.0, atol=1e-9)


def test_the_ring_fires_opposite_sensors_together() -> None:
    rig = builtin_rig("ring-16")
    assert rig.firing is not None
    yaws = dict(zip(rig.sensor_ids.tolist(), rig.turret_from_sensors[:, 2].tolist(), strict=True))
    for group in rig.firing.groups:
        turns = np.diff(np.unwrap([yaws[sensor] for sensor in group]))
        np.testing.assert_allclose(turns, np.pi / 2, atol=1e-5)


def clearance(world: World, points_xy: FloatArray) -> FloatArray:
    to_walls = distances_to_segments(points_xy, world.segments_xy).min(axis=1)
    to_discs = [np.hypot(*(points_xy - disc[:2]).T) - disc[2] for disc in world.discs]
    distances: FloatArray = np.min([to_walls, *to_discs], axis=0)
    return distances


@pytest.mark.parametrize("name", world_names())
def test_a_route_keeps_clear_of_everything(name: str) -> None:
    stations = builtin_route(name).map_from_base
    assert clearance(builtin_world(name), stations[:, :2]).min() >= CLEARANCE


@pytest.mark.parametrize("name", world_names())
def test_a_route_stays_on_one_side_of_every_closed_wall(name: str) -> None:
    outlines = [line.points_xy for line in builtin_world(name).polylines if line.closed]
    stations = builtin_route(name).map_from_base
    sides = {tuple(is_inside(outline, x, y) for outline in outlines) for x, y, _ in stations}
    assert len(sides) == 1
    assert sum(sides.pop()) <= 1, "only a room has its stations inside; a box has not"


def is_inside(points_xy: FloatArray, x: float, y: float) -> bool:
    turns = np.unwrap(np.arctan2(*(np.vstack([points_xy, points_xy[:1]]) - [x, y]).T[::-1]))
    return bool(abs(turns[-1] - turns[0]) > np.pi)


@pytest.mark.parametrize("name", world_names())
def test_a_swapped_axis_would_show(name: str) -> None:
    segments = builtin_world(name).segments_xy
    walls = {tuple(end) for end in segments.reshape(-1, 2).tolist()}
    swapped = {(y, x) for x, y in walls}
    mirrored = {(-x, y) for x, y in walls}
    assert walls not in (swapped, mirrored)


def test_the_hexagon_has_no_right_angle() -> None:
    spans = np.diff(builtin_world("hexagon").segments_xy, axis=1)[:, 0]
    angles = np.arctan2(spans[:, 1], spans[:, 0])
    turns = np.abs(np.sin(2.0 * (angles[:, None] - angles[None])))
    np.fill_diagonal(turns, 1.0)
    assert turns.min() > np.sin(np.deg2rad(5.0))
