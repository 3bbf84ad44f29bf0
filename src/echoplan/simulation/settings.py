"""Settings of the simulator."""

import math
from typing import Literal

from pydantic import BaseModel, Field

from echoplan.acoustics import Air

__all__ = ["OdometryNoise", "SimulationSettings"]

# Ultrasound in air is not detected from farther than this [m]; dead reckoning that drifts by more is useless [m, rad].
_FARTHEST, _LARGEST_DRIFT = 50.0, 100.0
# No servo turns ten times as far as commanded.
_LARGEST_GAIN = 10.0


class OdometryNoise(BaseModel, frozen=True, extra="forbid"):
    """Errors of dead reckoning: a random walk whose standard deviation grows with the square root of the distance."""

    along: float = Field(default=0.0, ge=0.0, le=_LARGEST_DRIFT, description="deviation along the way after 1 m [m]")
    lateral: float = Field(default=0.0, ge=0.0, le=_LARGEST_DRIFT, description="deviation across the way after 1 m [m]")
    yaw_per_metre: float = Field(
        default=0.0, ge=0.0, le=_LARGEST_DRIFT, description="deviation of the heading after 1 m [rad]"
    )
    yaw_per_radian: float = Field(
        default=0.0, ge=0.0, le=_LARGEST_DRIFT, description="deviation of the heading after a turn of 1 rad [rad]"
    )


class SimulationSettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of the simulator; the defaults are a hard room, a sound module and a robot that knows where it is."""

    air: Air = Field(default=Air(), description="the air in the room")
    assumed_temperature: float = Field(
        default=20.0,
        ge=-30.0,
        le=60.0,
        description="temperature with which the module turns time into range, at 50 % humidity, unless the rig states "
        "its speed of sound [degrees Celsius]",
    )
    zero_distance: float = Field(
        default=1.0, gt=0.0, le=_FARTHEST, description="where its maker set the module right, before an aimed plane [m]"
    )
    zero_error: float = Field(
        default=0.0, ge=-_FARTHEST, le=_FARTHEST, description="by how much it reads too far there all the same [m]"
    )
    detector: Literal["envelope", "carrier"] = Field(
        default="envelope", description="what trips the threshold; the carrier does in jumps of whole periods"
    )
    superposition: Literal["coherent", "incoherent"] = Field(
        default="coherent", description="add the pressures of all paths, or their powers"
    )
    reflection_order: int = Field(default=2, ge=0, le=2, description="how often sound may be reflected")
    diffraction: bool = Field(default=True, description="let edges and ends of walls scatter sound")
    crosstalk: bool = Field(default=True, description="Let sensors detect each other's bursts.")
    second_time_around: bool = Field(default=True, description="Let sensors detect the bursts of other firings.")
    thermometer: float = Field(
        default=math.inf, ge=0.0, description="deviation of the thermometer in the recording; inf: none [degrees]"
    )
    jitter: float = Field(
        default=0.001,
        ge=0.0,
        le=_FARTHEST,
        description="standard deviation of a range [m]; 1 mm is a timer of 4 us and a little noise",
    )
    dropout: float = Field(default=0.0, ge=0.0, le=1.0, description="probability that a ping gives no reading")
    stray: float = Field(default=0.0, ge=0.0, le=1.0, description="probability of a stray echo in a ping")
    odometry: OdometryNoise = Field(default=OdometryNoise(), description="errors of the poses in the recording")
    servo_latency: float = Field(
        default=0.0, ge=0.0, le=60.0, description="Delay of the servo behind the commanded angle [s]."
    )
    servo_gain: float = Field(
        default=1.0,
        gt=0.0,
        le=_LARGEST_GAIN,
        description="how far the servo turns for each radian that is recorded [rad]",
    )
    servo_offset: float = Field(
        default=0.0, ge=-math.pi, le=math.pi, description="where the servo stands when it records 0 [rad]"
    )
