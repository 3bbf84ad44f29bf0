"""The pose of the robot at each ping: from odometry, from transforms, or from fields that the user names."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.errors import InputError
from echoplan.io.ros.choice import first_names
from echoplan.io.ros.contents import BagContents
from echoplan.io.ros.frames import Step, plane_pose, span_ns, transforms_along, way_between
from echoplan.io.ros.series import Role, Series, interpolate

__all__ = ["Trajectory", "base_frame_of", "poses_at", "trajectory_of"]

_BASES = ("base_link", "base_footprint")
# REP 105: odometry is continuous, a map's frame jumps where the robot is localised anew.
_WORLDS = ("odom", "map", "world")
# Between poses farther apart in time than this [ns], the path is unknown, unless the robot hardly moved [m, rad].
_LONGEST_GAP_NS, _STILL, _STILL_TURN = 1_000_000_000, 0.05, 0.05
_STAND_STILL = "if the robot stood still, add --field x=0 --field y=0 --field yaw=0"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Trajectory:
    """Where the robot was.

    Parameters
    ----------
    origin : str
        Where the poses come from, as text for the user.
    base : str
        Frame of the robot.
    world : str
        Frame of its poses; empty if no message names it.
    series : Series, optional
        Poses [m, m, rad] over time; None if they come from fields alone.
    """

    origin: str
    base: str
    world: str
    series: Series | None


def base_frame_of(read: BagContents) -> str:
    """Name the frame of the robot: the child frame of the odometry, else the usual one."""
    children = [key.child for key in read.of_role(Role.POSE) if key.child]
    usual = [frame for name in _BASES if (frame := read.frames.find(name))]
    return (children or usual or list(_BASES))[0]


def trajectory_of(read: BagContents) -> Trajectory:
    """Find the poses of the robot: odometry first, transforms otherwise.

    Raises ``InputError`` if nothing in the bag or in the options says where the robot was.
    """
    base = base_frame_of(read)
    found = read.of_role(Role.POSE)
    if len(found) > 1:
        pairs = ", ".join(f"{key.frame} > {key.child}" for key in found)
        problem, remedy = f"its poses are in several frames: {pairs}", "name another topic with --odom"
        raise InputError(read.path, problem, place=next(iter(found)).topic, remedy=remedy)
    for key, series in found.items():
        poses = series.finite()
        if not len(poses):
            problem = "none of its poses has finite numbers and a valid orientation"
            raise InputError(read.path, problem, place=key.topic, remedy=f"name another topic: --odom; {_STAND_STILL}")
        return Trajectory(origin=key.topic, base=base, world=key.frame, series=poses)
    if all(read.options.field(key) for key in ("x", "y", "yaw")):
        return Trajectory(origin="--field", base=base, world="", series=None)
    return _of_transforms(read, base)


def _of_transforms(read: BagContents, base: str) -> Trajectory:
    for world in filter(None, map(read.frames.find, _WORLDS)):
        way = way_between(read.frames, world, end=base)
        if way and not all(step.is_fixed for step in way):
            origin = f"the transforms from {world} to {base}"
            return Trajectory(origin=origin, base=base, world=world, series=_of_way(way))
    problem = f"it has no poses of the robot: no nav_msgs/Odometry and no transform from odom to {base}"
    if read.frames.names:
        problem += f" (its frames are {first_names(sorted(read.frames.names))})"
    raise InputError(read.path, problem, remedy=f"record /odom, or name a topic of poses with --odom; {_STAND_STILL}")


def poses_at(trajectory: Trajectory, read: BagContents, *, stamps_ns: IntArray) -> tuple[FloatArray, BoolArray]:
    """Interpolate the poses of the robot: linearly in x and y, the shorter way round in yaw.

    Returns the poses, shape (n, 3) [m, m, rad], and whether each is known.
    """
    if trajectory.series is None:
        poses, known = np.zeros((len(stamps_ns), 3)), np.ones(len(stamps_ns), dtype=np.bool_)
    else:
        poses, known = interpolate(trajectory.series, stamps_ns, angles=(2,))
        known &= ~_in_gap(trajectory.series, stamps_ns)
    for place, key in enumerate(("x", "y", "yaw")):
        constant, series = read.options.constant(key), read.field(key)
        if constant is not None:
            poses[:, place] = constant
        elif series is not None:
            column, within = interpolate(series, stamps_ns, angles=(0,) if key == "yaw" else ())
            poses[:, place], known = column[:, 0], known & within
    return poses, known


def _of_way(way: Sequence[Step]) -> Series:
    """Take the poses at every time at which a transform on the path is known."""
    first, last = span_ns(way)
    moments = np.unique(np.concatenate([step.series.stamps_ns for step in way if not step.is_fixed]))
    moments = moments[(moments >= first) & (moments <= last)]
    return Series(log_ns=moments, stamps_ns=moments, values=plane_pose(transforms_along(way, moments)))


def _in_gap(series: Series, stamps_ns: IntArray) -> BoolArray:
    """Return which times lie between two poses so far apart in time that the path between is unknown."""
    if not len(series):
        return np.zeros(len(stamps_ns), dtype=np.bool_)
    steps = np.diff(series.values, axis=0)
    moved = (np.hypot(steps[:, 0], steps[:, 1]) > _STILL) | (np.abs(np.sin(steps[:, 2] / 2)) > _STILL_TURN / 2)
    is_gap = np.append((np.diff(series.stamps_ns) > _LONGEST_GAP_NS) & moved, False)
    before = np.searchsorted(series.stamps_ns, stamps_ns, side="right") - 1
    on_knot = series.stamps_ns[before.clip(0)] == stamps_ns
    in_gap: BoolArray = (before >= 0) & is_gap[before.clip(0)] & ~on_knot
    return in_gap
