"""A robot with ROS 2 for tests, in a process of its own: it plays a bag in real time and receives the map.

``python robot.py BAG ADDRESS SPEED`` advertises the topics of the bag, publishes all static transforms, and prints
``ready``. It begins to play when it reads a line, and prints a line for each map and at the end of the bag. When its
input ends, it waits until the last map is complete, and writes what it received to ``BAG.received``: messages as CDR by
topic, pickled.
"""

import json
import math
import os
import pickle
import struct
import sys
import time
import zlib
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from threading import Event, Thread
from typing import Any, Protocol

from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore

from echoplan.io.ros.bag import Topic
from echoplan.io.ros.wire import Middleware, WireAddress, open_transport, parse_address
from echoplan.io.ros.wire.transport import type_on_wire

STORE = get_typestore(Stores.LATEST)
RECEIVED = {
    "/map": "nav_msgs/msg/OccupancyGrid",
    "/echoplan/markers": "visualization_msgs/msg/MarkerArray",
    "/tf": "tf2_msgs/msg/TFMessage",
}

# Seconds without a new grid or markers after which a map is complete, and for how long the robot waits for that [s].
QUIET, PATIENCE = 1.0, 60.0


def say(word: str) -> None:
    """Tell the test."""
    sys.stdout.write(f"{word}\n")
    sys.stdout.flush()


def fingerprint(grid: Any) -> str:
    """Number of an OccupancyGrid: the same for the same size and cells."""
    return f"{grid.info.width}x{grid.info.height}-{zlib.crc32(grid.data.tobytes())}"


class Peer(Protocol):
    """What a robot needs of a network."""

    def advertise(self, name: str, kind: str, *, is_latched: bool) -> Callable[[bytes], None]: ...

    def topics(self) -> tuple[Topic, ...]: ...

    def subscribe(self, topic: Topic, receive: Callable[[Topic, bytes], None]) -> None: ...

    def close(self) -> None: ...


class ZenohRouter:
    """A router of Zenoh with a publisher and subscribers as rmw_zenoh declares them, by hand."""

    def __init__(self, address: WireAddress) -> None:
        import zenoh  # noqa: PLC0415 - an extra

        configuration = zenoh.Config()
        configuration.insert_json5("mode", '"router"')
        configuration.insert_json5("listen/endpoints", json.dumps([f"tcp/{address.host}:{address.port}"]))
        configuration.insert_json5("scouting/multicast/enabled", "false")
        self.network = zenoh.open(configuration)
        self.domain, self.kept = address.domain, list[Any]()

    def token(self, kind: str, name: str, type_name: str, *, quality: str) -> None:
        parts = [str(self.network.zid()), "0", str(len(self.kept)), kind, "%", "%robot", "driver"]
        parts += [name.replace("/", "%"), type_on_wire(type_name), STORE.hash_rihs01(type_name), quality]
        token = "/".join(["@ros2_lv", str(self.domain), *parts])
        self.kept.append(self.network.liveliness().declare_token(token))

    def key(self, name: str, kind: str) -> str:
        return f"{self.domain}/{name[1:]}/{type_on_wire(kind)}/{STORE.hash_rihs01(kind)}"

    def advertise(self, name: str, kind: str, *, is_latched: bool) -> Callable[[bytes], None]:
        from zenoh import CongestionControl  # noqa: PLC0415 - an extra
        from zenoh.ext import CacheConfig, declare_advanced_publisher  # noqa: PLC0415 - an extra

        cache = CacheConfig(1) if is_latched else None
        # As rmw_zenoh publishes with the history "keep all". Otherwise Zenoh drops messages after a delay of the robot.
        publisher = declare_advanced_publisher(
            self.network,
            self.key(name, kind),
            congestion_control=CongestionControl.BLOCK,
            cache=cache,
            publisher_detection=is_latched,
        )
        self.token("MP", name, kind, quality=":1:,1:,:,:,," if is_latched else "::2,:,:,:,,")
        gid = os.urandom(16)
        return lambda raw: publisher.put(raw, attachment=struct.pack("<qqB", 1, time.time_ns(), 16) + gid)

    def topics(self) -> tuple[Topic, ...]:
        return tuple(Topic(name=name, type=kind, count=1) for name, kind in RECEIVED.items())

    def subscribe(self, topic: Topic, receive: Callable[[Topic, bytes], None]) -> None:
        from zenoh.ext import HistoryConfig, declare_advanced_subscriber  # noqa: PLC0415 - an extra

        def hand_over(sample: Any) -> None:
            # What rmw_zenoh reads from each attachment.
            _, _, length = struct.unpack("<qqB", sample.attachment.to_bytes()[:17])
            assert length == 16
            receive(topic, sample.payload.to_bytes())

        key, history = self.key(topic.name, topic.type), HistoryConfig(detect_late_publishers=True)
        self.kept.append(declare_advanced_subscriber(self.network, key, hand_over, history=history))

    def close(self) -> None:
        self.network.close()


