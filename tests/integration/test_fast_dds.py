"""Fast DDS, the default middleware of ROS 2, exchanges messages with echoplan."""

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
from rosbags.typesys.store import Typestore

from echoplan.grids import grid_from_map
from echoplan.io.ros.bag import Topic, standard_typestore
from echoplan.io.ros.map_messages import grid_message
from echoplan.io.ros.wire import Transport, open_transport, parse_address
from echoplan.model import FeatureMap
from helpers.bags import HUMBLE, JAZZY, RANGE, Robot
from helpers.maps import wall

pytest.importorskip("cyclonedds", reason="cyclonedds is not installed (extra ros-live)")
SOURCE = Path(__file__).parents[1] / "fastdds" / "peer.cpp"
HEADER = Path("/usr/include/fastdds/dds/domain/DomainParticipant.hpp")
pytestmark = pytest.mark.skipif(
    shutil.which("g++") is None or not HEADER.exists(),
    reason="Fast DDS is not installed (Debian packages g++ and libfastrtps-dev)",
)
GRID = "nav_msgs/msg/OccupancyGrid"
DOMAIN = 1 + os.getpid() % 50
PATIENCE = 10


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("fastdds") / "peer"
    subprocess.run(["g++", "-O0", "-o", str(path), str(SOURCE), "-lfastrtps", "-lfastcdr"], check=True)
    return path


@pytest.fixture(scope="module")
def transport() -> Iterator[Transport]:
    joined = open_transport(parse_address(f"ros2://localhost?domain={DOMAIN}"))
    yield joined
    joined.close()


@pytest.fixture(scope="module")
def published(transport: Transport) -> bytes:
    """A map as it was published, larger than a datagram."""
    house = FeatureMap(method="joint", walls=(wall([0.0, 0.0], [20.0, 0.0]), wall([0.0, 0.0], [0.0, 15.0])))
    message = bytes(JAZZY.serialize_cdr(grid_message(JAZZY.types, grid_from_map(house), stamp=0), GRID))
    assert len(message) > 65_536
    transport.advertise("/map", GRID, is_latched=True)(message)
    return message


@pytest.mark.parametrize("store", [HUMBLE, JAZZY], ids=["Humble", "Jazzy"])
def test_fast_dds_sends_readings_and_gets_the_map_that_was_published_before(
    program: Path, transport: Transport, published: bytes, store: Typestore, tmp_path: Path
) -> None:
    reading = bytes(store.serialize_cdr(Robot(store).sonar(1.25, stamp_ns=0), RANGE))
    (tmp_path / "reading.cdr").write_bytes(reading)
    command = [str(program), str(DOMAIN), str(PATIENCE), "reading.cdr"]
    received, came = list[bytes](), Event()

    def take(topic: Topic, raw: bytes) -> None:
        received.append(raw)
        came.set()

    with subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.PIPE, text=True) as peer:
        while not (topics := transport.topics()):
            assert peer.poll() is None
        assert [(topic.name, topic.type) for topic in topics] == [("/sonar", RANGE)]
        transport.subscribe(topics[0], take)
        assert came.wait(PATIENCE)
        assert peer.communicate()[0] == "maps 1\n"
    # DDS pads messages, and counts that in their first four bytes.
    assert (tmp_path / "map.cdr").read_bytes()[4 : len(published)] == published[4:]
    found = standard_typestore(RANGE, received[0])
    assert found is not None
    sonar: Any = found.deserialize_cdr(received[0], RANGE)
    assert sonar.range == np.float32(1.25)
    assert hasattr(sonar, "variance") is (store is JAZZY)
