"""Localisation: the poses of a recording in a map that was made before, and how sure they are."""

import math
from dataclasses import dataclass

from echoplan.arrays import FloatArray, IntArray, checked_floats, checked_integers, store

__all__ = ["Localisation", "StartPose", "TrajectorySegment"]

# Probability from which the most likely first pose counts as the only one.
_SURE = 0.95


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class StartPose:
    """A pose at which a recording may begin.

    Parameters
    ----------
    pose : ndarray, shape (3,)
        x, y and yaw in the frame of the map [m, m, rad].
    weight : float
        Its probability among all poses that fit.
    """

    pose: FloatArray
    weight: float

    def __post_init__(self) -> None:
        store(self, pose=checked_floats(self.pose, name="pose", shape=(3,)))


@dataclass(frozen=True, slots=True, kw_only=True)
class TrajectorySegment:
    """A part of a recording that odometry connects.

    Parameters
    ----------
    first : int
        Number of its first sweep.
    starts : tuple of StartPose
        Poses at which it may begin, the most likely first.
    """

    first: int
    starts: tuple[StartPose, ...]

    @property
    def is_ambiguous(self) -> bool:
        """Whether other poses fit nearly as well, as in a room that is symmetric."""
        return self.starts[0].weight < _SURE


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Localisation:
    """Poses of a recording in a map.

    Parameters
    ----------
    sweeps : ndarray of int, shape (s,)
        Numbers of the sweeps.
    poses : ndarray, shape (s, 3)
        Pose of each in the frame of the map [m, m, rad].
    covariances : ndarray, shape (s, 3, 3)
        Covariances of the poses [m, m, rad].
    segments : tuple of TrajectorySegment
        One, and one more for each time that the robot was carried elsewhere.
    inlier_ratio : float
        Share of the echoes that the map explains.
    jaccard_index : float
        Explained arcs over all arcs and missed detections.  An arc is a group of neighbouring echoes of one object; a
        detection is missed if a station should detect a landmark of the map and does not.  A map of another place may
        explain most echoes, but has much that is not detected.
    """

    sweeps: IntArray
    poses: FloatArray
    covariances: FloatArray
    segments: tuple[TrajectorySegment, ...]
    inlier_ratio: float
    jaccard_index: float

    def __post_init__(self) -> None:
        count = len(self.sweeps)
        store(
            self,
            sweeps=checked_integers(self.sweeps, name="sweeps", shape=(count,)),
            poses=checked_floats(self.poses, name="poses", shape=(count, 3)),
            covariances=checked_floats(self.covariances, name="covariances", shape=(count, 3, 3)),
        )

    @property
    def is_ambiguous(self) -> bool:
        """Whether the first pose of a segment is not certain."""
        return any(each.is_ambiguous for each in self.segments)

    @property
    def percent_in_common(self) -> int:
        """Jaccard index in percent, rounded down: what is below a limit is not printed as the limit."""
        return math.floor(100.0 * self.jaccard_index + 1e-9)

    @property
    def kidnapped(self) -> tuple[int, ...]:
        """Sweeps before which the robot was carried elsewhere."""
        return tuple(each.first for each in self.segments[1:])
