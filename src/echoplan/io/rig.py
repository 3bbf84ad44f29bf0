"""Rigs in TOML: ``rig.toml``."""

from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from echoplan.io.files import by_name, write_text
from echoplan.io.structure import Form, Whole, read_toml
from echoplan.io.text import format_toml
from echoplan.io.units import (
    Cycles,
    Decibels,
    Deviation,
    HalfAperture,
    Hertz,
    Lever,
    Metres,
    Period,
    Radians,
    Step,
)
from echoplan.model import UNITS, Axes, Conventions, Firing, Heading, Odometry, Rig, Sensor, Servo, Transducer

__all__ = ["format_rig", "read_conventions", "read_rig", "write_rig"]

_SERVO_CONVENTIONS = ("servo_sign", "servo_offset", "servo_gain")


class _SensorForm(Form, extra="forbid"):
    id: Whole = Field(description="Number of the sensor in the recording.")
    x: Lever = Field(default=0.0, description="Place of the acoustic centre in the turret's frame [m].")
    y: Lever = Field(default=0.0, description="Place of the acoustic centre in the turret's frame [m].")
    yaw: Radians = Field(default=0.0, description="Direction of the beam axis in the turret's frame [rad].")
    half_aperture: HalfAperture = Field(description="Half of the opening angle of the beam [rad].")
    min_range: Metres = Field(description="Smallest range that the sensor reads [m].")
    max_range: Metres = Field(description="Largest range that the sensor reads [m].")
    resolution: Metres = Field(description="Step of the readings [m].")

    def value(self) -> Sensor:
        """Make the sensor."""
        return Sensor(sensor_id=self.id, **self.model_dump(exclude={"id"}))


class _TurretForm(Form, extra="forbid"):
    x: Lever = Field(default=0.0, description="Place of the servo's axis in base_link [m].")
    y: Lever = Field(default=0.0, description="Place of the servo's axis in base_link [m].")
    yaw: Radians = Field(default=0.0, description="Direction of servo angle 0 in base_link [rad].")


class _ServoForm(Form, extra="forbid"):
    start: Radians = Field(description="First angle of a sweep [rad].")
    stop: Radians = Field(description="Last angle of a sweep [rad].")
    step: Step = Field(description="Turn between two firing rounds [rad].")

    def value(self) -> Servo:
        """Make the servo."""
        return Servo(**self.model_dump())


class _FiringForm(Form, extra="forbid"):
    period: Period = Field(description="Time from one group's firing to the next [s].")
    groups: list[list[Whole]] = Field(description="Lists of the sensor ids that fire together.")

    def value(self) -> Firing:
        """Make the order of firing."""
        return Firing(period=self.period, groups=tuple(map(tuple, self.groups)))


class _TransducerForm(Form, extra="forbid"):
    frequency: Hertz | None = Field(default=None, description="Frequency of the carrier [Hz].")
    piston_radius: Metres | None = Field(
        default=None, description="Radius of the piston that transmits and receives [m]."
    )
    figure_of_merit: Decibels | None = Field(
        default=None, description="Level over the detection threshold of the echo of a plane over a path of 1 m [dB]."
    )
    quality_factor: Cycles | None = Field(
        default=None, description="Quality factor Q of the sending and receiving resonators."
    )
    burst_cycles: Cycles | None = Field(default=None, description="Number of carrier cycles in the burst.")

    def value(self) -> Transducer:
        """Make the transducer."""
        return Transducer(**self.model_dump(exclude_none=True))


class _OdometryForm(Form, extra="forbid"):
    along: Deviation | None = Field(
        default=None, description="Standard deviation of odometry along the path after 1 m [m]."
    )
    lateral: Deviation | None = Field(
        default=None, description="Standard deviation of odometry across the path after 1 m [m]."
    )
    yaw_per_metre: Radians | None = Field(
        default=None, description="Standard deviation of the heading after 1 m [rad]."
    )
    yaw_per_radian: Radians | None = Field(
        default=None, description="Standard deviation of the heading after a turn of 1 rad [rad]."
    )

    def value(self) -> Odometry:
        """Make what is known of dead reckoning."""
        return Odometry(**self.model_dump())


_Unit = Annotated[
    Literal["m", "cm", "mm", "in", "ft"] | Annotated[float, Field(gt=0.0)], Field(union_mode="left_to_right")
]


