"""A bag of a robot with sonar is a source of sweeps, whoever wrote it."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from rosbags.rosbag2 import CompressionMode

from echoplan.geometry import wrap
from echoplan.io.ros import read_bag
from echoplan.model import Recording, Source
from helpers.bags import (
    HUMBLE,
    JAZZY,
    NOON_NS,
    ROS1,
    Robot,
    Sent,
    drive,
    recorded_by,
    ring,
    write_humble_database,
    write_mcap,
    write_ros1,
    write_ros2,
)

Writer = Callable[[Path, list[Sent]], Path]


def assert_same_sweeps(found: Source, expected: Source, *, start_ns: int = NOON_NS) -> None:
    assert len(found) == len(expected)
    for own, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(own.stamps_ns, other.stamps_ns + start_ns)
        np.testing.assert_array_equal(own.sensor_ids, other.sensor_ids)
        np.testing.assert_allclose(own.ranges, other.ranges, rtol=0.0, atol=1e-6)
        np.testing.assert_allclose(own.servo_angles, other.servo_angles, rtol=0.0, atol=1e-6)
        off = own.map_from_base - other.map_from_base
        np.testing.assert_allclose(off[:, :2], 0.0, atol=1e-6)
        np.testing.assert_allclose(wrap(off[:, 2]), 0.0, atol=1e-6)


def assert_same_rig(found: Source, expected: Source) -> None:
    off = found.rig.turret_from_sensors - expected.rig.turret_from_sensors
    np.testing.assert_allclose(off[:, :2], 0.0, atol=1e-6)
    np.testing.assert_allclose(wrap(off[:, 2]), 0.0, atol=1e-6)
    np.testing.assert_allclose(found.rig.base_from_turret, expected.rig.base_from_turret, atol=1e-6)
    for own, other in zip(found.rig.sensors, expected.rig.sensors, strict=True):
        limits = (own.half_aperture, own.min_range, own.max_range, own.resolution)
        assert limits == pytest.approx((other.half_aperture, other.min_range, other.max_range, other.resolution))


@pytest.mark.parametrize(
    ("name", "robot", "write"),
    [
        ("run.mcap", Robot(JAZZY), write_mcap),
        ("humble.mcap", Robot(HUMBLE), lambda path, sent: write_mcap(path, sent, store=HUMBLE)),
        ("run", Robot(JAZZY), write_ros2),
        ("humble", Robot(HUMBLE), lambda path, sent: write_ros2(path, sent, store=HUMBLE, sqlite=True)),
        ("run.db3", Robot(HUMBLE), write_humble_database),
        ("jazzy.db3", Robot(JAZZY), lambda path, sent: write_humble_database(path, sent, store=JAZZY)),
        ("run.bag", Robot(ROS1), write_ros1),
        *(
            (f"{mode.name}", Robot(JAZZY), partial(write_ros2, sqlite=is_sqlite, compression=mode))
            for mode, is_sqlite in (
                (CompressionMode.FILE, True),
                (CompressionMode.MESSAGE, True),
                (CompressionMode.STORAGE, False),
            )
        ),
    ],
)
def test_a_drive_is_read_from_a_bag_of_any_kind(name: str, robot: Robot, write: Writer, tmp_path: Path) -> None:
    driven = recorded_by(ring())
    found = read_bag(write(tmp_path / name, list(drive(driven, robot))))
    assert found.name == name
    assert found.notes == ()
    assert_same_sweeps(found, driven)
    assert_same_rig(found, Recording(name="", rig=driven.rig, sweeps=()))


def test_the_transforms_of_early_ros_1_are_read(tmp_path: Path) -> None:
    driven = recorded_by(ring())

    def early() -> Iterator[Sent]:
        for each in drive(driven, Robot(ROS1)):
            if each.topic != "/tf_static":
                yield each
                continue
            # A static transform is published again and again, ahead of time.
            for number in range(5):
                (transform,) = each.message.transforms
                stamp = Robot(ROS1).header("base_link", each.log_ns + number * 100_000_000 + 50_000_000)
                renewed = Robot(ROS1).make("tf/msg/tfMessage", transforms=[replace(transform, header=stamp)])
                yield Sent("/tf", each.log_ns + number * 100_000_000, renewed)

    sent = sorted(early(), key=lambda each: each.log_ns)
    found = read_bag(write_ros1(tmp_path / "run.bag", sent))
    assert_same_sweeps(found, driven)
    assert_same_rig(found, driven)
