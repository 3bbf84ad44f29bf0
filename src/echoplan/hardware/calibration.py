"""Calibration of a rig: what its sensors saw of a hand, of a flat wall and of a corner, and the rig that follows."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from echoplan.acoustics import (
    Air,
    half_angle,
    ka_for,
    piston_ka,
    speed_of_sound,
    typical_transducer,
    wavenumber,
)
from echoplan.geometry import wrap
from echoplan.hardware.walls import Arc, ArcFit, Estimate, fit_arcs, wall_excess
from echoplan.model import Conventions, Rig, Sensor, Transducer

__all__ = ["Calibration", "Observations", "SensorView", "Value", "assigned", "calibrate", "front_of"]

# A person aims a robot at a wall, reads a tape, and corners of rooms are square, to about this [rad, m, rad].
_AIM, _TAPE, _SQUARE = math.radians(1.0), 0.002, math.radians(0.5)
# How far the beam may be from what the rig states, as a share.
_BEAM_SPREAD = 0.3
# By how much a sensor may be more sensitive than its data sheet lets expect [dB].
_SENSITIVITY = 5.0
# Echoes of two walls whose distances differ by less than this [m] overlap; where one ends and the other begins, they
# widen both arcs by this together [rad].
_BURST, _OVERLAP = 0.08, math.radians(2.0)
# The gain of the servo enters the model of the beam: after so many rounds it changes by less than 1e-4.
_ROUNDS = 3


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Observations:
    """What the steps of a calibration found; what was skipped is missing.

    Parameters
    ----------
    rig : Rig
        What was assumed before, with its sensors in their places.
    conventions : Conventions
        How its servo angles were assumed to be counted.
    air : Estimate
        Temperature of the air [degrees Celsius].
    servo_sign : int, optional
        -1 if recorded servo angles grow clockwise.
    distance : float, optional
        Distance of the wall from the axis of the servo, by tape [m].
    walls : mapping of int to Arc, optional
        The flat wall, by the number of the sensor that faced it.
    corner : tuple of Arc, optional
        The two walls of a right-angled corner, as the front sensor sees them after it faced the flat wall.
    """

    rig: Rig
    conventions: Conventions
    air: Estimate
    servo_sign: int | None = None
    distance: float = math.nan
    walls: Mapping[int, Arc] = field(default_factory=lambda: MappingProxyType({}))
    corner: tuple[Arc, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Value:
    """A calibrated value.

    Parameters
    ----------
    name : str
        What it is, with the number of its sensor if it has one.
    estimate : Estimate
        Value and standard deviation.
    unit : str
        ``m``, ``rad``, ``degC`` or nothing.
    """

    name: str
    estimate: Estimate
    unit: str

    @property
    def text(self) -> str:
        """The value as people read it: millimetres, degrees."""
        factor, digits, unit = {
            "m": (1000.0, 1, " mm"),
            "rad": (math.degrees(1.0), 2, " deg"),
            "degC": (1.0, 1, " deg C"),
            "": (1.0, 4, ""),
        }[self.unit]
        value, sigma = factor * self.estimate.value, factor * self.estimate.sigma
        return f"{value:z.{digits}f} ± {sigma:.{digits}f}{unit}"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SensorView:
    """What a sensor saw of walls, and the model that was fitted to it.

    Parameters
    ----------
    name : str
        What was seen.
    sensor : Sensor
        The sensor as it was assumed to be.
    arcs : tuple of Arc
        The pings.
    fit : ArcFit
        The model.
    """

    name: str
    sensor: Sensor
    arcs: tuple[Arc, ...]
    fit: ArcFit


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Calibration:
    """A calibrated rig.

    Parameters
    ----------
    rig : Rig
        The rig.
    conventions : Conventions
        How its servo angles are counted.
    values : tuple of Value
        What was measured, with standard deviations.
    views : tuple of SensorView
        What it was measured from.
    signed_gain : float
        How far the servo turns for each recorded radian, negative if clockwise.
    transducer : Transducer
        Of the model.
    air : Air
        In which it was measured.
    """

    rig: Rig
    conventions: Conventions
    values: tuple[Value, ...]
    views: tuple[SensorView, ...]
    signed_gain: float
    transducer: Transducer
    air: Air


def front_of(rig: Rig) -> Sensor:
    """Return the sensor that points ahead when the servo is at angle 0."""
    ahead = float(rig.base_from_turret[2])
    return min(rig.sensors, key=lambda sensor: abs(float(wrap(sensor.yaw + ahead))))


def calibrate(seen: Observations) -> Calibration:
    """Estimate the values of a rig from the observations, by least squares.

    The center of the arc of a wall gives the offset of the servo, its edges the beam, its depth the offset of the
    readings; the angle between the walls of a right-angled corner gives the gain of the servo.
    """
    front, air = front_of(seen.rig), Air(temperature=seen.air.value)
    transducer = seen.rig.transducer or typical_transducer(front)
    sign = seen.servo_sign or seen.conventions.servo_sign
    views, gain = _views(seen, sign=sign, transducer=transducer, air=air)
    own = {view.sensor.sensor_id: view for view in views if len(view.arcs) == 1}
    values, conventions = _servo(seen, own.get(front.sensor_id), sign=sign, gain=gain)
    sensors = {
        sensor_id: _sensor(seen, view, transducer=transducer, air=air, gain=gain) for sensor_id, view in own.items()
    }
    for sensor_id, (_, offset, aperture) in sensors.items():
        values.append(Value(name=f"range offset of sensor {sensor_id}", estimate=offset, unit="m"))
        values.append(Value(name=f"half aperture of sensor {sensor_id}", estimate=aperture, unit="rad"))
    return Calibration(
        rig=_rig(seen.rig, sensors, ka=[view.fit.ka.value for view in own.values()], air=air),
        conventions=conventions,
        values=(*values, Value(name="temperature", estimate=seen.air, unit="degC")),
        views=views,
        signed_gain=sign * gain.value,
        transducer=transducer,
        air=air,
    )


def _views(
    seen: Observations, *, sign: int, transducer: Transducer, air: Air
) -> tuple[tuple[SensorView, ...], Estimate]:
    """Fit the model to the walls and to the corner, and find the gain of the servo with which they agree."""
    front, guess = front_of(seen.rig), piston_ka(transducer, air)
    beam = Estimate(value=guess, sigma=_BEAM_SPREAD * guess)
    gain = Estimate(value=seen.conventions.servo_gain, sigma=0.0)

    def view(name: str, *, sensor: Sensor, arcs: tuple[Arc, ...], ka: Estimate) -> SensorView:
        """Fit the arcs of one sensor with the gain of the servo found so far."""
        fit = fit_arcs(arcs, gain=sign * gain.value, ka=ka, sensor=sensor, transducer=transducer, air=air)
        return SensorView(name=name, sensor=sensor, arcs=arcs, fit=fit)

    corner = []
    for _ in range(_ROUNDS if seen.corner else 0):
        wall = view("wall", sensor=front, arcs=(seen.walls[front.sensor_id],), ka=beam)
        corner = [view("corner", sensor=front, arcs=seen.corner, ka=wall.fit.ka)]
        gain = _gain(corner[0])
    faced = [sensor for sensor in seen.rig.sensors if sensor.sensor_id in seen.walls]
    walls = [
        view(f"wall, sensor {each.sensor_id}", sensor=each, arcs=(seen.walls[each.sensor_id],), ka=beam)
        for each in faced
    ]
    return (*walls, *corner), gain


def _gain(corner: SensorView) -> Estimate:
    """Return the gain of a servo from the angle that it records between two walls at a right angle."""
    separation, (one, other) = corner.fit.separation, corner.fit.depths
    is_cut = any(math.isnan(arc.lower) or math.isnan(arc.upper) for arc in corner.arcs)
    overlap = _OVERLAP if is_cut and abs(one.value - other.value) < _BURST else 0.0
    gain = math.pi / 2 / abs(separation.value)
    relative = math.hypot(math.hypot(separation.sigma, overlap) / separation.value, _SQUARE / (math.pi / 2))
    return Estimate(value=gain, sigma=gain * relative)


def _servo(
    seen: Observations, wall: SensorView | None, *, sign: int, gain: Estimate
) -> tuple[list[Value], Conventions]:
    """Return what was measured of the servo, and how its angles are counted."""
    values, conventions = [], replace(seen.conventions, servo_sign=sign)
    if seen.corner:
        values.append(Value(name="servo gain", estimate=gain, unit=""))
        conventions = replace(conventions, servo_gain=round(gain.value, 4))
    if wall is not None:
        center = wall.fit.centers[0]
        ahead = wall.sensor.yaw + float(seen.rig.base_from_turret[2])
        offset = float(wrap(-ahead - sign * gain.value * center.value))
        sigma = math.hypot(gain.value * center.sigma, gain.sigma * center.value, _AIM)
        values.append(Value(name="servo offset", estimate=Estimate(value=offset, sigma=sigma), unit="rad"))
        conventions = replace(conventions, servo_offset=round(offset, 5))
    return values, conventions


def _sensor(
    seen: Observations, view: SensorView, *, transducer: Transducer, air: Air, gain: Estimate
) -> tuple[Sensor, Estimate, Estimate]:
    """Return a calibrated sensor, the offset of its readings [m] and half of its opening angle [rad]."""
    sensor, fit = view.sensor, view.fit
    warming = float(speed_of_sound(seen.air.value + 1.0) / speed_of_sound(seen.air.value)) - 1.0
    depth = fit.depths[0]
    offset = Estimate(
        value=depth.value - seen.distance,
        sigma=math.hypot(depth.sigma, _TAPE, warming * seen.air.sigma * seen.distance),
    )
    angle, wider = (
        _half_aperture(ka, sensor=sensor, transducer=transducer, air=air)
        for ka in (fit.ka.value, fit.ka.value - fit.ka.sigma)
    )
    # The same edges of the arc, if the sensor is more sensitive than assumed.
    louder = replace(transducer, figure_of_merit=transducer.figure_of_merit + _SENSITIVITY)
    excesses = [wall_excess(seen.distance, transducer=each, air=air) for each in (transducer, louder)]
    edge = half_angle(excesses[0], fit.ka.value)
    other = _half_aperture(float(ka_for(edge, excesses[1])), sensor=sensor, transducer=louder, air=air)
    # The width is as wide as the servo turned.
    sigmas = (wider - angle, other - angle, angle * gain.sigma / gain.value)
    aperture = Estimate(value=angle, sigma=math.hypot(*sigmas))
    return _moved(sensor, offset=offset.value, half_aperture=angle), offset, aperture


def _half_aperture(ka: float, *, sensor: Sensor, transducer: Transducer, air: Air) -> float:
    """Return the angle within which a plane is detected at half the reach [rad]: so data sheets state it."""
    usual, half = Air(), sensor.max_range / 2
    excess = wall_excess(half, transducer=transducer, air=usual)
    return float(half_angle(excess, ka * air.speed_of_sound / usual.speed_of_sound))


def _moved(sensor: Sensor, *, offset: float, half_aperture: float) -> Sensor:
    """Put the acoustic centre of a sensor where its readings begin: readings that are too long begin behind it."""
    return replace(
        sensor,
        x=round(sensor.x - offset * math.cos(sensor.yaw), 5),
        y=round(sensor.y - offset * math.sin(sensor.yaw), 5),
        half_aperture=round(half_aperture, 5),
    )


def _rig(rig: Rig, measured: Mapping[int, tuple[Sensor, Estimate, Estimate]], *, ka: Sequence[float], air: Air) -> Rig:
    """Return the rig with its calibrated sensors; those that faced no wall are taken to be like the front sensor."""
    front = front_of(rig)
    if front.sensor_id not in measured:
        return rig
    _, offset, aperture = measured[front.sensor_id]
    others = [_moved(sensor, offset=offset.value, half_aperture=aperture.value) for sensor in rig.sensors]
    sensors = tuple(measured[each.sensor_id][0] if each.sensor_id in measured else each for each in others)
    transducer = rig.transducer
    if transducer is not None:
        radius = float(np.mean(ka) / wavenumber(transducer.frequency, air.speed_of_sound))
        transducer = replace(transducer, piston_radius=round(radius, 6))
    return replace(rig, sensors=sensors, transducer=transducer)


def assigned(rig: Rig, sensor_ids: Sequence[int]) -> Rig:
    """Give the sensors of a rig, in their order, other numbers."""
    pairs = zip(rig.sensors, sensor_ids, strict=True)
    return replace(rig, sensors=tuple(replace(sensor, sensor_id=number) for sensor, number in pairs))
