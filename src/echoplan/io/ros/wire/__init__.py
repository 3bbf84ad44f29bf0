"""A running ROS 2 over the network: messages in and out through Cyclone DDS or Zenoh (the extra ``ros-live``)."""

from echoplan.io.ros.wire.address import Middleware, WireAddress, is_address, parse_address
from echoplan.io.ros.wire.incoming import Incoming, Start, wait_for_sweeps
from echoplan.io.ros.wire.outgoing import MapPublisher
from echoplan.io.ros.wire.stream import Advance, Listening, Window, advance
from echoplan.io.ros.wire.transport import Transport, open_transport

__all__ = [
    "Advance",
    "Incoming",
    "Listening",
    "MapPublisher",
    "Middleware",
    "Start",
    "Transport",
    "Window",
    "WireAddress",
    "advance",
    "is_address",
    "open_transport",
    "parse_address",
    "wait_for_sweeps",
]
