"""The solution of an optimisation: landmarks, calibration, poses and their covariance."""

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

# Length assumed for a wall that was detected at a single point [m].
_SHORTEST = 0.06


@dataclass(frozen=True, eq=False, kw_only=True)
class Solution:
    """Landmarks, calibration and poses after an optimisation, with their information.

    Parameters
    ----------
    reflectors : ndarray, shape (f, 4)
        Kind and parameters of the landmarks.
    model : EchoModel
        The sonar.
    latency : float
        Latency of the servo [s].
    servo : ServoError, optional
        Gain and offset of the servo.
    poses : ndarray, shape (s, 3)
        Poses of the stations [m, m, rad]; empty if they are fixed.
    layout : Layout
        Positions of the unknowns.
    information : ndarray, shape (u, u)
        Information matrix of all unknowns.
    measurement_information : ndarray, shape (u, u)
        Its part from pings, present and marginalised.
    information_inflation : float
        Ratio of the information of the readings to that which their weights give them.
    extents : ndarray, shape (f, 2)
        Lower and upper bound of the detected extent of walls, along them [m].
    owners : ndarray of int, shape (n,)
        Index of the landmark that explains each ping; -1 for none.
    residuals : ndarray, shape (n,)
        Reading minus predicted reading [m]; 0 for pings without a landmark.
    excesses : ndarray, shape (n,)
        Predicted signal excess [dB].
    newton_decrement : float
        Square of the Newton decrement at the last step.
    offset_sigma : float, optional
        Lower bound of the standard deviation of the range offset [m].
    model_error : float, optional
        Standard deviation of the model error of each end of a wall, and of a point [m].
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
        """Covariance of all unknowns, shape (u, u): the inverse of the information, with three corrections.

        Errors of the sonar model affect the calibration however many readings there are, but errors of single readings
        average out, even if their weights are too small by a factor f. With A, the information of the landmarks, and H,
        its part from pings, the covariance of the landmarks given the sonar is ``A^-1 (A - H + H / f) A^-1``, as that
        of any least-squares estimate whose weights are not the inverse variances (White 1980). The standard deviation
        of the range offset is at least ``offset_sigma``, and unknowns that depend on it are as uncertain (Schmidt
        1966). The model error of each landmark is added, since it does not average out.
        """
        covariance = solve(self.information, np.eye(self.layout.size))
        if self.information_inflation > 1.0:
            features, excess = slice(0, self.layout.sonar), 1.0 - 1.0 / self.information_inflation
            given_sonar = solve(self.information[features, features], np.eye(self.layout.sonar))
            measured = self.measurement_information[features, features]
            covariance[features, features] -= excess * given_sonar @ measured @ given_sonar
        offset = self.layout.sonar + SONAR_UNKNOWNS.index("range_offset")
        sensitivity, variance = covariance[:, offset] / covariance[offset, offset], covariance[offset, offset]
        covariance += max(self.offset_sigma**2 - variance, 0.0) * np.outer(sensitivity, sensitivity)
        for number in range(len(self.extents)):
            place = self.layout.feature(number)
            covariance[place, place] += self._model_covariance(number)
        return covariance

    def _model_covariance(self, number: int) -> FloatArray:
        """Return the covariance of the model error of one landmark.

        Both ends of a wall have independent errors, so the direction of a long wall is better known than that of a
        short one.
        """
        variance = self.model_error**2
        if self.layout.kinds[number] != Kind.WALL:
            return variance * np.eye(int(self.layout.counts[number]))
        low, high = self.extents[number].tolist()
        missing = max(_SHORTEST - (high - low), 0.0) / 2
        # A line that rotates by da and shifts by dr moves by dr - s da at the position s along it.
        inverse = np.linalg.inv([[missing - low, 1.0], [-missing - high, 1.0]])
        covariance: FloatArray = variance * inverse @ inverse.T
        return covariance

    @property
    def robust_sigma(self) -> float:
        """Robust standard deviation of the residuals [m]; ``nan`` if no reading is explained."""
        explained = np.abs(self.residuals[self.owners >= 0])
        return 1.4826 * float(np.median(explained)) if len(explained) else math.nan

    def sonar_sigmas(self) -> dict[str, float]:
        """Return the standard deviations of the calibration, by the names in ``SONAR_UNKNOWNS``."""
        variances = np.diag(self.covariance)[self.layout.sonar : self.layout.pose]
        return dict(zip(SONAR_UNKNOWNS, np.sqrt(variances).tolist(), strict=True))

    def considered_sigma(self, name: str, consider: str, sigma: float) -> float:
        """Return the standard deviation of a calibration parameter if another one is a consider parameter.

        ``P_xp / P_pp`` of the joint covariance P is the sensitivity of x to the consider parameter p, whose variance is
        raised to that of its prior, ``sigma`` squared (S. F. Schmidt, "Application of state-space methods to navigation
        problems", Adv. Control Syst. 3 (1966) 293).
        """
        x, p = (self.layout.sonar + SONAR_UNKNOWNS.index(each) for each in (name, consider))
        covariance = self.covariance
        slope = covariance[x, p] / covariance[p, p]
        return math.sqrt(covariance[x, x] + slope**2 * max(sigma**2 - covariance[p, p], 0.0))
