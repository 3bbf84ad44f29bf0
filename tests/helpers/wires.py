"""A network that a test is all of: what is published is kept, and what the test sends is received."""

from collections import defaultdict
from collections.abc import Callable
from typing import Any

from echoplan.io.ros.bag import Topic
from helpers.bags import JAZZY, Sent


class FakeTransport:
    """Has the topics of some messages, and sends these when it is told to."""

    def __init__(self, sent: list[Sent]) -> None:
        self.sent = sent
        self.published: defaultdict[str, list[Any]] = defaultdict(list)
        self.latched: set[str] = set()
        self.receivers: dict[str, tuple[Topic, Callable[[Topic, bytes], None]]] = {}
        self.is_closed = False

    def topics(self) -> tuple[Topic, ...]:
        kinds = {each.topic: each.message.__msgtype__ for each in self.sent}
        return tuple(Topic(name=name, type=kind, count=1) for name, kind in sorted(kinds.items()))

    def subscribe(self, topic: Topic, receive: Callable[[Topic, bytes], None]) -> None:
        self.receivers[topic.name] = (topic, receive)

    def advertise(self, name: str, kind: str, *, is_latched: bool) -> Callable[[bytes], None]:
        if is_latched:
            self.latched.add(name)
        return lambda raw: self.published[name].append(JAZZY.deserialize_cdr(raw, kind))

    def close(self) -> None:
        self.is_closed = True

    def send(self, messages: list[Sent]) -> None:
        for each in messages:
            if each.topic in self.receivers:
                topic, receive = self.receivers[each.topic]
                receive(topic, bytes(JAZZY.serialize_cdr(each.message, topic.type)))
