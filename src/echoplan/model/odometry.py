"""Odometry: how far dead reckoning may be off, as a robot's maker or a calibration tells it."""

from dataclasses import asdict, dataclass

from echoplan.arrays import checked_number

__all__ = ["Odometry"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Odometry:
    """How dead reckoning goes astray: a random walk, so that its deviation grows with the root of the way.

    Parameters
    ----------
    along, lateral : float
        Deviation along and across the way after 1 m [m].
    yaw_per_metre : float
        Deviation of the heading after 1 m [rad].
    yaw_per_radian : float
        Deviation of the heading after a turn of 1 rad [rad].

    Raises
    ------
    InvalidValueError
        If a number is negative or not finite.
    """

    along: float = 0.0
    lateral: float = 0.0
    yaw_per_metre: float = 0.0
    yaw_per_radian: float = 0.0

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            checked_number(value, name=name, minimum=0.0)
