"""A sound recording of a small room, to be spoiled as people spoil theirs."""

from functools import cache

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Polyline, Rig, Route, Sensor, Servo, Sweep, World
from echoplan.simulation import Simulation, SimulationSettings

# An L without symmetry, so that no mistake makes another room of it.
_ROOM = np.array([[0.0, 0.0], [3.4, 0.0], [3.4, 1.5], [2.0, 1.5], [2.0, 2.6], [0.0, 2.6]])
_STATIONS = np.array(
    [[0.6, 0.6, 0.4], [1.4, 0.9, 1.2], [2.6, 0.7, 2.9], [1.3, 1.9, -2.2], [0.6, 1.7, -0.7], [2.9, 0.9, 1.9]]
)
RIG = Rig(
    name="two sonars on a servo",
    sensors=tuple(
        Sensor(sensor_id=number, x=0.03, yaw=yaw, half_aperture=0.5, min_range=0.02, max_range=4.0, resolution=0.003)
        for number, yaw in enumerate((0.0, np.pi / 2))
    ),
    servo=Servo(start=-np.pi / 2, stop=np.pi / 2, step=np.radians(2.0)),
)


@cache
def sound_sweeps() -> tuple[Sweep, ...]:
    """Six sweeps with all that they should say."""
    return _simulated(_STATIONS)


@cache
def misaligned_sweeps(gain: float, degrees: float) -> tuple[Sweep, ...]:
    """The same of a servo that does not quite turn as recorded."""
    return _simulated(_STATIONS, SimulationSettings(servo_gain=gain, servo_offset=np.radians(degrees)))


@cache
def many_sweeps() -> tuple[Sweep, ...]:
    """Thirty-eight coarse ones, more than joint explains together."""
    stations = np.random.default_rng(1).uniform([0.4, 0.4, -np.pi], [1.7, 2.2, np.pi], (38, 3))
    sweeps = _simulated(stations)
    return tuple(sweep[np.unique(sweep.stamps_ns, return_inverse=True)[1] % 5 == 0] for sweep in sweeps)


def _simulated(stations: FloatArray, settings: SimulationSettings | None = None) -> tuple[Sweep, ...]:
    settings = settings or SimulationSettings()
    world = World(name="L", polylines=(Polyline(points_xy=_ROOM, closed=True),))
    return tuple(Simulation(world=world, rig=RIG, route=Route(map_from_base=stations), settings=settings, seed=1))


@cache
def sound_map() -> FeatureMap:
    """The map that joint makes of them."""
    return map_sweeps(JointMapper(RIG), sound_sweeps())
