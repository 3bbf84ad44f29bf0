"""Layout of the state vector: positions of landmarks, calibration and poses."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.joint.landmarks import PARAMETERS

__all__ = [
    "LANDMARK_COLUMNS",
    "NEIGHBOUR_COLUMNS",
    "POSE_COLUMNS",
    "READING_COLUMNS",
    "SONAR_COLUMNS",
    "SONAR_UNKNOWNS",
    "Layout",
]

# Calibration parameters in this order: range offset [m], walk gain [m], range scale, servo latency [s], servo gain,
# servo offset [rad], figure of merit [dB], logarithm of ka, exponent of the range walk.
SONAR_UNKNOWNS = (
    "range_offset",
    "walk_gain",
    "range_scale",
    "servo_latency",
    "servo_gain",
    "servo_offset",
    "figure_of_merit",
    "log_ka",
    "walk_exponent",
)


# First column of each block of the Jacobian of a reading (its landmark, the wall at the end of that, the sonar as
# above, its pose), and their number.
LANDMARK_COLUMNS = 0
NEIGHBOUR_COLUMNS = 3  # After those of a landmark.
SONAR_COLUMNS = 5  # After both coordinates of a wall.
POSE_COLUMNS = SONAR_COLUMNS + len(SONAR_UNKNOWNS)
READING_COLUMNS = POSE_COLUMNS + 3  # A pose has x, y and yaw.


@dataclass(frozen=True, eq=False, kw_only=True)
class Layout:
    """Positions of the unknowns in the state vector."""

    # Kind of each landmark, shape (f,).
    kinds: IntArray
    # Number of free poses.
    poses: int = 0

    @cached_property
    def counts(self) -> IntArray:
        """Number of parameters of each landmark, shape (f,)."""
        counts: IntArray = PARAMETERS[self.kinds]
        return counts

    @cached_property
    def free(self) -> BoolArray:
        """Which of three parameters each landmark has, shape (f, 3)."""
        free: BoolArray = np.arange(3) < self.counts[:, None]
        return free

    @cached_property
    def starts(self) -> IntArray:
        """First position of each landmark, shape (f,)."""
        starts: IntArray = np.concatenate([[0], np.cumsum(self.counts)])[:-1].astype(np.int64)
        return starts

    @cached_property
    def columns(self) -> IntArray:
        """Position of each parameter of each landmark, shape (f + 1, 3); -1 for none, as in all of the last row."""
        columns = np.where(self.free, self.starts[:, None] + np.arange(3), -1)
        return np.concatenate([columns, np.full((1, 3), -1)])

    @cached_property
    def sonar(self) -> int:
        """First position of the calibration."""
        return int(self.counts.sum())

    @property
    def pose(self) -> int:
        """First position of the poses."""
        return self.sonar + len(SONAR_UNKNOWNS)

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.pose + 3 * self.poses

    def feature(self, number: int) -> slice:
        """Return the positions of one landmark."""
        start = int(self.starts[number])
        return slice(start, start + int(self.counts[number]))

    def steps(self, step: FloatArray) -> FloatArray:
        """Return the steps of the landmarks in a solution, shape (f, 3), zero where one has no third parameter."""
        steps = np.zeros((len(self.kinds), 3))
        steps[self.free] = step[: self.sonar]
        return steps
