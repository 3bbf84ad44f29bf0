"""Bags for tests: what a robot with sonar publishes, written by rosbags, by mcap's own writer, or as Humble does."""

import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mcap_ros2.writer import Writer as McapWriter
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

from echoplan.model import Recording, Rig, Sensor, Source, Sweep

JAZZY = get_typestore(Stores.ROS2_JAZZY)
HUMBLE = get_typestore(Stores.ROS2_HUMBLE)
ROS1 = get_typestore(Stores.ROS1_NOETIC)
for _name in ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"):
    ROS1.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", _name))
RANGE, ODOMETRY, TF = "sensor_msgs/msg/Range", "nav_msgs/msg/Odometry", "tf2_msgs/msg/TFMessage"
# Noon of a day in 2025: a stamp that a floating-point number does not hold to the nanosecond.
NOON_NS = 1_760_000_000_000_000_000


class Sent(NamedTuple):
    """A message that a robot sent."""

    topic: str
    log_ns: int
    message: Any


class Robot:
    """Makes messages of one distribution of ROS."""

    def __init__(self, store: Typestore = JAZZY) -> None:
        self.store = store

    def make(self, kind: str, **fields: Any) -> Any:
        """Make a message."""
        return self.store.types[kind](**fields)

    def names_of(self, kind: str) -> list[str]:
        """Name the fields of a type."""
        return [name for name, _ in self.store.fielddefs[kind][1]]

    def header(self, frame: str, stamp_ns: int) -> Any:
        """Make a header; that of ROS 1 has a number, too."""
        seconds, nanoseconds = divmod(stamp_ns, 1_000_000_000)
        stamp = self.make("builtin_interfaces/msg/Time", sec=seconds, nanosec=nanoseconds)
        number = {"seq": 0} if "seq" in self.names_of("std_msgs/msg/Header") else {}
        return self.make("std_msgs/msg/Header", stamp=stamp, frame_id=frame, **number)

    def sonar(
        self,
        distance: float,
        *,
        stamp_ns: int,
        frame: str = "sonar",
        view: float = 0.5,
        least: float = 0.02,
        most: float = 4.0,
        kind: int = 0,
    ) -> Any:
        """Make a sensor_msgs/Range."""
        has_variance = "variance" in self.names_of(RANGE)
        limits = {"field_of_view": np.float32(view), "min_range": np.float32(least), "max_range": np.float32(most)}
        return self.make(
            RANGE,
            header=self.header(frame, stamp_ns),
            radiation_type=kind,
            range=np.float32(distance),
            **limits,
            **({"variance": np.float32(0.0)} if has_variance else {}),
        )

    def turn(self, yaw: float, *, pitch: float = 0.0) -> Any:
        """Make a quaternion: the pitch first, then the yaw."""
        sines, cosines = np.sin([yaw / 2, pitch / 2]), np.cos([yaw / 2, pitch / 2])
        return self.make(
            "geometry_msgs/msg/Quaternion",
            x=float(-sines[0] * sines[1]),
            y=float(cosines[0] * sines[1]),
            z=float(sines[0] * cosines[1]),
            w=float(cosines[0] * cosines[1]),
        )

    def odometry(self, pose: Sequence[float], *, stamp_ns: int, child: str = "base_link") -> Any:
        """Make a nav_msgs/Odometry."""
        point = self.make("geometry_msgs/msg/Point", x=float(pose[0]), y=float(pose[1]), z=0.0)
        place = self.make("geometry_msgs/msg/Pose", position=point, orientation=self.turn(float(pose[2])))
        still = self.make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
        twist = self.make("geometry_msgs/msg/Twist", linear=still, angular=still)
        return self.make(
            ODOMETRY,
            header=self.header("odom", stamp_ns),
            child_frame_id=child,
            pose=self.make("geometry_msgs/msg/PoseWithCovariance", pose=place, covariance=np.zeros(36)),
            twist=self.make("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)),
        )

    def transform(
        self, parent: str, child: str, pose: Sequence[float], *, stamp_ns: int = 0, pitch: float = 0.0
    ) -> Any:
        """Make a tf2_msgs/TFMessage of one transform."""
        shift = self.make("geometry_msgs/msg/Vector3", x=float(pose[0]), y=float(pose[1]), z=0.1)
        turn = self.turn(float(pose[2]), pitch=pitch)
        transform = self.make("geometry_msgs/msg/Transform", translation=shift, rotation=turn)
        stamped = self.make(
            "geometry_msgs/msg/TransformStamped",
            header=self.header(parent, stamp_ns),
            child_frame_id=child,
            transform=transform,
        )
        return self.make(TF, transforms=[stamped])


def drive(source: Source, robot: Robot, *, start_ns: int = NOON_NS) -> Iterator[Sent]:
    """Publish what a source recorded: a Range per ping, odometry at each, and the mounting in /tf_static.

    A turret is published on /tf, as robot_state_publisher does.
    """
    rig = source.rig
    x, y, yaw = rig.base_from_turret.tolist()
    sweeps = list(source)
    turns = any(np.ptp(sweep.servo_angles) > 0 for sweep in sweeps)
    parent = "turret" if turns else "base_link"
    for sensor in rig.sensors:
        mounting = (sensor.x, sensor.y, sensor.yaw)
        yield Sent("/tf_static", start_ns, robot.transform(parent, f"sonar_{sensor.sensor_id}", mounting))
    limits = {sensor.sensor_id: sensor for sensor in rig.sensors}
    for sweep in sweeps:
        columns = (sweep.stamps_ns, sweep.sensor_ids, sweep.servo_angles, sweep.ranges, sweep.map_from_base)
        for stamp_ns, sensor_id, angle, distance, pose in zip(*columns, strict=True):
            now_ns, sensor = start_ns + int(stamp_ns), limits[int(sensor_id)]
            if turns:
                yield Sent("/tf", now_ns, robot.transform("base_link", "turret", (x, y, yaw + angle), stamp_ns=now_ns))
            yield Sent("/odom", now_ns, robot.odometry(pose, stamp_ns=now_ns))
            message = robot.sonar(
                distance,
                stamp_ns=now_ns,
                frame=f"sonar_{sensor_id}",
                view=2.0 * sensor.half_aperture,
                least=sensor.min_range,
                most=sensor.max_range,
            )
            yield Sent(f"/sonar_{sensor_id}", now_ns + 1_000_000, message)


def write_mcap(path: Path, sent: Iterable[Sent], *, store: Typestore = JAZZY) -> Path:
    """Write a lone .mcap file with the writer of the mcap project."""
    with path.open("wb") as file:
        writer = McapWriter(file)
        schemas: dict[str, Any] = {}
        for topic, log_ns, message in sent:
            kind = message.__msgtype__
            if kind not in schemas:
                text, _ = store.generate_msgdef(kind, ros_version=2)
                schemas[kind] = writer.register_msgdef(kind, text)
            writer.write_message(topic, schemas[kind], _plain(message), log_time=log_ns, publish_time=log_ns)
        writer.finish()  # type: ignore[no-untyped-call]  # mcap-ros2-support has few annotations
    return path


def _plain(value: Any) -> Any:
    """Make dictionaries of messages and lists of arrays, as mcap's writer wants them."""
    if hasattr(value, "__dataclass_fields__"):
        names = [name for name in value.__dataclass_fields__ if name != "__msgtype__"]
        return {name: _plain(getattr(value, name)) for name in names}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else value


def write_ros2(
    path: Path,
    sent: Iterable[Sent],
    *,
    store: Typestore = JAZZY,
    sqlite: bool = False,
    compression: CompressionMode = CompressionMode.NONE,
) -> Path:
    """Write the folder of a ROS 2 bag with rosbags."""
    plugin = StoragePlugin.SQLITE3 if sqlite else StoragePlugin.MCAP
    writer = Writer2(path, version=9, storage_plugin=plugin)
    if compression is not CompressionMode.NONE:
        writer.set_compression(compression, CompressionFormat.ZSTD)
    with writer:
        connections: dict[str, Any] = {}
        for topic, log_ns, message in sent:
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], log_ns, store.serialize_cdr(message, kind))
    return path


