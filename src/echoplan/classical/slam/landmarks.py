"""Measurement models of lines and circles with their Jacobians, and the inverse models that initialise landmarks.

A sighting is a located point in ``base_link``: the hub that received it, the bearing of the reflector's normal and its
distance.  A line ``(normal_angle, offset)`` with its normal away from the robot and a circle
``(x, y, radius)`` each predict both.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.extraction import LocatedPoint
from echoplan.geometry import directions, transform_points, wrap

__all__ = ["CIRCLE", "LINE", "Expectation", "Shape", "expect_circle", "expect_line"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Expectation:
    """Predicted sighting of a landmark.

    Parameters
    ----------
    values : ndarray, shape (2,)
        Bearing in ``base_link`` and distance from the hub [rad, m].
    by_pose : ndarray, shape (2, 3)
        Derivatives by the pose ``(x, y, yaw)``.
    by_landmark : ndarray, shape (2, p)
        Derivatives by the parameters of the landmark.
    """

    values: FloatArray
    by_pose: FloatArray
    by_landmark: FloatArray

    def residual(self, point: LocatedPoint) -> FloatArray:
        """Subtract the prediction from a sighting.

        Parameters
        ----------
        point : LocatedPoint
            The sighting.

        Returns
        -------
        ndarray, shape (2,)
            Bearing and distance [rad, m].
        """
        bearing, distance = self.values
        return np.array([float(wrap(point.bearing - bearing)), point.distance - distance])


@dataclass(frozen=True, slots=True, kw_only=True)
class Shape:
    """Kind of a landmark.

    Parameters
    ----------
    name : str
        Its name.
    size : int
        Number of its parameters.
    expect : callable
        Takes pose, parameters and hub in ``base_link``; gives an `Expectation`.
    place : callable
        Takes pose, sighting and a prior of the radius; gives the parameters of which that is the sighting.
    """

    name: str
    size: int
    expect: Callable[[FloatArray, FloatArray, FloatArray], Expectation]
    place: Callable[[FloatArray, LocatedPoint, float], FloatArray]


def expect_line(pose: FloatArray, line: FloatArray, hub_xy: FloatArray) -> Expectation:
    """Predict the sighting of a line.

    Parameters
    ----------
    pose : ndarray, shape (3,)
        Of the robot [m, m, rad].
    line : ndarray, shape (2,)
        ``(normal_angle, offset)`` [rad, m].
    hub_xy : ndarray, shape (2,)
        Hub in ``base_link`` [m].

    Returns
    -------
    Expectation
        ``normal_angle - yaw`` and ``offset - n . hub``.

    Examples
    --------
    >>> expect_line(np.array([1.0, 0.0, 0.5]), np.array([0.0, 3.0]), np.zeros(2)).values
    array([-0.5,  2. ])
    """
    angle, offset = line
    hub, turning = _hub(pose, hub_xy)
    normal, tangent = directions(angle), directions(angle + np.pi / 2)
    return Expectation(
        values=np.array([float(wrap(angle - pose[2])), offset - normal @ hub]),
        by_pose=np.array([[0.0, 0.0, -1.0], [*-normal, -normal @ turning]]),
        by_landmark=np.array([[1.0, 0.0], [-tangent @ hub, 1.0]]),
    )


def expect_circle(pose: FloatArray, circle: FloatArray, hub_xy: FloatArray) -> Expectation:
    """Predict the sighting of a circle.

    Parameters
    ----------
    pose : ndarray, shape (3,)
        Of the robot [m, m, rad].
    circle : ndarray, shape (3,)
        ``(x, y, radius)`` [m].
    hub_xy : ndarray, shape (2,)
        Hub in ``base_link`` [m].

    Returns
    -------
    Expectation
        Direction of the centre less yaw, and distance of the centre less the radius.

    Examples
    --------
    >>> expect_circle(np.zeros(3), np.array([0.0, 2.0, 0.5]), np.zeros(2)).values.round(4)
    array([1.5708, 1.5   ])
    """
    hub, turning = _hub(pose, hub_xy)
    away = circle[:2] - hub
    depth = max(float(np.hypot(*away)), 1e-9)
    unit, across = away / depth, np.array([-away[1], away[0]]) / depth**2
    return Expectation(
        values=np.array([float(wrap(np.arctan2(away[1], away[0]) - pose[2])), depth - circle[2]]),
        by_pose=np.array([[*-across, -across @ turning - 1.0], [*-unit, -unit @ turning]]),
        by_landmark=np.array([[*across, 0.0], [*unit, -1.0]]),
    )


def _hub(pose: FloatArray, hub_xy: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Hub in the map, and its derivative by yaw."""
    hub = transform_points(pose, hub_xy)
    x, y = hub - pose[:2]
    return hub, np.array([-y, x])


def _place_line(pose: FloatArray, point: LocatedPoint, _: float) -> FloatArray:
    hub, _turning = _hub(pose, point.hub_xy)
    angle = pose[2] + point.bearing
    return np.array([angle, directions(angle) @ hub + point.distance])


def _place_circle(pose: FloatArray, point: LocatedPoint, radius: float) -> FloatArray:
    hub, _turning = _hub(pose, point.hub_xy)
    center = hub + (point.distance + radius) * directions(pose[2] + point.bearing)
    return np.array([*center, radius])


LINE = Shape(name="line", size=2, expect=expect_line, place=_place_line)
CIRCLE = Shape(name="circle", size=3, expect=expect_circle, place=_place_circle)
