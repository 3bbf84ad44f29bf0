"""Where the sensors are mounted, and how a servo turns them, from the transforms in a bag."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.errors import InputError, UnknownNameError
from echoplan.geometry import compose, identity, invert, wrap
from echoplan.io.ros.contents import BagContents
from echoplan.io.ros.frames import Step, plane_pose, span_ns, transforms_along, way_between
from echoplan.io.ros.messages import LASER_SCAN
from echoplan.io.ros.readings import Readings
from echoplan.io.ros.series import Series, SeriesKey, interpolate

__all__ = ["Mounting", "mountings_of", "names_of"]

# A mounting that varies by less is rigid [m, rad]: a suspension sways by less, and a servo moves in larger steps.
_RIGID, _RIGID_TURN = 0.01, math.radians(0.5)
# A steeper beam hits the floor or the ceiling instead of walls [rad].
_STEEPEST = math.radians(45.0)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Mounting:
    """Where a sensor is mounted.

    Parameters
    ----------
    base_from_turret : ndarray, shape (3,)
        Pose of the axis of the servo in the base; that of the base itself for a rigid sensor.
    turret_from_sensor : ndarray, shape (3,)
        Pose of the sensor at servo angle 0 [m, m, rad].
    servo_angles : ndarray, shape (n,)
        Angle of the servo at each ping [rad].
    known : ndarray of bool, shape (n,)
        Whether the angle is known.
    joint : str
        Frame that the servo turns; empty for a rigid sensor.
    elevation : float
        Angle of the beam above the plane [rad].
    is_assumed : bool
        Whether the mounting is unknown, so that the pose is an assumption.
    """

    base_from_turret: FloatArray
    turret_from_sensor: FloatArray
    servo_angles: FloatArray
    known: BoolArray
    joint: str = ""
    elevation: float = 0.0
    is_assumed: bool = False

    @property
    def is_level(self) -> bool:
        """Whether the beam hits walls rather than the floor or the ceiling."""
        return abs(self.elevation) <= _STEEPEST


def mountings_of(read: BagContents, readings: Readings, *, base: str) -> dict[SeriesKey, Mounting]:
    """Find where each sensor is mounted and how a servo turns it.

    Raises ``InputError`` if there is no transform to a sensor, or it moves in any way but about one upright axis, and
    ``UnknownNameError`` if the user states the mounting of a sensor that is not read.
    """
    stated = _stated_poses(read, readings)
    found: dict[SeriesKey, Mounting] = {}
    for key, series in readings.items():
        pose = next((stated[name] for name in names_of(key) if name in stated), None)
        mounting = _transformed(read, key, series=series, base=base) if pose is None else _rigid(pose, len(series))
        found[key] = _turned(read, key, series=series, mounting=mounting)
    return found


def _stated_poses(read: BagContents, readings: Readings) -> dict[str, FloatArray]:
    """Return the mountings that the user states, shape (3,) [m, m, rad], by sensor name."""
    known = {name for key in readings for name in names_of(key)}
    unknown = [mount.frame for mount in read.options.mounts if mount.frame not in known]
    # Without readings, the error about readings comes first.
    if known and unknown:
        raise UnknownNameError("sensor of --mount", unknown[0], known=known)
    return {mount.frame: np.array([mount.x, mount.y, mount.yaw]) for mount in read.options.mounts}


def names_of(key: SeriesKey) -> list[str]:
    """Return the names of a sensor: its field if the message has several ranges, its frame, its topic."""
    return [name for name in (key.child, key.frame, key.topic.strip("/")) if name]


def _transformed(read: BagContents, key: SeriesKey, *, series: Series, base: str) -> Mounting:
    way = way_between(read.frames, base, end=key.frame) if key.frame else None
    if way is not None:
        return _along(way, series.stamps_ns, key=key, path=read.path)
    if len(read.options.ranges) == 1 and not read.frames.names:
        # Messages of a custom type without frames: assume a sensor at the middle of the robot.
        return replace(_rigid(identity(), len(series)), is_assumed=True)
    problem = f"there is no transform from {base} to {key.frame}" if key.frame else "its messages name no frame"
    mount = f"state where it is mounted: --mount {names_of(key)[0]}=X,Y,YAW [m, m, rad]"
    remedy = f"record /tf_static (and /tf), {mount}, or name the other topics with --topic"
    raise InputError(read.path, problem, place=key.topic, remedy=remedy)


def _turned(read: BagContents, key: SeriesKey, *, series: Series, mounting: Mounting) -> Mounting:
    """Add the servo angles to a rigid mounting: the bearings of a scan, or the field that the user names."""
    if any(topic.name == key.topic and topic.type == LASER_SCAN for topic in read.choice.readings):
        return replace(
            mounting,
            base_from_turret=mounting.turret_from_sensor,
            turret_from_sensor=identity(),
            servo_angles=series.column("bearing"),
            joint=key.frame,
        )
    stated, servo = read.options.field("servo"), read.field("servo")
    if stated is None or servo is None:
        return mounting
    if mounting.joint:
        problem = f"the transforms already turn {key.frame} with {mounting.joint}"
        raise InputError("--field", problem, place=f"servo={stated}", remedy="leave it out")
    angles, known = interpolate(servo, series.stamps_ns, angles=(0,))
    return replace(mounting, servo_angles=angles[:, 0], known=mounting.known & known, joint=str(stated))


def _rigid(pose: FloatArray, count: int, *, elevation: float = 0.0) -> Mounting:
    return Mounting(
        base_from_turret=identity(),
        turret_from_sensor=pose,
        servo_angles=np.zeros(count),
        known=np.ones(count, dtype=np.bool_),
        elevation=elevation,
    )


def _along(way: Sequence[Step], stamps_ns: IntArray, *, key: SeriesKey, path: Path) -> Mounting:
    matrices = transforms_along(way, stamps_ns)
    poses = plane_pose(matrices)
    elevation = float(np.arcsin(np.median(matrices[:, 2, 0]).clip(-1.0, 1.0)))
    if _is_rigid(poses):
        return _rigid(_middle(poses), len(poses), elevation=elevation)
    for place, step in enumerate(way):
        in_base = plane_pose(transforms_along(way[: place + 1], stamps_ns))
        if step.is_fixed or _is_rigid(in_base):
            continue
        # The servo turns the first frame that moves.
        before = _middle(plane_pose(transforms_along(way[:place], stamps_ns)))
        turret = np.array([*np.median(in_base[:, :2], axis=0), before[2]])
        angles = np.unwrap(in_base[:, 2] - before[2])
        turned = np.column_stack([np.zeros_like(angles), np.zeros_like(angles), angles])
        in_turret = compose(invert(compose(turret, turned)), poses)
        if not _is_rigid(in_turret):
            break
        first, last = span_ns(way)
        return Mounting(
            base_from_turret=turret,
            turret_from_sensor=_middle(in_turret),
            servo_angles=angles,
            known=(stamps_ns >= first) & (stamps_ns <= last),
            joint=step.end,
            elevation=elevation,
        )
    problem = f"{key.frame} moves relative to the robot, other than by turning about one upright axis"
    remedy = f"state a rigid mounting: --mount {key.frame}=X,Y,YAW [m, m, rad]"
    raise InputError(path, problem, place=key.topic, remedy=remedy)


def _is_rigid(poses: FloatArray) -> bool:
    off = np.abs(poses - poses[0])
    return bool((off[:, :2] <= _RIGID).all() and (np.abs(wrap(off[:, 2])) <= _RIGID_TURN).all())


def _middle(poses: FloatArray) -> FloatArray:
    turns = wrap(poses[:, 2] - poses[0, 2])
    yaw = wrap(poses[0, 2] + np.median(turns))
    return np.array([*np.median(poses[:, :2], axis=0), float(yaw)])