def write_ros1(path: Path, sent: Iterable[Sent], *, store: Typestore = ROS1) -> Path:
    """Write a ROS 1 bag with rosbags; the messages must be those of ROS 1."""
    with Writer1(path) as writer:
        connections: dict[str, Any] = {}
        for topic, log_ns, message in sent:
            kind = message.__msgtype__
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=store)
            writer.write(connections[topic], log_ns, store.serialize_ros1(message, kind))
    return path


def write_humble_database(path: Path, sent: Iterable[Sent], *, store: Typestore = HUMBLE) -> Path:
    """Write a .db3 as ROS 2 Humble does: without definitions of the messages."""
    database = sqlite3.connect(path)
    database.executescript(
        """
        CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT NULL);
        INSERT INTO schema VALUES (3, 'humble');
        CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, metadata TEXT NOT NULL);
        CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL,
                            serialization_format TEXT NOT NULL, offered_qos_profiles TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL,
                              data BLOB NOT NULL);
        """
    )
    numbers: dict[str, int] = {}
    for topic, log_ns, message in sent:
        kind = message.__msgtype__
        if topic not in numbers:
            numbers[topic] = len(numbers) + 1
            database.execute("INSERT INTO topics VALUES (?, ?, ?, 'cdr', '')", (numbers[topic], topic, kind))
        data = bytes(store.serialize_cdr(message, kind))
        values = (numbers[topic], log_ns, data)
        database.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", values)
    database.commit()
    database.close()
    return path


def ring(count: int = 4) -> Rig:
    """Some sensors around a robot."""
    return Rig(
        name="ring",
        sensors=tuple(
            Sensor(
                sensor_id=number,
                x=0.1 * np.cos(2 * np.pi * number / count),
                y=0.1 * np.sin(2 * np.pi * number / count),
                yaw=float(2 * np.pi * number / count),
                half_aperture=0.25,
                min_range=0.02,
                max_range=4.0,
                resolution=0.001,
            )
            for number in range(count)
        ),
    )


def recorded_by(rig: Rig, *, rounds: int = 5, period_ns: int = 100_000_000) -> Recording:
    """A drive along x in which every sensor fires once a round, 1 ms after the one before."""
    ids = rig.sensor_ids
    sweeps = []
    for number in range(rounds):
        stamps = number * period_ns + 1_000_000 * np.arange(len(ids))
        poses = np.column_stack([1e-9 * stamps, np.zeros(len(ids)), np.full(len(ids), 0.1 * number)])
        ranges = np.round(1.02 + 0.1 * ids + 0.013 * number, 3)
        sweeps.append(
            Sweep(
                index=number,
                stamps_ns=stamps,
                sensor_ids=ids,
                servo_angles=np.zeros(len(ids)),
                ranges=ranges,
                map_from_base=poses,
            )
        )
    return Recording(name="drive", rig=rig, sweeps=tuple(sweeps))
