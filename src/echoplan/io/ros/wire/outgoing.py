"""What echoplan publishes in a running ROS 2: the map, its markers, and where odometry lies in it."""

import time
from threading import Event, Thread
from typing import Any

from echoplan.arrays import FloatArray
from echoplan.geometry import identity
from echoplan.io.ros.map_markers import marker_array
from echoplan.io.ros.map_messages import grid_message, transform_message
from echoplan.io.ros.wire.transport import Transport
from echoplan.model import FeatureMap, OccupancyGrid

__all__ = ["MapPublisher"]

# Time between two transforms, and how far ahead of now they are stamped: until well after the next one comes [s].
_PERIOD, _AHEAD = 0.05, 0.1
# The thread of the transforms ends within this time [s].
_PATIENCE = 1.0
_MAP, _GRID, _MARKERS, _TRANSFORM = (
    "map",
    "nav_msgs/msg/OccupancyGrid",
    "visualization_msgs/msg/MarkerArray",
    "tf2_msgs/msg/TFMessage",
)


class MapPublisher:
    """Publishes a map that grows.

    ``/map`` (nav_msgs/OccupancyGrid) and ``/echoplan/markers`` (visualization_msgs/MarkerArray) are latched: who
    subscribes later gets the newest. The transform from ``map`` to the frame of odometry is published on ``/tf`` twenty
    times a second; it is the identity until the first map.

    Parameters
    ----------
    transport : Transport
        What carries the messages.
    world : str
        Frame of odometry; if it is empty or ``map`` itself, no transform is published.
    """

    def __init__(self, transport: Transport, *, world: str) -> None:
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 - an extra

        self._store = get_typestore(Stores.LATEST)
        self._world = world
        self._map_from_odom: FloatArray = identity()
        self._clock_offset_ns = 0
        self._publish_grid = transport.advertise("/map", _GRID, is_latched=True)
        self._publish_markers = transport.advertise("/echoplan/markers", _MARKERS, is_latched=True)
        self._closed = Event()
        self._thread = Thread(target=self._keep_publishing, args=(transport,), name="echoplan tf", daemon=True)
        if world not in ("", _MAP):
            self._thread.start()

    def set_clock(self, offset_ns: int) -> None:
        """State by how much the clock of the robot is ahead of this computer's [ns]."""
        self._clock_offset_ns = offset_ns

    def publish(self, feature_map: FeatureMap, *, grid: OccupancyGrid, map_from_odom: FloatArray) -> None:
        """Publish a new map, and where odometry lies in it [m, m, rad] from now on."""
        self._map_from_odom = map_from_odom
        stamp = self._now_ns()
        self._publish_grid(self._encoded(grid_message(self._store.types, grid, stamp=stamp)))
        markers = marker_array(self._store.types, feature_map, stamp=stamp, replaces=True)
        self._publish_markers(self._encoded(markers))

    def close(self) -> None:
        """Publish nothing more."""
        self._closed.set()
        if self._thread.is_alive():
            self._thread.join(_PATIENCE)

    def _now_ns(self) -> int:
        """Return the time by the clock of the robot [ns]; messages have no time before 1970."""
        return max(time.time_ns() + self._clock_offset_ns, 0)

    def _encoded(self, message: Any) -> bytes:
        return bytes(self._store.serialize_cdr(message, message.__msgtype__))

    def _keep_publishing(self, transport: Transport) -> None:
        """Publish the transform again and again, in a thread of its own."""
        publish = transport.advertise("/tf", _TRANSFORM, is_latched=False)
        while not self._closed.wait(_PERIOD):
            stamp = self._now_ns() + round(_AHEAD * 1e9)
            message = transform_message(
                self._store.types, self._map_from_odom, frame=_MAP, child=self._world, stamp=stamp
            )
            publish(self._encoded(message))
