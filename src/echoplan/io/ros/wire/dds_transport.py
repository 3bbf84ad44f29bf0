"""ROS 2 over DDS, by Cyclone DDS: any of its DDS middlewares is understood."""

import logging
import os
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from threading import Event, Lock, Thread
from typing import TYPE_CHECKING, Any

from echoplan.errors import InputError, MissingExtraError
from echoplan.io.ros.bag import Topic
from echoplan.io.ros.wire.address import WireAddress
from echoplan.io.ros.wire.dds_types import wire_type
from echoplan.io.ros.wire.transport import Receive, type_from_wire

if TYPE_CHECKING:
    from cyclonedds.builtin import DcpsEndpoint
    from cyclonedds.core import Qos

__all__ = ["DdsTransport"]

_LOGGER = logging.getLogger(__name__)
# What the DDS middlewares of ROS 2 put before the names of topics.
_PREFIX = "rt"
# Messages of one topic that wait for the reader, and that are taken at once.
_DEPTH, _BATCH = 1000, 100
# Time in which the reader looks for new subscriptions and the end [s].
_MOMENT = 0.1
# How long a publisher waits for a reader that is full, and a reader for the end of its thread [s].
_BLOCKING, _PATIENCE = 0.1, 2.0
# Peers are looked for at the ports of so many participants of a machine.
_PARTICIPANTS = 120


class DdsTransport:
    """A participant in a domain of DDS.

    ``CYCLONEDDS_URI`` configures it like every program with Cyclone DDS.

    Parameters
    ----------
    address : WireAddress
        The domain, and a peer for networks without multicast.

    Raises
    ------
    InputError
        If the domain cannot be joined.
    MissingExtraError
        If cyclonedds or rosbags is not installed.
    """

    def __init__(self, address: WireAddress) -> None:
        try:
            from cyclonedds.builtin import BuiltinDataReader, BuiltinTopicDcpsPublication  # noqa: PLC0415 - an extra
            from cyclonedds.core import WaitSet  # noqa: PLC0415
            from cyclonedds.domain import Domain, DomainParticipant  # noqa: PLC0415
        except ImportError as error:
            raise MissingExtraError("cyclonedds", extra="ros-live") from error
        try:
            from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 - an extra
        except ImportError as error:
            raise MissingExtraError("rosbags", extra="ros-live") from error

        self._store = get_typestore(Stores.LATEST)
        with _in_one_line(address):
            self._domain = Domain(address.domain, _configuration(address))
            self._participant = DomainParticipant(address.domain)
            self._publications = BuiltinDataReader(self._participant, BuiltinTopicDcpsPublication)
            self._waiting = WaitSet(self._participant)
        self._offers: dict[int, DcpsEndpoint] = {}
        # What must not be collected while it is used, and what is read.
        self._kept: list[Any] = []
        self._readers: list[tuple[Any, Topic, Receive]] = []
        self._lock, self._closed = Lock(), Event()
        self._thread = Thread(target=self._read, name="echoplan dds", daemon=True)
        self._thread.start()

    def topics(self) -> tuple[Topic, ...]:
        """Return the topics of others by name, each with its number of publishers."""
        counts: dict[tuple[str, str], int] = {}
        for offer in self._found():
            kind = type_from_wire(offer.type_name)
            if kind and offer.topic_name.startswith(f"{_PREFIX}/"):
                key = (offer.topic_name.removeprefix(_PREFIX), kind)
                counts[key] = counts.get(key, 0) + 1
        return tuple(Topic(name=name, type=kind, count=count) for (name, kind), count in sorted(counts.items()))

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """Receive the messages of a topic that is there, as reliably as its publishers offer it."""
        from cyclonedds.core import Policy, ReadCondition, SampleState  # noqa: PLC0415 - an extra
        from cyclonedds.sub import DataReader  # noqa: PLC0415

        offers = [each for each in self._found() if each.topic_name == f"{_PREFIX}{topic.name}"]
        # Publishers that describe their type are only matched by the same type.
        described = any(each.type_id is not None for each in offers)
        quality = self._quality(
            topic.type,
            depth=_DEPTH,
            is_reliable=all(each.qos[Policy.Reliability] != Policy.Reliability.BestEffort for each in offers),
            is_latched=all(each.qos[Policy.Durability] != Policy.Durability.Volatile for each in offers),
        )
        reader = DataReader(self._participant, self._topic(topic, is_opaque=not described), qos=quality)
        with self._lock:
            self._readers.append((reader, topic, receive))
        self._waiting.attach(ReadCondition(reader, SampleState.NotRead))

    def advertise(self, name: str, kind: str, *, is_latched: bool) -> Callable[[bytes], None]:
        """Return what publishes messages of a topic, reliably."""
        from cyclonedds.core import DDSException  # noqa: PLC0415 - an extra
        from cyclonedds.pub import DataWriter  # noqa: PLC0415

        topic = self._topic(Topic(name=name, type=kind, count=0), is_opaque=False)
        quality = self._quality(kind, depth=1 if is_latched else _BATCH, is_reliable=True, is_latched=is_latched)
        writer = DataWriter(self._participant, topic, qos=quality)
        self._kept.append(writer)

        def publish(message: bytes) -> None:
            """Publish one message; one that a slow reader has no room for is left out."""
            try:
                writer.write(topic.data_type(message))
            except DDSException as error:
                _LOGGER.debug("a message on %s was not published: %s", name, error)

        return publish

    def close(self) -> None:
        """Leave the domain; Cyclone DDS deletes all that belongs to it, too, and does nothing the second time."""
        self._closed.set()
        self._thread.join(_PATIENCE)
        self._domain.__del__()

    def _found(self) -> list["DcpsEndpoint"]:
        """Return the publishers of others that are there now."""
        while changes := self._publications.take(_BATCH):
            for each in changes:
                if each.sample_info.valid_data:
                    self._offers[each.sample_info.instance_handle] = each
                else:
                    self._offers.pop(each.sample_info.instance_handle, None)
        own = self._participant.guid
        return [each for each in self._offers.values() if each.participant_key != own]

    def _topic(self, topic: Topic, *, is_opaque: bool) -> Any:
        from cyclonedds.topic import Topic as DdsTopic  # noqa: PLC0415 - an extra

        kind = wire_type(topic.type, None if is_opaque else self._store)
        made: Any = DdsTopic(self._participant, f"{_PREFIX}{topic.name}", kind)
        self._kept.append(made)
        return made

    def _quality(self, kind: str, *, depth: int, is_reliable: bool, is_latched: bool) -> "Qos":
        """Return the quality of service, with the hash of the type as ROS 2 states it from Iron on."""
        from cyclonedds.core import Policy, Qos  # noqa: PLC0415 - an extra
        from cyclonedds.util import duration  # noqa: PLC0415

        blocking = duration(seconds=_BLOCKING)
        known = kind in self._store.fielddefs
        return Qos(
            Policy.Reliability.Reliable(blocking) if is_reliable else Policy.Reliability.BestEffort,
            Policy.Durability.TransientLocal if is_latched else Policy.Durability.Volatile,
            Policy.History.KeepLast(depth),
            Policy.IgnoreLocal.Participant,
            Policy.DataRepresentation(use_cdrv0_representation=True),
            Policy.Userdata(f"typehash={self._store.hash_rihs01(kind)};".encode() if known else b""),
        )

    def _read(self) -> None:
        """Hand over what comes, in a thread of its own, until the transport is closed."""
        from cyclonedds.util import duration  # noqa: PLC0415 - an extra

        while not self._closed.is_set():
            self._waiting.wait(duration(seconds=_MOMENT))
            with self._lock:
                readers = [*self._readers]
            for reader, topic, receive in readers:
                while messages := reader.take(_BATCH):
                    for message in messages:
                        if message.sample_info.valid_data:
                            receive(topic, message.data)


