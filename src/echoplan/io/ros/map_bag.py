"""Maps as a bag of ROS 2 in one mcap file, for RViz and Foxglove."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from operator import itemgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, IntArray, checked_floats, checked_integers
from echoplan.errors import InvalidValueError, MissingExtraError
from echoplan.geometry import compose, invert
from echoplan.io.files import by_name, written_whole
from echoplan.io.ros.map_markers import marker_array
from echoplan.io.ros.map_messages import Types, grid_message, odometry_message, path_message, transform_message
from echoplan.model import FeatureMap, OccupancyGrid

if TYPE_CHECKING:
    from rosbags.interfaces import Qos
    from rosbags.typesys.store import Typestore

__all__ = ["write_map_bag"]

_BASE, _ODOM = "base_link", "odom"
# Seconds of builtin_interfaces/Time are of 32 bits.
_STAMPS_BELOW = 2**31 * 10**9
# The value that rmw uses for "no deadline" [s, ns].
_NEVER = (9223372036, 854775807)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Topic:
    """Messages of one topic, each with its time [ns]; a latched topic is kept for those who subscribe later."""

    name: str
    messages: tuple[tuple[int, Any], ...]
    is_latched: bool = False


@by_name
def write_map_bag(
    path: Path,
    feature_map: FeatureMap,
    *,
    grid: OccupancyGrid,
    times_ns: ArrayLike,
    odom_from_base: ArrayLike | None = None,
) -> None:
    """Write a map for RViz and Foxglove: one mcap file with messages of ROS 2.

    ======================= ============================== ======================================================
    topic                   type                           content
    ======================= ============================== ======================================================
    ``/map``                nav_msgs/OccupancyGrid         the grid, with the cells of ``write_grid``
    ``/echoplan/markers``   visualization_msgs/MarkerArray walls, openings, corners with 95 % ellipses, cylinders
    ``/echoplan/path``      nav_msgs/Path                  all poses
    ``/echoplan/odometry``  nav_msgs/Odometry              each pose with its covariance, without velocities
    ``/tf``                 tf2_msgs/TFMessage             ``map`` to ``odom``, or to ``base_link`` without odometry
    ======================= ============================== ======================================================

    Parameters
    ----------
    path : Path or str
        The file, usually with the suffix ``.mcap``.
    feature_map : FeatureMap
        The map.
    grid : OccupancyGrid
        Its grid, as of ``echoplan.grids.grid_from_map``.
    times_ns : array_like of int, shape (s,)
        Time at which the robot was at each pose of the map [ns].
    odom_from_base : array_like, shape (s, 3), optional
        The same poses as recorded by the odometry of the robot [m, m, rad].

    Raises
    ------
    MissingExtraError
        If rosbags is not installed.
    InvalidValueError
        If times or odometry do not fit the poses, or a time is negative or after January 2038.
    OutputError
        If the file cannot be written.
    """
    count = len(feature_map.poses)
    stamps = checked_integers(times_ns, name="times_ns", shape=(count,))
    if count and not 0 <= stamps.min() <= stamps.max() < _STAMPS_BELOW:
        raise InvalidValueError(f"times_ns must lie in [0, {_STAMPS_BELOW}), not at {stamps.min()} to {stamps.max()}")
    given = None if odom_from_base is None else checked_floats(odom_from_base, name="odom_from_base", shape=(count, 3))
    store = _typestore()
    topics = [
        *_latched_topics(store.types, feature_map, grid=grid, stamps=stamps),
        *_pose_topics(store.types, feature_map, stamps=stamps, odom_from_base=given),
    ]
    with written_whole(path) as draft:
        folder = draft.with_name(f"{draft.name}.bag")
        _write(folder, topics, store=store)
        (folder / f"{folder.name}.mcap").rename(draft)


def _typestore() -> "Typestore":
    """Return the messages of ROS 2 Humble, which later distributions read too."""
    try:
        from rosbags.typesys import Stores, get_typestore  # noqa: PLC0415 - an extra
    except ImportError as error:
        raise MissingExtraError("rosbags", extra="ros") from error
    return get_typestore(Stores.ROS2_HUMBLE)


def _latched_topics(
    types: Types, feature_map: FeatureMap, *, grid: OccupancyGrid, stamps: IntArray
) -> Iterator[_Topic]:
    """Make the messages that hold from the first pose on: latched topics."""
    first = int(stamps.min()) if len(stamps) else 0
    messages = {
        "/map": grid_message(types, grid, stamp=first),
        "/echoplan/markers": marker_array(types, feature_map, stamp=first),
        "/echoplan/path": path_message(types, feature_map, stamps=stamps, stamp=first),
    }
    for name, message in messages.items():
        yield _Topic(name=name, messages=((first, message),), is_latched=True)


def _pose_topics(
    types: Types, feature_map: FeatureMap, *, stamps: IntArray, odom_from_base: FloatArray | None
) -> Iterator[_Topic]:
    """Make the messages of each pose: odometry and transforms."""
    if not len(stamps):
        return
    poses, covariances, frame = feature_map.poses, feature_map.pose_covariances, feature_map.frame
    covariances = covariances if len(covariances) else np.zeros((len(poses), 3, 3))
    child, transforms = _BASE, poses
    if odom_from_base is not None and frame != _ODOM:
        child, transforms = _ODOM, compose(poses, invert(odom_from_base))
    yield _Topic(
        name="/echoplan/odometry",
        messages=tuple(
            (stamp, odometry_message(types, pose, covariance=each, frame=frame, child=_BASE, stamp=stamp))
            for stamp, pose, each in zip(stamps.tolist(), poses, covariances, strict=True)
        ),
    )
    yield _Topic(
        name="/tf",
        messages=tuple(
            (stamp, transform_message(types, pose, frame=frame, child=child, stamp=stamp))
            for stamp, pose in zip(stamps.tolist(), transforms, strict=True)
        ),
    )


def _write(folder: Path, topics: Iterable[_Topic], *, store: "Typestore") -> None:
    """Write a bag of one mcap file, its messages in the order of time."""
    from rosbags.rosbag2 import StoragePlugin, Writer  # noqa: PLC0415 - an extra

    # Humble reads the numbers of version 8 for qualities of service, and later distributions do too.
    with Writer(folder, version=8, storage_plugin=StoragePlugin.MCAP) as writer:
        queue = []
        for topic in topics:
            kind = topic.messages[0][1].__msgtype__
            quality = _quality(is_latched=topic.is_latched)
            connection = writer.add_connection(topic.name, kind, typestore=store, offered_qos_profiles=[quality])
            queue += [(stamp, connection, message) for stamp, message in topic.messages]
        for stamp, connection, message in sorted(queue, key=itemgetter(0)):
            writer.write(connection, stamp, store.serialize_cdr(message, connection.msgtype))


def _quality(*, is_latched: bool) -> "Qos":
    """Return the quality of service: that of map_server, or the default of ROS 2."""
    from rosbags.interfaces import (  # noqa: PLC0415 - an extra
        Qos,
        QosDurability,
        QosHistory,
        QosLiveliness,
        QosReliability,
        QosTime,
    )

    never = QosTime(*_NEVER)
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if is_latched else 100,
        reliability=QosReliability.RELIABLE,
        durability=QosDurability.TRANSIENT_LOCAL if is_latched else QosDurability.VOLATILE,
        deadline=never,
        lifespan=never,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=never,
        avoid_ros_namespace_conventions=False,
    )
