"""Messages from a running ROS 2: which topics are read, and their numbers as rows, as those of bags."""

import struct
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING

from echoplan.errors import EchoplanError, InputError
from echoplan.io.ros.bag import Message, Topic, standard_typestore
from echoplan.io.ros.choice import choose_topics, first_names, named_topics
from echoplan.io.ros.messages import rows_of
from echoplan.io.ros.options import BagOptions
from echoplan.io.ros.series import Row
from echoplan.io.ros.wire.address import WireAddress
from echoplan.io.ros.wire.stream import Advance, Listening, Window, advance
from echoplan.io.ros.wire.transport import Transport

if TYPE_CHECKING:
    from rosbags.typesys.store import Typestore

__all__ = ["Incoming", "Start", "wait_for_sweeps"]

# Time between two looks at what came [s].
_MOMENT = 0.2
# After this time it is reported what is missing; and so long sensors and topics may follow the first ones [s].
_REPORTED, _SETTLED = 3.0, 2.0
# What errors and notes about the messages call their source, as they would a bag.
_PATH = Path("ROS 2")


class Incoming:
    """The messages of the topics that are read, since they were last taken.

    Parameters
    ----------
    transport : Transport
        What carries them.
    options : BagOptions
        Which topics and fields to read.
    """

    def __init__(self, transport: Transport, options: BagOptions) -> None:
        self._transport = transport
        self._options = options
        self._waiting: SimpleQueue[tuple[Topic, int, bytes]] = SimpleQueue()
        self._subscribed: set[Topic] = set()
        self._stores: dict[Topic, Typestore] = {}
        # Topics with readings.
        self._ranging: set[str] = set()

    def listen(self) -> Listening:
        """Subscribe to the topics that are there now and are read.

        Raises ``InputError`` if several topics have odometry, ``UnknownNameError`` if a named topic is not there.
        """
        topics = self._transport.topics()
        choice = choose_topics(topics, self._options, path=_PATH)
        known = {(topic.name, topic.type) for topic in self._subscribed}
        for topic in choice.topics:
            if (topic.name, topic.type) not in known:
                self._subscribed.add(topic)
                self._transport.subscribe(topic, lambda topic, raw: self._waiting.put((topic, time.time_ns(), raw)))
        self._ranging = {topic.name for topic in choice.readings}
        return Listening(path=_PATH, options=self._options, topics=topics, choice=choice)

    def rows(self, timeout: float = _MOMENT) -> list[Row]:
        """Return the numbers of the messages that came, after this time [s]."""
        time.sleep(timeout)
        return list(self._decoded())

    def explained(self, error: EchoplanError, address: WireAddress) -> EchoplanError:
        """Say in one line what is missing and what was seen; errors about options stay as they are."""
        if not isinstance(error, InputError) or error.source != str(_PATH):
            return error
        topics = self._transport.topics()
        if not topics:
            remedy = "start the robot, and check domain and network with: ros2 topic list"
            return InputError(address.text, f"no topics were found in domain {address.domain}", remedy=remedy)
        silent = sorted(topic.name for topic in self._subscribed - self._stores.keys())
        problem = ": ".join(filter(None, (error.place, error.problem)))
        if self._ranging and self._ranging.issubset(silent):
            problem = f"no message yet on {first_names(silent)}"
        if (seen := named_topics(topics)) not in problem:
            problem += f"; seen: {seen}"
        remedy = "publish what is missing, or name topics with --topic and --odom and mountings with --mount"
        return InputError(address.text, problem, remedy=remedy)

    def _decoded(self) -> Iterator[Row]:
        """Decode what came; a message that is damaged is left out."""
        while True:
            try:
                topic, log_ns, raw = self._waiting.get_nowait()
            except Empty:
                return
            body = self._decode(topic, raw)
            if body is not None:
                yield from rows_of(Message(topic=topic, log_ns=log_ns, body=body), self._options)

    def _decode(self, topic: Topic, raw: bytes) -> object | None:
        """Decode a message by the definitions of the distribution of ROS 2 that sent it; None if it is damaged."""
        from rosbags.serde import SerdeError  # noqa: PLC0415 - an extra

        if topic not in self._stores:
            store = standard_typestore(topic.type, raw)
            if store is None:
                problem = f"messages of type {topic.type} on {topic.name} are not of a package that echoplan knows"
                raise InputError(_PATH, problem, remedy="record them with ros2 bag record, and map the bag")
            self._stores[topic] = store
        try:
            decoded: object = self._stores[topic].deserialize_cdr(raw, topic.type)
        except (SerdeError, struct.error, LookupError, ValueError, AssertionError):
            return None
        return decoded


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Start:
    """What was found until sweeps can be made.

    Parameters
    ----------
    listening : Listening
        The topics.
    advanced : Advance
        The first pings.
    """

    listening: Listening
    advanced: Advance


def wait_for_sweeps(incoming: Incoming, address: WireAddress, *, report: Callable[[str], None]) -> Start:
    """Wait until ranges, mounting and poses of a robot are there.

    Parameters
    ----------
    incoming : Incoming
        Its messages.
    address : WireAddress
        Where it is, and how long to wait.
    report : callable
        Is given a line about what is missing, if it takes a while.

    Returns
    -------
    Start
        What was found.

    Raises
    ------
    InputError
        If something is still missing at the end.
    UnknownNameError
        If a topic that the user names is not there.
    """
    begin, reported, window = time.monotonic(), "", Window()
    while True:
        now = time.monotonic() - begin
        try:
            listening = incoming.listen()
            window = window.with_rows(incoming.rows())
            advance(window, (), listening=listening)
            listening, window = _settled(incoming, window)
            return Start(listening=listening, advanced=advance(window, (), listening=listening))
        except EchoplanError as error:
            problem = incoming.explained(error, address)
        if now >= address.wait:
            raise problem
        if now >= _REPORTED and str(problem) != reported:
            reported = str(problem)
            report(f"Waiting for up to {address.wait:g} s: {reported}")


def _settled(incoming: Incoming, window: Window) -> tuple[Listening, Window]:
    """Take the messages of sensors and topics that follow the first ones."""
    listening, end = incoming.listen(), time.monotonic() + _SETTLED
    while time.monotonic() < end:
        window = window.with_rows(incoming.rows())
        listening = incoming.listen()
    return listening, window
