"""What one ultrasonic sensor can do, and what its transducer is made of."""

from dataclasses import dataclass
from math import pi

from echoplan.arrays import checked_number
from echoplan.errors import InvalidValueError

__all__ = ["Sensor", "Transducer"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensor:
    """One sensor on the turret.

    Parameters
    ----------
    sensor_id : int
        Its number in the recording.
    x, y : float
        Acoustic centre in the turret's frame at servo angle 0 [m]; its distance from the axis is the arm b of
        Eq. 1 of the paper.
    yaw : float
        Direction of the beam axis in the turret's frame [rad].
    half_aperture : float
        Half of the opening angle within which a wall is detected [rad].
    min_range, max_range : float
        Dead distance and reach [m]; a range is valid if it lies between them (REP 117).
    resolution : float
        Step of the readings [m].

    Raises
    ------
    InvalidValueError
        If a number is out of its physical bounds.
    """

    sensor_id: int
    x: float = 0.0
    y: float = 0.0
    yaw: float = 0.0
    half_aperture: float
    min_range: float
    max_range: float
    resolution: float

    def __post_init__(self) -> None:
        checked_number(self.x, name="x")
        checked_number(self.y, name="y")
        checked_number(self.yaw, name="yaw")
        checked_number(self.half_aperture, name="half_aperture", above=0.0, maximum=pi)
        checked_number(self.min_range, name="min_range", minimum=0.0)
        checked_number(self.max_range, name="max_range", above=0.0)
        checked_number(self.resolution, name="resolution", minimum=0.0)
        if self.min_range >= self.max_range:
            raise InvalidValueError(
                f"min_range must be less than max_range, not {self.min_range:g} against {self.max_range:g}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Transducer:
    """The electro-acoustics behind a sensor: what the simulator has to know and a recording need not contain.

    Parameters
    ----------
    frequency : float
        Carrier [Hz].
    piston_radius : float
        Radius of the circular piston that sends, and of the one that receives [m].
    figure_of_merit : float
        Source level less detection threshold: how far above the threshold an echo would lie that came back
        over 1 m of path from a perfect mirror, without absorption [dB].
    quality_factor : float
        Q of the sending and of the receiving resonator.
    burst_cycles : float
        Carrier cycles in the burst.

    Raises
    ------
    InvalidValueError
        If a number is out of its physical bounds.
    """

    frequency: float = 40_000.0
    piston_radius: float = 0.0081
    figure_of_merit: float = 29.9
    quality_factor: float = 20.0
    burst_cycles: float = 8.0

    def __post_init__(self) -> None:
        checked_number(self.frequency, name="frequency", above=0.0)
        checked_number(self.piston_radius, name="piston_radius", above=0.0)
        checked_number(self.figure_of_merit, name="figure_of_merit")
        checked_number(self.quality_factor, name="quality_factor", above=0.0)
        checked_number(self.burst_cycles, name="burst_cycles", above=0.0)
