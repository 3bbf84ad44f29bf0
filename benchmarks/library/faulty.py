"""Faulty recordings: half of the simulated recordings have one mistake in their format."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from echoplan.model import Axes, Conventions, Heading, Rig, Route, Sensor, Sweep
from library.arenas import at_marks, simulate_arena
from library.rooms import Drive, random_drive, random_simulation

__all__ = ["FAULTS", "Faulty", "draw", "remedy_for"]

# Errors of a robot placed on marks by hand: along each axis [m], and of the heading [rad].
OFF, TURN = 0.015, math.radians(1.5)
# Every so many seeds have the same kind of recording, correct and faulty in turn.
_KINDS = 6

_HALF = math.pi / 2
# Conventions that are missing in rig.toml; ranges and places are in metres where units are right.
FAULTS: Mapping[str, Conventions] = {
    "servo clockwise": Conventions(servo_sign=-1),
    "servo 0 to 180": Conventions(servo_offset=-_HALF),
    "servo 180 to 0": Conventions(servo_sign=-1, servo_offset=_HALF),
    "headings clockwise": Conventions(heading=Heading.CLOCKWISE),
    "compass": Conventions(heading=Heading.COMPASS),
    "x and y swapped": Conventions(axes=Axes.YX),
    "y to the right": Conventions(axes=Axes.Y_DOWN),
    "ranges: inches for cm": Conventions(range_unit=2.54),
    "ranges: mm for cm": Conventions(range_unit=0.1),
    "places: cm for m": Conventions(position_unit=0.01),
    "places: m for cm": Conventions(position_unit=100.0),
    "places: feet for m": Conventions(position_unit=0.3048),
}
BACKWARDS = "sensor backwards"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Faulty:
    """A recording, and what is wrong with it."""

    name: str
    fault: str
    rig: Rig
    sweeps: tuple[Sweep, ...]
    backwards: int = -1


def draw(seed: int) -> Faulty:
    """Simulate a recording: correct for even seeds, else with one mistake."""
    number, is_faulty = divmod(seed, 2)
    kind, rng = number % _KINDS, np.random.default_rng(10_000 + number)
    name, rig, sweeps = _MAKERS[kind](number)
    if not is_faulty:
        return Faulty(name=name, fault="", rig=rig, sweeps=sweeps)
    has_servo = any(np.ptp(sweep.servo_angles) > 0.0 for sweep in sweeps)
    faults = [fault for fault in FAULTS if has_servo or not fault.startswith("servo")]
    if not any(sweep.map_from_base[:, 2].any() for sweep in sweeps):
        # Headings that are all zero are zero clockwise, too.
        faults.remove("headings clockwise")
    if len(rig.sensors) > 1:
        faults.append(BACKWARDS)
    fault = faults[int(rng.integers(len(faults)))]
    if fault == BACKWARDS:
        which = int(rng.integers(len(rig.sensors)))
        backwards, number = _turned_about(rig, which), rig.sensors[which].sensor_id
        return Faulty(name=name, fault=fault, rig=backwards, sweeps=sweeps, backwards=number)
    return Faulty(name=name, fault=fault, rig=rig, sweeps=tuple(map(FAULTS[fault].undo, sweeps)))


def remedy_for(faulty: Faulty) -> str:
    """Return a part of the right next step."""
    if faulty.fault == BACKWARDS:
        return f"of sensor {faulty.backwards} in rig.toml"
    return _REMEDIES[faulty.fault]


_REMEDIES = {
    "servo clockwise": "Set servo_sign = -1 under",
    "servo 0 to 180": "Set servo_offset = -1.5708 under",
    "servo 180 to 0": "Set servo_sign = -1 and servo_offset = 1.5708 under",
    "headings clockwise": 'Set heading = "clockwise" under',
    "compass": 'Set heading = "compass" under',
    "x and y swapped": 'Set axes = "yx" under',
    "y to the right": 'Set axes = "x-y" under',
    "ranges: inches for cm": "Set range_unit = 2.54 under",
    "ranges: mm for cm": "Set range_unit = 0.1 under",
    "places: cm for m": 'Set position_unit = "cm" under',
    "places: m for cm": "Set position_unit = 100 under",
    "places: feet for m": 'Set position_unit = "ft" under',
}


def _turned_about(rig: Rig, which: int) -> Rig:
    """Turn one sensor of the rig by 180 degrees."""
    sensors = list[Sensor](rig.sensors)
    sensors[which] = replace(sensors[which], yaw=sensors[which].yaw + math.pi)
    return replace(rig, sensors=tuple(sensors))


def _room(seed: int, array: str, stations: int) -> tuple[str, Rig, tuple[Sweep, ...]]:
    """Simulate a random room from marks on which a robot was placed by hand."""
    simulation, rng = random_simulation(seed, array=array, stations=stations), np.random.default_rng(seed)
    marks = simulation.route.map_from_base
    wrong = marks + rng.normal(0.0, (OFF, OFF, TURN), marks.shape)
    placed = replace(simulation, route=Route(map_from_base=wrong))
    sweeps = tuple(at_marks(sweep, marks) for sweep in placed)
    return f"{array}, {stations} marks", simulation.rig, sweeps


def _exact(seed: int, array: str, stations: int) -> tuple[str, Rig, tuple[Sweep, ...]]:
    simulation = random_simulation(seed, array=array, stations=stations)
    return f"{array}, {stations} exact stations", simulation.rig, tuple(simulation)


def _drive(seed: int, array: str, stations: int) -> tuple[str, Rig, tuple[Sweep, ...]]:
    simulation = random_drive(seed, Drive(array=array, stations=stations))
    return f"{array}, drive", simulation.rig, tuple(simulation)


def _arena(seed: int) -> tuple[str, Rig, tuple[Sweep, ...]]:
    """Simulate an arena of students."""
    _, specified, sweeps = simulate_arena(seed, off=0.02, turn=3.0, coarse=False, students=True)
    return "arena of students, 5 marks", specified, tuple(sweeps)


_MAKERS: tuple[Callable[[int], tuple[str, Rig, tuple[Sweep, ...]]], ...] = (
    lambda seed: _exact(seed, "rotary-array", 5 + seed % 10),
    lambda seed: _room(seed, "hc-sr04-servo", 6 + seed % 7),
    lambda seed: _room(seed, "ring-16", 14 + seed % 10),
    lambda seed: _drive(seed, "rotary-array", 16),
    _arena,
    lambda seed: _drive(seed, "hc-sr04-servo", 16),
)
