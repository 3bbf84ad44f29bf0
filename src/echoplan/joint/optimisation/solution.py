"""Solution: features, sonar and poses after an adjustment, and how well they are known."""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS, Layout
from echoplan.joint.optimisation.solver import solve
from echoplan.preprocessing.servo import AS_RECORDED, ServoError

__all__ = ["Solution"]

# As long a wall is drawn of which only one point was heard [m].
_SHORTEST = 0.06


@dataclass(frozen=True, eq=False, kw_only=True)
class Solution:
    """Features, sonar and their uncertainty after an adjustment.

    Parameters
    ----------
    reflectors : ndarray, shape (f, 4)
        Kind and parameters.
    model : EchoModel
        The sonar.
    latency : float
        By how much the servo lags behind what was recorded [s].
    servo : ServoError, optional
        Gain and offset of the servo.
    poses : ndarray, shape (s, 3)
        Poses of the stations [m, m, rad]; empty where they are not corrected.
    layout : Layout
        What stands where.
    information : ndarray, shape (u, u)
        Of all unknowns.
    measurement_information : ndarray, shape (u, u)
        The part of it that readings gave.
    information_inflation : float
        How many times more these tell than they were let count for.
    extents : ndarray, shape (f, 2)
        Ends of walls along them [m].
    owners : ndarray of int, shape (n,)
        Which feature explains each ping; -1 for none.
    residuals : ndarray, shape (n,)
        Reading less expected reading [m]; 0 where nothing explains it.
    excesses : ndarray, shape (n,)
        Expected signal excess [dB].
    newton_decrement : float
        Square of the last step, in deviations of what it moves: Newton's decrement.
    offset_sigma : float, optional
        How well the range offset is known at best [m].
    model_error : float, optional
        How well each end of a wall, or a point, is known at best beside that [m].
    """

    reflectors: FloatArray
    model: EchoModel
    latency: float
    servo: ServoError = AS_RECORDED
    poses: FloatArray
    layout: Layout
    information: FloatArray
    measurement_information: FloatArray
    information_inflation: float
    extents: FloatArray
    owners: IntArray
    residuals: FloatArray
    excesses: FloatArray
    newton_decrement: float
    offset_sigma: float = 0.0
    model_error: float = 0.0

    @cached_property
    def covariance(self) -> FloatArray:
        """Covariance of all unknowns, shape (u, u).

        What the model of the sonar lacks pulls at its numbers, however many readings there are.  The errors of single
        readings average out, even if these were let count for 1 / f of what they tell: with H, the part of the
        information A that readings gave, features scatter about what the sonar has them at by
        ``A^-1 (A - H + H / f) A^-1``, as any least-squares estimate with other weights than those of the errors does
        (White 1980).  The range offset is known no better than to ``offset_sigma``, and what moves with it is as
        uncertain (Schmidt 1966).  What the model lacks about each feature does not average out either.
        """
        covariance = solve(self.information, np.eye(self.layout.size))
        if self.information_inflation > 1.0:
            features, excess = slice(0, self.layout.sonar), 1.0 - 1.0 / self.information_inflation
            about = solve(self.information[features, features], np.eye(self.layout.sonar))
            covariance[features, features] -= excess * about @ self.measurement_information[features, features] @ about
        offset = self.layout.sonar + SONAR_UNKNOWNS.index("range_offset")
        jacobian, variance = covariance[:, offset] / covariance[offset, offset], covariance[offset, offset]
        covariance += max(self.offset_sigma**2 - variance, 0.0) * np.outer(jacobian, jacobian)
        for number in range(len(self.extents)):
            place = self.layout.feature(number)
            covariance[place, place] += self._model_covariance(number)
        return covariance

    def _model_covariance(self, number: int) -> FloatArray:
        """Covariance of what the model lacks about one feature.

        Both ends of a wall err by themselves, so that a long wall turns less than a short one.
        """
        variance = self.model_error**2
        if self.layout.kinds[number] != Kind.WALL:
            return variance * np.eye(int(self.layout.counts[number]))
        low, high = self.extents[number].tolist()
        missing = max(_SHORTEST - (high - low), 0.0) / 2
        # A line that turns by da and moves by dr moves by dr - s da at the place s along it.
        inverse = np.linalg.inv([[missing - low, 1.0], [-missing - high, 1.0]])
        covariance: FloatArray = variance * inverse @ inverse.T
        return covariance

    @property
    def scatter(self) -> float:
        """Robust standard deviation of the residuals [m]; ``nan`` if nothing is explained."""
        explained = np.abs(self.residuals[self.owners >= 0])
        return 1.4826 * float(np.median(explained)) if len(explained) else math.nan

    def sonar_sigmas(self) -> dict[str, float]:
        """Tell how well each number of the sonar is known.

        Returns
        -------
        dict of str to float
            Standard deviations by the names of ``SONAR_UNKNOWNS``.
        """
        variances = np.diag(self.covariance)[self.layout.sonar : self.layout.pose]
        return dict(zip(SONAR_UNKNOWNS, np.sqrt(variances).tolist(), strict=True))

    def considered_sigma(self, name: str, consider: str, sigma: float) -> float:
        """Return how well a number of the sonar is known if the readings do not tell a consider parameter.

        Of the joint covariance P, ``P_xp / P_pp`` is how far x moves with the parameter p; what p may be off by its
        prior standard deviation adds to the rest of x (S. F. Schmidt, "Application of state-space methods to navigation
        problems", Adv. Control Syst. 3 (1966) 293).
        """
        x, p = (self.layout.sonar + SONAR_UNKNOWNS.index(each) for each in (name, consider))
        covariance = self.covariance
        slope = covariance[x, p] / covariance[p, p]
        return math.sqrt(covariance[x, x] + slope**2 * max(sigma**2 - covariance[p, p], 0.0))
