"""What carries messages of ROS 2 over a network: topics, and messages as CDR; opened by its address."""

from collections.abc import Callable
from typing import Protocol

from echoplan.io.ros.bag import Topic
from echoplan.io.ros.wire.address import Middleware, WireAddress

__all__ = ["Transport", "open_transport", "type_from_wire", "type_on_wire"]

# Is given the topic and the message as CDR, in a thread of the transport.
Receive = Callable[[Topic, bytes], None]


class Transport(Protocol):
    """A participant in the network of a ROS 2; messages of its own do not come back to it."""

    def topics(self) -> tuple[Topic, ...]:
        """Return the topics of others by name, each with its number of publishers."""
        ...

    def subscribe(self, topic: Topic, receive: Receive) -> None:
        """Receive the messages of one of the topics; of a latched one also those that were published before."""
        ...

    def advertise(self, name: str, kind: str, *, is_latched: bool) -> Callable[[bytes], None]:
        """Return what publishes messages; the newest of a latched topic is kept for those who subscribe later."""
        ...

    def close(self) -> None:
        """Leave the network."""
        ...


def open_transport(address: WireAddress) -> Transport:
    """Join the network of a ROS 2.

    Parameters
    ----------
    address : WireAddress
        Where it is.

    Returns
    -------
    Transport
        The participant; close it at the end.

    Raises
    ------
    InputError
        If the network cannot be joined.
    MissingExtraError
        If cyclonedds or eclipse-zenoh is not installed.
    """
    if address.middleware is Middleware.ZENOH:
        from echoplan.io.ros.wire.zenoh_transport import ZenohTransport  # noqa: PLC0415 - an extra

        return ZenohTransport(address)
    from echoplan.io.ros.wire.dds_transport import DdsTransport  # noqa: PLC0415 - an extra

    return DdsTransport(address)


def type_on_wire(kind: str) -> str:
    """Return the name that the middlewares of ROS 2 give to a type, as ``sensor_msgs::msg::dds_::Range_``."""
    *packages, name = kind.split("/")
    return "::".join([*packages, "dds_", f"{name}_"])


def type_from_wire(name: str) -> str:
    """Return the type of a name on the wire, as ``sensor_msgs/msg/Range``; empty if it is none of ROS."""
    *packages, mark, last = name.split("::") if name.count("::") >= 2 else ("", "")
    return "/".join([*packages, last.removesuffix("_")]) if mark == "dds_" else ""
