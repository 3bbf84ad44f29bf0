"""The unknowns of a map: features, the sonar, poses; where each stands in one long vector."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray

__all__ = ["SONAR_UNKNOWNS", "Layout"]

# Of the sonar, in this order: range offset [m], walk gain [m], range scale, servo latency [s], servo gain, servo
# offset [rad], figure of merit [dB], logarithm of the beam's ka, exponent of the range walk.
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


@dataclass(frozen=True, eq=False, kw_only=True)
class Layout:
    """Where each unknown stands.

    Parameters
    ----------
    kinds : ndarray of int, shape (f,)
        Kind of each feature.
    poses : int, optional
        How many poses are free.
    """

    kinds: IntArray
    poses: int = 0

    @cached_property
    def counts(self) -> IntArray:
        """How many parameters each feature has."""
        return np.where(self.kinds == Kind.CYLINDER, 3, 2)

    @cached_property
    def free(self) -> BoolArray:
        """Which of three parameters each feature has, shape (f, 3)."""
        free: BoolArray = np.arange(3) < self.counts[:, None]
        return free

    @cached_property
    def starts(self) -> IntArray:
        """Where the parameters of each feature start."""
        starts: IntArray = np.concatenate([[0], np.cumsum(self.counts)])[:-1].astype(np.int64)
        return starts

    @cached_property
    def columns(self) -> IntArray:
        """Where each parameter of each feature stands, and in the last row of none, shape (f + 1, 3); -1 is nowhere."""
        columns = np.where(self.free, self.starts[:, None] + np.arange(3), -1)
        return np.concatenate([columns, np.full((1, 3), -1)])

    @cached_property
    def sonar(self) -> int:
        """Where those of the sonar start."""
        return int(self.counts.sum())

    @property
    def pose(self) -> int:
        """Where those of the poses start."""
        return self.sonar + len(SONAR_UNKNOWNS)

    @property
    def size(self) -> int:
        """How many there are."""
        return self.pose + 3 * self.poses

    def feature(self, number: int) -> slice:
        """Return the place of one feature."""
        start = int(self.starts[number])
        return slice(start, start + int(self.counts[number]))

    def steps(self, step: FloatArray) -> FloatArray:
        """Take the steps of the features out of a solution.

        Parameters
        ----------
        step : ndarray, shape (size,)
            The solution.

        Returns
        -------
        ndarray, shape (f, 3)
            By feature, with zeros where one has no third parameter.
        """
        steps = np.zeros((len(self.kinds), 3))
        steps[self.free] = step[: self.sonar]
        return steps
