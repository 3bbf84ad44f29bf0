"""Settings of the simulator."""

import math
from typing import Literal

from pydantic import Field

from echoplan.acoustics import Air
from echoplan.settings import Settings

__all__ = ["OdometryNoise", "SimulationSettings"]

# Ultrasound in air is not detected from farther than this [m]; dead reckoning that drifts by more is useless [m, rad].
_FARTHEST, _LARGEST_DRIFT = 50.0, 100.0
# No servo turns ten times as far as commanded.
_LARGEST_GAIN = 10.0


class OdometryNoise(Settings):
    """Errors of dead reckoning: a random walk whose standard deviation grows with the square root of the distance."""

    along: float = Field(
        default=0.0,
        ge=0.0,
        le=_LARGEST_DRIFT,
        description="Standard deviation of odometry along the path after 1 m [m].",
    )
    lateral: float = Field(
        default=0.0,
        ge=0.0,
        le=_LARGEST_DRIFT,
        description="Standard deviation of odometry across the path after 1 m [m].",
    )
    yaw_per_metre: float = Field(
        default=0.0, ge=0.0, le=_LARGEST_DRIFT, description="Standard deviation of the heading after 1 m [rad]."
    )
    yaw_per_radian: float = Field(
        default=0.0,
        ge=0.0,
        le=_LARGEST_DRIFT,
        description="Standard deviation of the heading after a turn of 1 rad [rad].",
    )


class SimulationSettings(Settings):
    """Settings of the simulator; the defaults are a hard room, a sound module and a robot that knows where it is."""

    air: Air = Field(default=Air(), description="Air in the room.")
    assumed_temperature: float = Field(
        default=20.0,
        ge=-30.0,
        le=60.0,
        description="Temperature with which the module turns time into range, at 50 % humidity, unless the rig "
        "states its speed of sound [degrees Celsius].",
    )
    zero_distance: float = Field(
        default=1.0,
        gt=0.0,
        le=_FARTHEST,
        description="Distance of the plane on the axis at which the module was calibrated [m].",
    )
    zero_error: float = Field(
        default=0.0,
        ge=-_FARTHEST,
        le=_FARTHEST,
        description="Error of a reading at that distance, positive if it is too long [m].",
    )
    detector: Literal["envelope", "carrier"] = Field(
        default="envelope",
        description="What crosses the threshold: the envelope, or the carrier, whose readings jump by whole periods.",
    )
    superposition: Literal["coherent", "incoherent"] = Field(
        default="coherent", description="Add the pressures of all paths (coherent), or their powers (incoherent)."
    )
    reflection_order: int = Field(default=2, ge=0, le=2, description="Largest number of reflections of a path.")
    diffraction: bool = Field(default=True, description="Whether edges and ends of walls scatter sound.")
    crosstalk: bool = Field(default=True, description="Whether sensors receive the bursts of each other.")
    second_time_around: bool = Field(default=True, description="Whether sensors receive the bursts of earlier firings.")
    thermometer: float = Field(
        default=math.inf,
        ge=0.0,
        description="Standard deviation of the thermometer in the recording; inf for none [degrees].",
    )
    jitter: float = Field(
        default=0.001,
        ge=0.0,
        le=_FARTHEST,
        description="Standard deviation of a range [m]; 1 mm is a timer of 4 us and a little noise.",
    )
    dropout: float = Field(default=0.0, ge=0.0, le=1.0, description="Probability that a ping gives no reading.")
    stray: float = Field(default=0.0, ge=0.0, le=1.0, description="Probability of a stray echo in a ping.")
    odometry: OdometryNoise = Field(default=OdometryNoise(), description="Errors of the poses in the recording.")
    servo_latency: float = Field(
        default=0.0, ge=0.0, le=60.0, description="Time by which the servo lags behind its commanded angle [s]."
    )
    servo_gain: float = Field(
        default=1.0,
        gt=0.0,
        le=_LARGEST_GAIN,
        description="Angle by which the servo turns for each recorded radian [rad].",
    )
    servo_offset: float = Field(
        default=0.0, ge=-math.pi, le=math.pi, description="Angle of the servo at which it records 0 [rad]."
    )
