"""``echoplan live ros2://`` beside a robot in another process that plays a bag, over DDS and over Zenoh."""

import os
import pickle
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from echoplan.geometry import compose, invert
from echoplan.io import read_recording
from echoplan.io.ros import read_bag
from echoplan.io.ros.bag import Topic
from echoplan.io.ros.map_messages import grid_message
from echoplan.io.ros.wire import open_transport, parse_address
from echoplan.live import Complete, Ros2Feed
from echoplan.live.mapping import map_update
from echoplan.live.survey import Survey
from echoplan.mapping import MapResult, map_source
from echoplan.model import Sweep
from echoplan.sources import open_source
from helpers.bags import JAZZY, Robot, drive, write_mcap
from helpers.robot import RECEIVED, fingerprint
from helpers.typed import echoplan

HELPER = Path(__file__).parents[1] / "helpers" / "robot.py"
# Tests may run at the same time on one machine; ports of domains above 101 are those of other programs.
DOMAIN = 51 + os.getpid() % 50
DDS = f"ros2://localhost?domain={DOMAIN}"
SPEED = 5

needs_dds = pytest.mark.skipif(find_spec("cyclonedds") is None, reason="cyclonedds is not installed (extra ros-live)")
needs_zenoh = pytest.mark.skipif(find_spec("zenoh") is None, reason="eclipse-zenoh is not installed (extra ros-live)")
needs_view = pytest.mark.skipif(find_spec("websockets") is None, reason="websockets is not installed (extra view)")


