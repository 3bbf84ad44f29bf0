"""Odometry: how far dead reckoning may be off, as specified by a robot's maker or a calibration."""

from dataclasses import asdict, dataclass

from echoplan.arrays import checked_number

__all__ = ["Odometry"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Odometry:
    """Errors of dead reckoning: a random walk whose standard deviation grows with the square root of the distance.

    A missing value gets a default; if all are missing, they are estimated.

    Parameters
    ----------
    along, lateral : float, optional
        Deviation along and across the way after 1 m [m].
    yaw_per_metre : float, optional
        Deviation of the heading after 1 m [rad].
    yaw_per_radian : float, optional
        Deviation of the heading after a turn of 1 rad [rad].

    Raises
    ------
    InvalidValueError
        If a number is negative or not finite.
    """

    along: float | None = None
    lateral: float | None = None
    yaw_per_metre: float | None = None
    yaw_per_radian: float | None = None

    def __post_init__(self) -> None:
        for name, value in asdict(self).items():
            if value is not None:
                checked_number(value, name=name, minimum=0.0)
