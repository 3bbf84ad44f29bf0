"""Small worlds and plain rigs for tests of the simulator."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.geometry import transform_points
from echoplan.model import Firing, Pillar, Polyline, Rig, Route, Sensor, Servo, Transducer, World
from echoplan.simulation import Simulation, SimulationSettings

# The transducer of the paper's modules: see docs/simulator.md.
PAPER = Transducer(piston_radius=0.0062, figure_of_merit=29.3)
HC_SR04 = Transducer()
STANDING = np.zeros((1, 3))


def world(*polylines: ArrayLike, pillars: Iterable[tuple[float, float, float]] = (), closed: bool = False) -> World:
    """Hard faces through points, and hard cylinders ``(x, y, radius)``."""
    return World(
        name="test world",
        polylines=tuple(Polyline(points_xy=np.array(points), closed=closed) for points in polylines),
        pillars=tuple(Pillar(center_xy=np.array([x, y]), radius=radius) for x, y, radius in pillars),
    )


def wall(distance: float, *, half_length: float = 20.0) -> World:
    """A wall across the x axis."""
    return world([[distance, -half_length], [distance, half_length]])


def pillar(distance: float, radius: float) -> World:
    """A cylinder whose surface is so far away on the x axis."""
    return world(pillars=[(distance + radius, 0.0, radius)])


def room() -> World:
    """A room without a right angle, with a box, a bent board and two pillars, of several materials."""
    outside = [[0.0, 0.0], [4.0, 0.3], [4.6, 1.9], [2.9, 3.3], [0.1, 2.7]]
    return World(
        name="test room",
        polylines=(
            Polyline(points_xy=np.array(outside), closed=True),
            Polyline(points_xy=np.array([[1.2, 1.7], [1.9, 1.8], [1.8, 2.3]]), closed=True, material="wood"),
            Polyline(points_xy=np.array([[3.0, 0.9], [3.4, 1.1], [3.5, 1.5]]), material="carpet"),
        ),
        pillars=(
            Pillar(center_xy=np.array([0.7, 0.6]), radius=0.1),
            Pillar(center_xy=np.array([2.6, 2.4]), radius=0.06, material="plaster"),
        ),
    )


def sensor(sensor_id: int = 0, **changed: Any) -> Sensor:
    """A sensor that reads without steps."""
    values = {"half_aperture": 0.61, "min_range": 0.03, "max_range": 6.0, "resolution": 0.0} | changed
    return Sensor(sensor_id=sensor_id, **values)


def rig(
    *sensors: Sensor,
    transducer: Transducer | None = HC_SR04,
    servo: Servo | None = None,
    period: float = 0.2,
    groups: tuple[tuple[int, ...], ...] = (),
) -> Rig:
    """Sensors that fire together, seldom enough for all echoes to die, by default."""
    sensors = sensors or (sensor(),)
    together = (tuple(each.sensor_id for each in sensors),)
    firing = Firing(period=period, groups=groups or together)
    return Rig(name="test rig", sensors=sensors, servo=servo, firing=firing, transducer=transducer)


def turning(start: float, stop: float, step: float) -> Servo:
    """A servo by degrees."""
    return Servo(start=float(np.radians(start)), stop=float(np.radians(stop)), step=float(np.radians(step)))


def array(*, arm: float = 0.05, sensors: int = 4, **changed: Any) -> Rig:
    """The rotary array: sensors on arms, evenly around a servo, fired together every 25 ms."""
    yaws = 2 * np.pi * np.arange(sensors) / sensors
    values = {"max_range": 3.0} | changed
    each = [
        sensor(number, x=float(arm * np.cos(yaw)), y=float(arm * np.sin(yaw)), yaw=float(yaw), **values)
        for number, yaw in enumerate(yaws)
    ]
    return rig(*each, transducer=PAPER, servo=turning(-45, 45, 1), period=0.025)


def simulation(
    place: World, *, using: Rig | None = None, poses: ArrayLike = STANDING, seed: int = 0, **changed: Any
) -> Simulation:
    """A simulation without jitter by default, at stations."""
    return Simulation(
        world=place,
        rig=using or rig(),
        route=Route(map_from_base=np.array(poses, dtype=np.float64)),
        settings=SimulationSettings(**({"jitter": 0.0} | changed)),
        seed=seed,
    )


def readings(source: Simulation) -> FloatArray:
    """All readings, one after the other."""
    return np.concatenate([sweep.ranges for sweep in source])


def moved(place: World, pose: ArrayLike) -> World:
    """A world seen from elsewhere: every point taken by a pose."""
    return World(
        name=place.name,
        polylines=tuple(
            Polyline(points_xy=transform_points(pose, line.points_xy), closed=line.closed, material=line.material)
            for line in place.polylines
        ),
        pillars=tuple(
            Pillar(center_xy=transform_points(pose, each.center_xy), radius=each.radius, material=each.material)
            for each in place.pillars
        ),
    )
