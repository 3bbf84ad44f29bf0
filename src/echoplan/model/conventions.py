"""Conventions: how a recording writes what echoplan expects in metres, radians and counter-clockwise angles."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from math import pi
from types import MappingProxyType

import numpy as np

from echoplan.arrays import FloatArray, checked_number
from echoplan.errors import InvalidValueError
from echoplan.model.sweep import Sweep

__all__ = ["UNITS", "Axes", "Conventions", "Heading"]

# Metres in each unit of length that may be named.
UNITS: Mapping[str, float] = MappingProxyType({"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048})


class Heading(StrEnum):
    """How headings are counted."""

    COUNTER_CLOCKWISE = "counter-clockwise"  # from +x, as REP 103 has it
    CLOCKWISE = "clockwise"  # from +x
    COMPASS = "compass"  # clockwise from +y


class Axes(StrEnum):
    """Which way the recorded x and y point."""

    XY = "xy"  # y is left of x, as REP 103 has it
    YX = "yx"  # the columns are swapped
    Y_DOWN = "x-y"  # y is right of x, as on a screen


# Yaw is an angle plus or minus the heading.
_YAWS = {Heading.COUNTER_CLOCKWISE: (0.0, 1.0), Heading.CLOCKWISE: (0.0, -1.0), Heading.COMPASS: (pi / 2, -1.0)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Conventions:
    """How a recording writes angles, lengths and poses; the default is SI and REP 103.

    Parameters
    ----------
    servo_sign : int, optional
        -1 where recorded servo angles grow clockwise.
    servo_offset : float, optional
        Servo angle where 0 is recorded [rad].
    servo_gain : float, optional
        How far the servo turns where a radian is recorded.
    range_unit, position_unit : float, optional
        Unit of the ranges, and of x and y [m].
    heading : Heading, optional
        How headings are counted.
    axes : Axes, optional
        Which way x and y point.

    Raises
    ------
    InvalidValueError
        If a sign is neither 1 nor -1, or a unit or gain is not positive.

    Examples
    --------
    >>> half_turn = Conventions(servo_offset=-pi / 2)  # a servo of 0 to 180 degrees that looks ahead at 90
    >>> half_turn.servo_angles(np.array([0.0, pi / 2])).round(3).tolist()
    [-1.571, 0.0]
    """

    servo_sign: int = 1
    servo_offset: float = 0.0
    servo_gain: float = 1.0
    range_unit: float = 1.0
    position_unit: float = 1.0
    heading: Heading = Heading.COUNTER_CLOCKWISE
    axes: Axes = Axes.XY

    def __post_init__(self) -> None:
        if self.servo_sign not in (1, -1):
            raise InvalidValueError(f"servo_sign must be 1 or -1, not {self.servo_sign}")
        checked_number(self.servo_offset, name="servo_offset")
        for name in ("servo_gain", "range_unit", "position_unit"):
            checked_number(getattr(self, name), name=name, above=0.0)

    def servo_angles(self, recorded: FloatArray) -> FloatArray:
        """Convert recorded servo angles [rad]."""
        angles: FloatArray = self.servo_sign * self.servo_gain * recorded + self.servo_offset
        return angles

    def with_servo(self, *, gain: float, offset: float) -> "Conventions":
        """Put a gain and an offset [rad] that a servo was found to have on top of these conventions."""
        return replace(self, servo_gain=gain * self.servo_gain, servo_offset=gain * self.servo_offset + offset)

    def ranges(self, recorded: FloatArray) -> FloatArray:
        """Convert recorded ranges [m]."""
        ranges: FloatArray = self.range_unit * recorded
        return ranges

    def poses(self, recorded: FloatArray) -> FloatArray:
        """Convert recorded x, y and headings, shape (n, 3) [m, m, rad]."""
        xy, (zero, sign) = self._turned_axes(recorded[:, :2]), _YAWS[self.heading]
        return np.column_stack([self.position_unit * xy, zero + sign * recorded[:, 2]])

    def apply(self, sweep: Sweep) -> Sweep:
        """Convert a sweep as recorded to SI and REP 103.

        Parameters
        ----------
        sweep : Sweep
            As recorded.

        Returns
        -------
        Sweep
            The same pings.
        """
        return replace(
            sweep,
            servo_angles=self.servo_angles(sweep.servo_angles),
            ranges=self.ranges(sweep.ranges),
            map_from_base=self.poses(sweep.map_from_base),
        )

    def undo(self, sweep: Sweep) -> Sweep:
        """Convert a sweep back to what was recorded.

        Parameters
        ----------
        sweep : Sweep
            In SI and REP 103.

        Returns
        -------
        Sweep
            What ``apply`` makes it of.
        """
        x, y, yaw = sweep.map_from_base.T
        xy = self._turned_axes(np.column_stack([x, y]) / self.position_unit)
        zero, sign = _YAWS[self.heading]
        return replace(
            sweep,
            servo_angles=self.servo_sign * (sweep.servo_angles - self.servo_offset) / self.servo_gain,
            ranges=sweep.ranges / self.range_unit,
            map_from_base=np.column_stack([xy, sign * (yaw - zero)]),
        )

    def _turned_axes(self, points_xy: FloatArray) -> FloatArray:
        """Swap or mirror axes; doing so twice changes nothing."""
        if self.axes is Axes.YX:
            return points_xy[:, ::-1]
        return points_xy * (1.0, -1.0) if self.axes is Axes.Y_DOWN else points_xy
