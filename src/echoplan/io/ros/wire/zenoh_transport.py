"""ROS 2 over Zenoh, as rmw_zenoh has it: keys with the type and its hash, and tokens by which nodes are found."""

import logging
import os
import struct
import time
from collections.abc import Callable
from itertools import count
from threading import Lock
from typing import TYPE_CHECKING, Any

from echoplan.errors import InputError, MissingExtraError
from echoplan.io.ros.bag import Topic
from echoplan.io.ros.wire.address import WireAddress
from echoplan.io.ros.wire.transport import Receive, type_from_wire, type_on_wire

if TYPE_CHECKING:
    import zenoh

__all__ = ["ZenohTransport"]

_LOGGER = logging.getLogger(__name__)
_TOKENS = "@ros2_lv"
# Publishers, subscriptions and nodes in tokens, and the name of this node.
_PUBLISHER, _SUBSCRIPTION, _NODE, _NAME = "MP", "MS", "NN", "echoplan"
# Reliability, durability, history, deadline, lifespan and liveliness; empty where they are the default.
_DEFAULT_QUALITY, _LATCHED_QUALITY = "::,10:,:,:,,", ":1:,1:,:,:,,"
_LATCHED = "1"
# A token of an endpoint has so many parts: before the kind, the name, and the topic with its type, hash and quality.
_PARTS = 13
_GID_BYTES = 16
# Time between two messages about what was published last, if it is new [s]; as rmw_zenoh.
_HEARTBEAT = 0.5


class ZenohTransport:
    """A client of a router of Zenoh.

    Parameters
    ----------
    address : WireAddress
        The router, and the domain of ROS 2.

    Raises
    ------
    InputError
        If no router answers.
    MissingExtraError
        If eclipse-zenoh or rosbags is not installed.
    """

    def __init__(self, address: WireAddress) -> None:
        try:
            import zenoh  # noqa: PLC0415 - an extra
        except ImportError as error:
            raise MissingExtraError("eclipse-zenoh", extra="ros-live") from error
        try:
            from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 - an extra
        except ImportError as error:
            raise MissingExtraError("rosbags", extra="ros-live") from error

        self._store = get_typestore(Stores.LATEST)
        self._domain = address.domain
        self._tokens: set[str] = set()
        self._lock, self._numbers = Lock(), count()
        self._kept: list[Any] = []
        configuration = zenoh.Config()
        configuration.insert_json5("mode", '"client"')
        configuration.insert_json5("connect/endpoints", f'["tcp/{address.endpoint}"]')
        configuration.insert_json5("scouting/multicast/enabled", "false")
        try:
            self._network = zenoh.open(configuration)
        except zenoh.ZError as error:
            problem = f"no Zenoh answers at {address.endpoint}"
            remedy = (
                "start its router (ros2 run rmw_zenoh_cpp rmw_zenohd), or name host and port: ros2+zenoh://HOST:PORT"
            )
            raise InputError(address.text, problem, remedy=remedy) from error
        self._own = str(self._network.zid())
        listened = f"{_TOKENS}/{self._domain}/*/*/*/{_PUBLISHER}/**"
        tokens = self._network.liveliness()
        self._kept.append(tokens.declare_subscriber(listened, self._note, history=True))
        self._declare(_NODE)

    def topics(self) -> tuple[Topic, ...]:
        """Return the topics of others by name, each with its number of publishers."""
        counts: dict[tuple[str, str], int] = {}
        for topic, kind, _ in self._found():
            counts[topic, kind] = counts.get((topic, kind), 0) + 1
        return tuple(Topic(name=name, type=kind, count=number) for (name, kind), number in sorted(counts.items()))

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """Receive the messages of a topic; of latched publishers also those from before."""
        from zenoh.ext import HistoryConfig, declare_advanced_subscriber  # noqa: PLC0415 - an extra

        key = f"{self._domain}/{topic.name.strip('/')}/{type_on_wire(topic.type)}/*"
        is_latched = any(quality.split(":")[1] == _LATCHED for name, _, quality in self._found() if name == topic.name)

        def hand_over(sample: "zenoh.Sample") -> None:
            """Hand over the CDR of a message."""
            receive(topic, sample.payload.to_bytes())

        if is_latched:
            history = HistoryConfig(detect_late_publishers=True)
            self._kept.append(declare_advanced_subscriber(self._network, key, hand_over, history=history))
        else:
            self._kept.append(self._network.declare_subscriber(key, hand_over))
        self._declare(_SUBSCRIPTION, topic, quality=_LATCHED_QUALITY if is_latched else _DEFAULT_QUALITY)

    def advertise(self, name: str, kind: str, *, is_latched: bool) -> Callable[[bytes], None]:
        """Return what publishes messages of a topic, each with its number, time and publisher attached."""
        import zenoh  # noqa: PLC0415 - an extra
        from zenoh.ext import CacheConfig, MissDetectionConfig, declare_advanced_publisher  # noqa: PLC0415

        key = f"{self._domain}/{name.strip('/')}/{type_on_wire(kind)}/{self._store.hash_rihs01(kind)}"
        remote = zenoh.Locality.REMOTE
        publisher: Any
        if is_latched:
            publisher = declare_advanced_publisher(
                self._network,
                key,
                allowed_destination=remote,
                cache=CacheConfig(1),
                sample_miss_detection=MissDetectionConfig(heartbeat=None, sporadic_heartbeat=_HEARTBEAT),
                publisher_detection=True,
            )
        else:
            publisher = self._network.declare_publisher(key, allowed_destination=remote)
        quality = _LATCHED_QUALITY if is_latched else _DEFAULT_QUALITY
        self._declare(_PUBLISHER, Topic(name=name, type=kind, count=0), quality=quality)
        gid, numbers = os.urandom(_GID_BYTES), count(1)

        def publish(message: bytes) -> None:
            """Publish one message; it is left out while the router is away."""
            attachment = struct.pack("<qqB", next(numbers), time.time_ns(), _GID_BYTES) + gid
            try:
                publisher.put(message, attachment=attachment)
            except zenoh.ZError as error:
                _LOGGER.debug("a message on %s was not published: %s", name, error)

        return publish

    def close(self) -> None:
        """Leave the network."""
        self._network.close()

    def _note(self, sample: "zenoh.Sample") -> None:
        """Note a token that appears or goes, in a thread of Zenoh."""
        import zenoh  # noqa: PLC0415 - an extra

        token = str(sample.key_expr)
        with self._lock:
            if sample.kind == zenoh.SampleKind.PUT:
                self._tokens.add(token)
            else:
                self._tokens.discard(token)

    def _found(self) -> list[tuple[str, str, str]]:
        """Return topic, type and quality of each publisher of others."""
        with self._lock:
            tokens = [token.split("/") for token in self._tokens]
        found = [each for each in tokens if len(each) == _PARTS and each[2] != self._own]
        return [
            (topic.replace("%", "/"), type_from_wire(kind), quality)
            for *_, topic, kind, _, quality in found
            if type_from_wire(kind)
        ]

    def _declare(self, entity: str, topic: Topic | None = None, *, quality: str = "") -> None:
        """Declare a token, by which ``ros2 topic list`` and other nodes find this one."""
        number = next(self._numbers)
        parts = [_TOKENS, str(self._domain), self._own, "0", str(number), entity, "%", "%", _NAME]
        if topic is not None:
            known = topic.type in self._store.fielddefs
            hashed = self._store.hash_rihs01(topic.type) if known else "RIHS01_"
            parts += [topic.name.replace("/", "%"), type_on_wire(topic.type), hashed, quality]
        self._kept.append(self._network.liveliness().declare_token("/".join(parts)))
