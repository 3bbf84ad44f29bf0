"""A drive of a ring of sixteen sensors in a bag that another program wrote maps like its CSV."""

from itertools import pairwise

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.io import builtin_rig, builtin_world, read_recording, write_recording
from echoplan.io.ros import read_bag
from echoplan.methods import METHODS, map_sweeps
from echoplan.model import Recording, Route, Source
from echoplan.simulation import Simulation
from helpers.bags import NOON_NS, Robot, drive, write_mcap

# Round the room, turning on the spot in two seconds at each corner.
CORNERS_XY = np.array([[-0.5, 0.0], [1.5, 0.0], [1.5, 2.0], [-0.5, 2.0], [-0.5, 0.0]])


def around_the_room() -> Route:
    poses, moments = list[FloatArray](), list[float]()
    for side, (start, end) in enumerate(pairwise(CORNERS_XY)):
        yaw = side * np.pi / 2
        poses += [np.array([*start, yaw]), np.array([*end, yaw])]
        moments += [9.0 * side, 9.0 * side + 7.0]
    return Route(map_from_base=np.array(poses), stamps_ns=np.array([round(1e9 * moment) for moment in moments]))


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Source, Recording]:
    """Write the same drive as CSV and, with the writer of the mcap project, as a bag; read both."""
    folder = tmp_path_factory.mktemp("drive")
    world, rig = builtin_world("square"), builtin_rig("ring-16")
    write_recording(folder / "rec", Simulation(world=world, rig=rig, route=around_the_room(), seed=1))
    recording = read_recording(folder / "rec")
    return recording, read_bag(write_mcap(folder / "run.mcap", drive(recording, Robot())))


def test_the_sweeps_of_a_bag_are_those_of_its_csv(pair: tuple[Source, Recording]) -> None:
    expected, found = pair
    assert found.notes == ()
    assert len(found) == len(expected)
    for own, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(own.stamps_ns, other.stamps_ns + NOON_NS)
        np.testing.assert_array_equal(own.sensor_ids, other.sensor_ids)
        np.testing.assert_array_equal(own.servo_angles, other.servo_angles)
        np.testing.assert_allclose(own.ranges, other.ranges, rtol=0.0, atol=1e-6)
        off = own.map_from_base - other.map_from_base
        np.testing.assert_allclose(np.column_stack([off[:, :2], wrap(off[:, 2])]), 0.0, atol=1e-6)


def test_the_rig_of_a_bag_is_that_of_its_csv(pair: tuple[Source, Recording]) -> None:
    expected, found = (source.rig for source in pair)
    off = found.turret_from_sensors - expected.turret_from_sensors
    np.testing.assert_allclose(np.column_stack([off[:, :2], wrap(off[:, 2])]), 0.0, atol=1e-6)
    for own, other in zip(found.sensors, expected.sensors, strict=True):
        limits = (own.half_aperture, own.min_range, own.max_range, own.resolution)
        assert limits == pytest.approx((other.half_aperture, other.min_range, other.max_range, other.resolution))


def test_the_map_of_a_bag_is_that_of_its_csv(pair: tuple[Source, Recording]) -> None:
    maps = [map_sweeps(METHODS["joint"].build(source.rig), source) for source in pair]
    lines = [np.array(sorted((wall.normal_angle, wall.offset) for wall in each.walls)) for each in maps]
    assert len(lines[0]) == 4
    np.testing.assert_allclose(lines[1], lines[0], atol=0.002)