@pytest.fixture(scope="module")
def bag(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("robot") / "run.mcap"
    return write_mcap(path, drive(open_source("sim:square,seed=1"), Robot(JAZZY)))


@pytest.fixture(scope="module")
def expected(bag: Path) -> MapResult:
    """The map of the bag."""
    return map_source(read_bag(bag))


@contextmanager
def robot(bag: Path, address: str) -> Iterator[subprocess.Popen[str]]:
    """A robot that is ready to play a bag."""
    command = [sys.executable, str(HELPER), str(bag), address, str(SPEED)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        try:
            wait_for(process, "ready")
            yield process
        finally:
            process.kill()


def wait_for(process: subprocess.Popen[str], word: str) -> None:
    """Wait until a process says a word."""
    assert process.stdout
    assert any(line.strip() == word for line in process.stdout), f"it ended before it said {word}"


def begin(process: subprocess.Popen[str]) -> None:
    """Let a robot play its bag."""
    assert process.stdin
    process.stdin.write("play\n")
    process.stdin.flush()


def received(process: subprocess.Popen[str], bag: Path) -> dict[str, list[Any]]:
    """End a robot, and return the messages that came to it."""
    assert process.stdin
    process.stdin.close()
    process.wait()
    came = pickle.loads(Path(f"{bag}.received").read_bytes())
    return {
        topic: [JAZZY.deserialize_cdr(raw, RECEIVED[topic]) for raw in messages] for topic, messages in came.items()
    }


def assert_same_sweeps(found: Iterable[Sweep], expected: Iterable[Sweep]) -> None:
    for own, other in zip(found, expected, strict=True):
        np.testing.assert_array_equal(own.stamps_ns, other.stamps_ns)
        np.testing.assert_allclose(own.ranges, other.ranges, atol=1e-9)
        np.testing.assert_allclose(own.servo_angles, other.servo_angles, atol=1e-9)
        np.testing.assert_allclose(own.map_from_base, other.map_from_base, atol=1e-9)


def assert_published(messages: dict[str, list[Any]], expected: MapResult) -> None:
    """Check the newest map, its markers, and the transforms to odometry."""
    content = expected.exportable
    wanted, grid = grid_message(JAZZY.types, content.nav2_grid, stamp=0), messages["/map"][-1]
    np.testing.assert_array_equal(grid.data, wanted.data)
    assert (grid.header.frame_id, grid.info.width) == ("map", wanted.info.width)
    assert grid.info.resolution == np.float32(wanted.info.resolution)
    np.testing.assert_allclose(grid.info.origin.position.x, wanted.info.origin.position.x, atol=1e-9)
    first, *markers = messages["/echoplan/markers"][-1].markers
    assert first.action == first.DELETEALL
    assert sum(marker.ns == "wall numbers" for marker in markers) == len(expected.walls)
    every = [each for message in messages["/tf"] for each in message.transforms]
    transforms = [each for each in every if each.header.frame_id == "map"]
    assert {each.child_frame_id for each in transforms} == {"odom"}
    odometry = content.odom_from_base
    assert odometry is not None
    x, y, yaw = compose(expected.poses[-1], invert(odometry[-1]))
    last = transforms[-1].transform
    np.testing.assert_allclose([last.translation.x, last.translation.y], [x, y], atol=1e-6)
    np.testing.assert_allclose(2 * np.arctan2(last.rotation.z, last.rotation.w), yaw, atol=1e-6)


@pytest.mark.parametrize(
    ("address", "problem"),
    [
        # The domain differs from process to process, and the names of tests must not.
        pytest.param(
            f"{DDS}&wait=0",
            f"no topics were found in domain {DOMAIN}; start the robot",
            marks=needs_dds,
            id="a domain without topics",
        ),
        pytest.param("ros2://none.invalid", "the host none.invalid was not found; check its name", marks=needs_dds),
        pytest.param("ros2+zenoh://127.0.0.1:1", "no Zenoh answers at 127.0.0.1:1; start its", marks=needs_zenoh),
        ("ros2://?domain=x", "domain: 'x' is not a whole number from 0 to 232; write for example domain=5"),
    ],
)
def test_what_cannot_be_mapped_is_refused_in_one_line(address: str, problem: str) -> None:
    done = echoplan("live", address)
    assert (done.status, done.err.count("\n")) == (2, 1)
    assert problem in done.err


@needs_dds
def test_a_domain_can_be_joined_again_after_it_was_left() -> None:
    for _ in range(2):
        transport = open_transport(parse_address(DDS))
        publish = transport.advertise("/tf", "tf2_msgs/msg/TFMessage", is_latched=False)
        transport.subscribe(Topic(name="/odom", type="nav_msgs/msg/Odometry", count=1), lambda topic, raw: None)
        assert transport.topics() == ()
        transport.close()
        transport.close()
        # A thread that is late.
        publish(b"\0\1\0\0\0\0\0\0")


def test_without_the_extra_it_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for package in ("cyclonedds", "zenoh"):
        for name in [each for each in sys.modules if each.partition(".")[0] == package]:
            monkeypatch.delitem(sys.modules, name)
        monkeypatch.setitem(sys.modules, package, None)
    assert "pip install cyclonedds (extra 'ros-live')" in echoplan("live", "ros2://").err
    assert "pip install eclipse-zenoh (extra 'ros-live')" in echoplan("live", "ros2+zenoh://").err


@needs_dds
@needs_view
def test_over_dds_the_live_map_is_that_of_the_bag_and_the_robot_gets_it(
    bag: Path, expected: MapResult, tmp_path: Path
) -> None:
    out, address = tmp_path / "out", f"{DDS}&wait=60"
    command = [sys.executable, "-m", "echoplan", "live", address, "--no-browser", "--port", "0", "--out", str(out)]
    with robot(bag, address) as driver, subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as live:
        assert live.stdout
        # It has subscribed, and says what it waits for.
        assert re.match("Waiting for up to 60 s: .*: no message yet on /odom, /sonar_0", live.stdout.readline())
        begin(driver)
        grid = grid_message(JAZZY.types, expected.exportable.nav2_grid, stamp=0)
        wait_for(driver, f"map {fingerprint(grid)}")
        messages = received(driver, bag)
        live.send_signal(signal.SIGINT)
        assert "http://127.0.0.1:" in live.stdout.read()
    assert live.returncode == 0
    assert_same_sweeps(read_recording(out / "recording"), read_bag(bag))
    assert_published(messages, expected)


@needs_zenoh
def test_over_zenoh_the_sweeps_are_those_of_the_bag_and_the_robot_gets_the_map(bag: Path, expected: MapResult) -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        address = f"ros2+zenoh://127.0.0.1:{probe.getsockname()[1]}?domain={DOMAIN}&wait=60"
    with robot(bag, address) as driver:
        # By then it has subscribed.
        feed = Ros2Feed(parse_address(address), report=lambda _: begin(driver))
        sweeps = []
        for event in feed.events():
            if isinstance(event, Complete):
                sweeps.append(event.sweep)
            if len(sweeps) == len(expected.sweeps):
                break
        survey = Survey(name="robot", rig=feed.rig)
        for sweep in sweeps:
            survey = survey.with_sweep(sweep)
        update = map_update(survey)
        assert update is not None
        feed.publish(update)
        wait_for(driver, "played")
        feed.publish(update)
        assert driver.stdout
        assert driver.stdout.readline().startswith("map")
        messages = received(driver, bag)
        feed.close()
    assert_same_sweeps(sweeps, read_bag(bag))
    assert_published(messages, expected)
