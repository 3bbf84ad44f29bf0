"""One sensor that turns in front of one object: what it reads, and over which angle."""

import numpy as np

from echoplan.acoustics import Air
from echoplan.arrays import FloatArray
from echoplan.io import builtin_rig
from echoplan.model import Firing, Pillar, Polyline, Rig, Route, Sensor, Servo, Transducer, World
from echoplan.simulation import Simulation, SimulationSettings

__all__ = ["HC_SR04", "ROOM_AIR", "ROTARY_ARRAY", "STEP", "detection_width", "pillar_at", "scan", "wall_at"]

HC_SR04 = Transducer()
ROTARY_ARRAY = builtin_rig("rotary-array")
ROOM_AIR = Air()
# Of the servo [degrees].
STEP = 0.1


def scan(
    world: World,
    transducer: Transducer | None,
    *,
    yaw: float = 0.0,
    arm: float = 0.0,
    half_turn: float = 60.0,
    air: Air = ROOM_AIR,
) -> FloatArray:
    """Simulate one sensor that is turned this many degrees to either side; returns its ranges [m]."""
    sensor = Sensor(sensor_id=0, x=arm, half_aperture=0.5, min_range=0.02, max_range=6.0, resolution=0.0)
    rig = Rig(
        name="one sensor",
        sensors=(sensor,),
        servo=_servo(half_turn),
        firing=Firing(period=0.2, groups=((0,),)),
        transducer=transducer,
    )
    route, settings = Route(map_from_base=np.array([[0.0, 0.0, yaw]])), SimulationSettings(jitter=0.0, air=air)
    (sweep,) = Simulation(world=world, rig=rig, route=route, settings=settings)
    return sweep.ranges


def detection_width(
    world: World,
    *,
    transducer: Transducer | None = HC_SR04,
    yaw: float = 0.0,
    near: float | None = None,
    air: Air = ROOM_AIR,
) -> float:
    """Degrees over which something is detected, at about the range ``near`` if given."""
    readings = scan(world, transducer, yaw=yaw, air=air)
    read = np.isfinite(readings) if near is None else np.abs(readings - near) < 0.08
    return round(float(STEP * read.sum()), 1)


def wall_at(distance: float, *, half_length: float = 20.0) -> World:
    """World with one wall across the x axis."""
    ends = np.array([[distance, -half_length], [distance, half_length]])
    return World(name="wall", polylines=(Polyline(points_xy=ends),))


def pillar_at(distance: float, radius: float) -> World:
    """World with one cylinder on the x axis, its surface at the given distance."""
    return World(
        name="pillar", polylines=(), pillars=(Pillar(center_xy=np.array([distance + radius, 0.0]), radius=radius),)
    )


def _servo(half_turn: float) -> Servo:
    """Servo that turns this many degrees to either side."""
    start, step = np.radians([-half_turn, STEP]).tolist()
    return Servo(start=start, stop=-start, step=step)