def _configuration(address: WireAddress) -> str:
    """Write the configuration of Cyclone DDS: that of the user, and the peer.

    Raises ``InputError`` if the peer has no address: Cyclone DDS would end the program.
    """
    parts = [os.environ.get("CYCLONEDDS_URI", "")]
    if address.is_local:
        parts.append(
            '<General><Interfaces><NetworkInterface address="127.0.0.1" multicast="false"/></Interfaces>'
            "<AllowMulticast>false</AllowMulticast></General>"
        )
    if address.host:
        try:
            host = socket.gethostbyname(address.host)
        except OSError as error:
            remedy = "check its name and the network, or write its IP address"
            raise InputError(address.text, f"the host {address.host} was not found", remedy=remedy) from error
        parts.append(
            f"<Discovery><ParticipantIndex>auto</ParticipantIndex><MaxAutoParticipantIndex>{_PARTICIPANTS}"
            f'</MaxAutoParticipantIndex><Peers><Peer address="{host}"/></Peers></Discovery>'
        )
    return ",".join(filter(None, parts))


@contextmanager
def _in_one_line(address: WireAddress) -> Iterator[None]:
    """Turn what Cyclone DDS raises about a domain into an ``InputError``."""
    from cyclonedds.core import DDSException  # noqa: PLC0415 - an extra

    try:
        yield
    except DDSException as error:
        problem = f"the domain {address.domain} of DDS cannot be joined ({error.msg})"
        remedy = "check the host, the network and CYCLONEDDS_URI"
        raise InputError(address.text, problem, remedy=remedy) from error