class _ConventionsForm(Form, extra="forbid"):
    servo_sign: Literal[1, -1] = Field(
        default=1, description="Sign of recorded servo angles: 1, or -1 if they grow clockwise."
    )
    servo_offset: Radians = Field(default=0.0, description="Angle of the servo at which it records 0 [rad].")
    servo_gain: float = Field(default=1.0, description="Angle by which the servo turns for each recorded radian [rad].")
    range_unit: _Unit = Field(default="m", description='Unit of ranges: "m", "cm", "mm", "in", "ft" or metres in it.')
    position_unit: _Unit = Field(default="m", description="Unit of x and y, written as that of ranges.")
    heading: Literal["counter-clockwise", "clockwise", "compass"] = Field(
        default="counter-clockwise",
        description='How headings grow: "counter-clockwise" or "clockwise" from +x, "compass" (clockwise from +y).',
    )
    axes: Literal["xy", "yx", "x-y"] = Field(
        default="xy",
        description='How x and y lie: "xy"; "yx" if swapped; "x-y" if y points right, or down on a screen.',
    )

    def value(self) -> Conventions:
        """Make the conventions."""
        return Conventions(
            servo_sign=self.servo_sign,
            servo_offset=self.servo_offset,
            servo_gain=self.servo_gain,
            range_unit=_metres(self.range_unit),
            position_unit=_metres(self.position_unit),
            heading=Heading(self.heading),
            axes=Axes(self.axes),
        )


def _metres(unit: str | float) -> float:
    return UNITS[unit] if isinstance(unit, str) else unit


class _RigForm(Form, extra="forbid"):
    name: str = Field(default="rig", description="Name of the rig.")
    turret: _TurretForm = Field(default=_TurretForm(), description="Pose of the servo's axis in base_link.")
    sensor: list[_SensorForm] = Field(description="List of tables [[sensor]], one for each.")
    servo: _ServoForm | None = Field(default=None, description="Turn of the turret in one sweep.")
    firing: _FiringForm | None = Field(default=None, description="Order in which the sensors fire.")
    transducer: _TransducerForm | None = Field(
        default=None, description="Properties of the transducer for the simulator."
    )
    odometry: _OdometryForm | None = Field(default=None, description="Standard deviations of odometry.")
    conventions: _ConventionsForm = Field(
        default=_ConventionsForm(), description="Conventions of the recording in the same folder."
    )
    speed_of_sound: float | None = Field(default=None, description="Speed of sound that the modules assume [m/s].")
    rays: bool | None = Field(default=None, description="Whether a reading is the nearest point in a cone of rays.")

    def value(self) -> Rig:
        """Make the rig."""
        return Rig(
            name=self.name,
            sensors=tuple(sensor.value() for sensor in self.sensor),
            base_from_turret=np.array([self.turret.x, self.turret.y, self.turret.yaw]),
            servo=self.servo.value() if self.servo else None,
            firing=self.firing.value() if self.firing else None,
            transducer=self.transducer.value() if self.transducer else None,
            odometry=self.odometry.value() if self.odometry else None,
            speed_of_sound=self.speed_of_sound,
            rays=self.rays,
        )


@by_name
def read_rig(path: Path) -> Rig:
    """Read a rig.

    Parameters
    ----------
    path : Path or str
        The file, usually ``rig.toml``.

    Returns
    -------
    Rig
        The rig.

    Raises
    ------
    InputError
        If the file cannot be read or describes no possible rig.
    """
    return read_toml(path, _RigForm).value()


@by_name
def read_conventions(path: Path) -> Conventions:
    """Read how the recording beside a rig is written.

    Parameters
    ----------
    path : Path or str
        The file of the rig, usually ``rig.toml``.

    Returns
    -------
    Conventions
        SI and REP 103 where the file has no table ``[conventions]``.

    Raises
    ------
    InputError
        If the file cannot be read or describes no possible rig.
    """
    return read_toml(path, _RigForm).conventions.value()


@by_name
def write_rig(path: Path, rig: Rig) -> None:
    """Write a rig, leaving out what is not known of it.

    Parameters
    ----------
    path : Path or str
        The file.
    rig : Rig
        The rig.

    Raises
    ------
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> from echoplan.io import builtin_rig
    >>> path = getfixture("tmp_path") / "rig.toml"
    >>> write_rig(path, builtin_rig("ring-16"))
    >>> len(read_rig(path).sensors)
    16
    """
    write_text(path, format_rig(rig))


def format_rig(rig: Rig, *, conventions: Conventions | None = None) -> str:
    """Put a rig into words: the text of its file.

    Parameters
    ----------
    rig : Rig
        The rig.
    conventions : Conventions, optional
        How the servo angles of its recordings are counted; units, headings and axes are left out.

    Returns
    -------
    str
        TOML.
    """
    x, y, yaw = rig.base_from_turret.tolist()
    return format_toml(
        {
            "name": rig.name,
            "speed_of_sound": rig.speed_of_sound,
            "rays": rig.rays,
            "turret": {"x": x, "y": y, "yaw": yaw},
            "servo": rig.servo and asdict(rig.servo),
            "firing": rig.firing and asdict(rig.firing),
            "transducer": rig.transducer and asdict(rig.transducer),
            "odometry": rig.odometry and asdict(rig.odometry),
            "conventions": conventions and {name: getattr(conventions, name) for name in _SERVO_CONVENTIONS},
            "sensor": [_sensor(sensor) for sensor in rig.sensors],
        }
    )


def _sensor(sensor: Sensor) -> dict[str, float]:
    numbers: dict[str, float] = asdict(sensor)
    return {"id": numbers.pop("sensor_id"), **numbers}
