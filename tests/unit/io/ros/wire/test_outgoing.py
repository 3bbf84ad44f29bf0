"""The map that is published is that of the exported bag, and the frame of odometry lies where the map says."""

import time
from pathlib import Path
from typing import Any

import numpy as np
from rosbags.highlevel import AnyReader

from echoplan.grids import grid_from_map
from echoplan.io.ros import write_map_bag
from echoplan.io.ros.wire import MapPublisher
from echoplan.model import FeatureMap
from helpers.maps import wall
from helpers.wires import FakeTransport

HOUSE = FeatureMap(method="joint", walls=(wall([0.0, 0.0], [2.0, 0.0]), wall([0.0, 0.0], [0.0, 1.5])))


def until(transport: FakeTransport, count: int) -> None:
    """Wait for so many transforms."""
    while len(transport.published["/tf"]) < count:
        time.sleep(0.01)


def test_grid_and_markers_are_latched_and_those_of_an_exported_bag(tmp_path: Path) -> None:
    transport, grid = FakeTransport([]), grid_from_map(HOUSE)
    publisher = MapPublisher(transport, world="odom")
    publisher.publish(HOUSE, grid=grid, map_from_odom=np.zeros(3))
    publisher.close()
    write_map_bag(tmp_path / "map.mcap", HOUSE, grid=grid, times_ns=[])
    with AnyReader([tmp_path / "map.mcap"]) as reader:
        exported: dict[str, Any] = {
            each.topic: reader.deserialize(raw, each.msgtype) for each, _, raw in reader.messages()
        }
    assert transport.latched == {"/map", "/echoplan/markers"}
    (own,), (markers,) = transport.published["/map"], transport.published["/echoplan/markers"]
    np.testing.assert_array_equal(own.data, exported["/map"].data)
    assert own.info.resolution == exported["/map"].info.resolution
    assert repr(own.info.origin) == repr(exported["/map"].info.origin)
    assert own.header.frame_id == exported["/map"].header.frame_id
    first, *rest = markers.markers
    assert first.action == first.DELETEALL
    others = exported["/echoplan/markers"].markers
    assert [(each.ns, each.id) for each in rest] == [(each.ns, each.id) for each in others]


def test_the_transform_to_odometry_is_the_identity_until_the_first_map_and_comes_ten_times_a_second() -> None:
    transport = FakeTransport([])
    publisher = MapPublisher(transport, world="robot1/odom")
    begin = time.monotonic()
    until(transport, 10)
    assert time.monotonic() - begin < 1.0
    publisher.publish(HOUSE, grid=grid_from_map(HOUSE), map_from_odom=np.array([1.0, 2.0, np.pi / 2]))
    until(transport, 15)
    publisher.close()
    (first,), (last,) = transport.published["/tf"][0].transforms, transport.published["/tf"][-1].transforms
    assert (first.header.frame_id, first.child_frame_id) == ("map", "robot1/odom")
    assert (first.transform.translation.x, first.transform.rotation.w) == (0.0, 1.0)
    assert (last.transform.translation.x, last.transform.translation.y) == (1.0, 2.0)
    np.testing.assert_allclose(last.transform.rotation.z, np.sqrt(0.5))


def test_stamps_are_those_of_the_clock_of_the_robot() -> None:
    transport = FakeTransport([])
    publisher = MapPublisher(transport, world="odom")
    publisher.set_clock(-1_000_000_000_000)
    publisher.publish(HOUSE, grid=grid_from_map(HOUSE), map_from_odom=np.zeros(3))
    publisher.close()
    stamp = transport.published["/map"][0].header.stamp
    assert abs(time.time() - 1000.0 - stamp.sec) < 5.0


def test_a_robot_with_poses_in_the_map_gets_no_transform() -> None:
    transport = FakeTransport([])
    publisher = MapPublisher(transport, world="map")
    time.sleep(0.2)
    publisher.close()
    assert not transport.published["/tf"]