def joined(address: WireAddress) -> Peer:
    return ZenohRouter(address) if address.middleware is Middleware.ZENOH else open_transport(address)


def play(bag: Path, peer: Peer, *, speed: float) -> None:
    """Publish the messages of a bag by their times; static transforms in one message, as robot_state_publisher does."""
    with Reader(bag) as reader:
        publish: dict[str, Callable[[bytes], None]] = {}
        for each in reader.connections:
            is_static = each.topic == "/tf_static"
            publish[each.topic] = peer.advertise(each.topic, each.msgtype, is_latched=is_static)
        static = [each for each in reader.connections if each.topic == "/tf_static"]
        messages: list[Any] = [STORE.deserialize_cdr(raw, each.msgtype) for each, _, raw in reader.messages(static)]
        transforms = [transform for message in messages for transform in message.transforms]
        kind = "tf2_msgs/msg/TFMessage"
        publish["/tf_static"](bytes(STORE.serialize_cdr(STORE.types[kind](transforms=transforms), kind)))
        say("ready")
        sys.stdin.readline()
        begin = time.monotonic()
        for connection, log_ns, raw in reader.messages([each for each in reader.connections if each not in static]):
            wait = begin + (log_ns - reader.start_time) / 1e9 / speed - time.monotonic()
            if wait > 0:
                time.sleep(wait)
            publish[connection.topic](bytes(raw))


def main(bag: str, address: str, speed: str) -> None:
    received: defaultdict[str, list[bytes]] = defaultdict(list)
    newest: dict[str, float] = {}

    def take(topic: Topic, raw: bytes) -> None:
        received[topic.name].append(raw)
        newest[topic.name] = time.monotonic()
        if topic.name == "/map":
            say(f"map {fingerprint(STORE.deserialize_cdr(raw, topic.type))}")

    peer, ended, subscribed = joined(parse_address(address)), Event(), set[str]()

    def listen() -> None:
        """Subscribe to what echoplan publishes as soon as it is there, in a thread of its own."""
        while not ended.wait(0.1):
            for topic in peer.topics():
                if topic.name in RECEIVED.keys() - subscribed:
                    subscribed.add(topic.name)
                    peer.subscribe(topic, take)

    def is_complete() -> bool:
        latched = [newest.get(topic, math.inf) for topic in RECEIVED if topic != "/tf"]
        return "/tf" in newest and time.monotonic() - max(latched) > QUIET

    listening = Thread(target=listen)
    listening.start()
    play(Path(bag), peer, speed=float(speed))
    say("played")
    sys.stdin.read()
    deadline = time.monotonic() + PATIENCE
    while time.monotonic() < deadline and not is_complete():
        time.sleep(0.1)
    ended.set()
    listening.join()
    Path(f"{bag}.received").write_bytes(pickle.dumps(dict(received)))
    peer.close()


if __name__ == "__main__":
    main(*sys.argv[1:])
