"""Messages of ROS 2 about a map: its grid, poses and frames."""

from collections.abc import Mapping
from math import cos, sin
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, IntArray
from echoplan.io.grid_map import trinary_cells
from echoplan.model import FeatureMap, OccupancyGrid

__all__ = [
    "Types",
    "grid_message",
    "header",
    "odometry_message",
    "path_message",
    "point",
    "pose_message",
    "transform_message",
    "vector",
]

# Message classes by their full names, as a type store of rosbags has them.
Types: TypeAlias = Mapping[str, Any]

# Indices of x, y and the rotation about z in (x, y, z, rotations about x, y and z).
_PLANAR = np.array([0, 1, 5])


def time_message(types: Types, stamp: int) -> Any:
    """Make a time from nanoseconds."""
    seconds, nanoseconds = divmod(stamp, 10**9)
    return types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds)


def header(types: Types, frame: str, *, stamp: int) -> Any:
    """Make a header."""
    return types["std_msgs/msg/Header"](stamp=time_message(types, stamp), frame_id=frame)


def point(types: Types, position_xy: ArrayLike, *, z: float = 0.0) -> Any:
    """Make a point from x and y [m]."""
    x, y = np.asarray(position_xy, dtype=np.float64).tolist()
    return types["geometry_msgs/msg/Point"](x=x, y=y, z=z)


def rotation(types: Types, yaw: float) -> Any:
    """Make a quaternion from a rotation about the z axis [rad]."""
    return types["geometry_msgs/msg/Quaternion"](x=0.0, y=0.0, z=sin(yaw / 2), w=cos(yaw / 2))


def pose_message(types: Types, pose: FloatArray, *, z: float = 0.0) -> Any:
    """Make a pose from ``(x, y, yaw)`` [m, m, rad]."""
    return types["geometry_msgs/msg/Pose"](
        position=point(types, pose[:2], z=z), orientation=rotation(types, float(pose[2]))
    )


def vector(types: Types, xyz: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Any:
    """Make a vector."""
    x, y, z = xyz
    return types["geometry_msgs/msg/Vector3"](x=x, y=y, z=z)


def grid_message(types: Types, grid: OccupancyGrid, *, stamp: int) -> Any:
    """Make the message of a grid, with the cells that map_server would publish."""
    rows, columns = grid.values.shape
    info = types["nav_msgs/msg/MapMetaData"](
        map_load_time=time_message(types, stamp),
        resolution=grid.resolution,
        width=columns,
        height=rows,
        origin=pose_message(types, np.append(grid.origin_xy, 0.0)),
    )
    return types["nav_msgs/msg/OccupancyGrid"](
        header=header(types, grid.frame, stamp=stamp), info=info, data=trinary_cells(grid).ravel()
    )


def path_message(types: Types, feature_map: FeatureMap, *, stamps: IntArray, stamp: int) -> Any:
    """Make the message of all poses."""
    poses = [
        types["geometry_msgs/msg/PoseStamped"](
            header=header(types, feature_map.frame, stamp=when), pose=pose_message(types, pose)
        )
        for when, pose in zip(stamps.tolist(), feature_map.poses, strict=True)
    ]
    return types["nav_msgs/msg/Path"](header=header(types, feature_map.frame, stamp=stamp), poses=poses)


def odometry_message(
    types: Types, pose: FloatArray, *, covariance: FloatArray, frame: str, child: str, stamp: int
) -> Any:
    """Make the message of one pose, shape (3,), with its covariance, shape (3, 3); the velocities stay zero."""
    whole = np.zeros((6, 6))
    whole[np.ix_(_PLANAR, _PLANAR)] = covariance
    still = types["geometry_msgs/msg/Twist"](linear=vector(types), angular=vector(types))
    return types["nav_msgs/msg/Odometry"](
        header=header(types, frame, stamp=stamp),
        child_frame_id=child,
        pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose_message(types, pose), covariance=whole.ravel()),
        twist=types["geometry_msgs/msg/TwistWithCovariance"](twist=still, covariance=np.zeros(36)),
    )


def transform_message(types: Types, pose: FloatArray, *, frame: str, child: str, stamp: int) -> Any:
    """Make the message of one transform, which takes points from the child frame to the parent frame."""
    x, y, yaw = pose.tolist()
    transform = types["geometry_msgs/msg/Transform"](
        translation=vector(types, (x, y, 0.0)), rotation=rotation(types, yaw)
    )
    stamped = types["geometry_msgs/msg/TransformStamped"](
        header=header(types, frame, stamp=stamp), child_frame_id=child, transform=transform
    )
    return types["tf2_msgs/msg/TFMessage"](transforms=[stamped])
