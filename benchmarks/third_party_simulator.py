"""The method joint on another simulator: python benchmarks/third_party_simulator.py [ROOMS] [--burst smooth].

Simulates random rooms (12 by default: rectangles, L's and oblique ones in turn) from 14 stations by the image sources
of pyroomacoustics, maps the readings and prints scores.  Floor and ceiling absorb sound in some rooms and reflect as
walls do in others.  A module takes the Hilbert envelope of a burst and waits until it rises over a threshold, is
calibrated on a plane at 1 m, and reads in steps of 5 mm with 1 mm of jitter; its burst rises as a resonator does, or,
with ``--burst smooth``, as a Hann window.  It shares no code with our simulator.
"""

import argparse
import time
import warnings
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from scipy.signal import fftconvolve, hilbert
from scipy.special import j1

from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import Evaluation, evaluate
from echoplan.geometry import distances_to_segments
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import Pings, Polyline, Rig, Route, Servo, Sweep, Table, World
from echoplan.simulation import Simulation
from echoplan.sources import find_rig
from library.score_tables import SCORE_COLUMNS, score_row

ROOMS, STATIONS = 12, 14
SHAPES = {
    "rectangle": [[0, 0], [1, 0], [1, 1], [0, 1]],
    "L": [[0, 0], [1, 0], [1, 0.55], [0.55, 0.55], [0.55, 1], [0, 1]],
    "oblique": [[0, 0], [1, 0.1], [1.1, 0.6], [0.7, 1], [-0.1, 0.9]],
}
# Samples a second, speed of sound [m/s], frequency [Hz], radius of the piston [m], absorption [dB/m].
RATE, SPEED, FREQUENCY, RADIUS, ABSORPTION = 400_000, 343.0, 40_000.0, 0.0075, 1.3
# Of the room and of the array in it [m]; transmitter and receiver lie so far apart [m].
HEIGHT, PLANE, APART = 2.5, 1.2, 0.004
# Cycles of a burst, its rise [s], and from where on a module listens [s].
CYCLES, RISE, DEAF = 8, 6e-5, 5e-4
STEP, JITTER = 0.005, 0.001


def main() -> None:
    """Simulate rooms, map them and print a table."""
    parser = argparse.ArgumentParser(description="The method joint in rooms of another simulator.")
    parser.add_argument("rooms", type=int, nargs="?", default=ROOMS)
    parser.add_argument("--burst", choices=["resonator", "smooth"], default="resonator")
    arguments = parser.parse_args()
    with ProcessPoolExecutor() as workers:
        runs = workers.map(partial(run, smooth=arguments.burst == "smooth"), range(arguments.rooms))
        outcomes = list(tracked(runs, total=arguments.rooms, task="simulating"))
    rows = []
    for number, shape in enumerate(SHAPES):
        own = outcomes[number :: len(SHAPES)]
        rows.append(score_row(shape, [one for one, _ in own], sum(seconds for _, seconds in own)))
    rows.append(score_row("all", [one for one, _ in outcomes], sum(seconds for _, seconds in outcomes)))
    show(
        Table(
            title="joint, simulated by pyroomacoustics: recall / precision (%), mean deviation",
            columns=SCORE_COLUMNS,
            rows=(*rows,),
        )
    )


def run(seed: int, *, smooth: bool) -> tuple[Evaluation, float]:
    """Simulate one room, map it and compare the map with the truth; measure the CPU time."""
    rng = np.random.default_rng(seed)
    outline = np.array(list(SHAPES.values())[seed % len(SHAPES)]) * rng.uniform((3.0, 2.5), (5.0, 4.0))
    world = World(name="referee", polylines=(Polyline(points_xy=outline, closed=True),))
    servo = Servo(start=-np.pi / 4, stop=np.pi / 4, step=np.radians(3.0))
    rig = replace(find_rig("rotary-array"), servo=servo)
    simulation = Simulation(world=world, rig=rig, route=Route(map_from_base=stations(world, rng)))
    module = Module(outline, rng, smooth=smooth)
    sweeps = [replace(sweep, ranges=module.ranges(sweep, rig)) for sweep in simulation]
    begun = time.process_time()
    found = map_sweeps(JointMapper(rig), sweeps)
    return evaluate(found, simulation.truth), time.process_time() - begun


def stations(world: World, rng: np.random.Generator) -> FloatArray:
    """Choose places inside that are 35 cm from all walls, with any heading."""
    walls, found = world.segments_xy, list[FloatArray]()
    while len(found) < STATIONS:
        place = rng.uniform(walls.min(axis=(0, 1)), walls.max(axis=(0, 1)))
        if _is_inside(walls, place) and distances_to_segments(place[None], walls).min() > 0.35:
            found.append(np.array([*place, rng.uniform(-np.pi, np.pi)]))
    return np.array(found)


def _is_inside(walls: FloatArray, place: FloatArray) -> bool:
    starts, ends = walls[:, 0] - place, walls[:, 1] - place
    crosses = (starts[:, 1] > 0) != (ends[:, 1] > 0)
    turned = starts[:, 0] * ends[:, 1] - starts[:, 1] * ends[:, 0]
    return bool(np.sum(crosses & ((turned > 0) == (ends[:, 1] > starts[:, 1]))) % 2)


class Module:
    """A module of the third-party simulator: image sources, a piston each way, a burst, a threshold."""

    def __init__(self, outline_xy: FloatArray, rng: np.random.Generator, *, smooth: bool) -> None:
        clock = np.arange(int(CYCLES / FREQUENCY * RATE)) / RATE
        rise = np.hanning(len(clock)) if smooth else 1.0 - np.exp(-clock / RISE)
        self.burst = np.sin(2 * np.pi * FREQUENCY * clock) * rise
        self.threshold = rng.uniform(0.005, 0.03)
        self.hard_floor = bool(rng.random() < 0.5)
        self.outline, self.rng = outline_xy, rng
        hall = np.array([[-1.0, -3.0], [1.0, -3.0], [1.0, 3.0], [-1.0, 3.0]])
        self.zero = self.arrival(hall, np.zeros(2), 0.0) - 1.0

    def ranges(self, sweep: Sweep, rig: Rig) -> FloatArray:
        """Read the room at each ping of a sweep [m]."""
        pings = Pings.from_sweep(sweep, rig)
        aimed = zip(pings.origins_xy, pings.bearings, strict=True)
        ranges = np.array([self.arrival(self.outline, place, float(bearing)) for place, bearing in aimed]) - self.zero
        rounded = np.round((ranges + self.rng.normal(0.0, JITTER, len(ranges))) / STEP) * STEP
        return np.where(rounded < rig.max_ranges[pings.sensors], rounded, np.inf)

    def arrival(self, outline_xy: FloatArray, place: FloatArray, bearing: float) -> float:
        """Range at which the envelope rises over the threshold [m]; ``inf`` if it never does."""
        response, late = self.response(outline_xy, place, bearing)
        level = np.abs(hilbert(fftconvolve(response, self.burst)))
        times = (np.arange(len(level)) - late) / RATE
        level *= 10 ** (-ABSORPTION * np.maximum(times, 0.0) * SPEED / 20) * (times > DEAF)
        first = int(np.argmax(level > self.threshold))
        if level[first] <= self.threshold:
            return float("inf")
        share = (self.threshold - level[first - 1]) / (level[first] - level[first - 1])
        return 0.5 * SPEED * float(times[first - 1] + share / RATE)

    def response(self, outline_xy: FloatArray, place: FloatArray, bearing: float) -> tuple[FloatArray, int]:
        """Pressure of an impulse at the receiver, and how many samples early it starts."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import pyroomacoustics as referee  # noqa: PLC0415 - it warns of its own affairs

            hard, across = referee.Material(0.02), 0.5 * APART * np.array([-np.sin(bearing), np.cos(bearing)])
            room = referee.Room.from_corners(outline_xy.T, fs=RATE, max_order=2, materials=hard)
            room.extrude(HEIGHT, materials=hard if self.hard_floor else referee.Material(1.0))
            room.set_sound_speed(SPEED)
            piston = _piston(referee, bearing)
            # Room.add_source drops a source of unknown directivity in silence; add_soundsource does not.
            room.add_soundsource(referee.SoundSource([*(place - across), PLANE], directivity=piston))
            room.add_microphone(np.array([*(place + across), PLANE]), directivity=piston)
            room.image_source_model()
            room.compute_rir()
        return room.rir[0][0], referee.constants.get("frac_delay_length") // 2


def _piston(referee: Any, bearing: float) -> Any:
    """Directivity of a piston that looks along a bearing."""

    class Piston(referee.directivities.base.Directivity):  # type: ignore[misc]
        is_impulse_response = False
        filter_len_ir = 1

        def get_response(self, azimuth: Any, colatitude: Any = None, *_: Any, degrees: bool = True, **__: Any) -> Any:
            unit = np.pi / 180 if degrees else 1.0
            level = np.sin(unit * np.asarray(colatitude)) if colatitude is not None else 1.0
            ahead = np.clip(level * np.cos(unit * np.asarray(azimuth) - bearing), -1.0, 1.0)
            argument = 2 * np.pi * FREQUENCY / SPEED * RADIUS * np.sqrt(1.0 - ahead**2) + 1e-9
            return np.where(ahead > 0.0, np.abs(2 * j1(argument) / argument), 0.0)

        def sample_rays(self, *_: Any) -> None:
            raise NotImplementedError

        def set_orientation(self, *_: Any) -> None:
            pass

    return Piston()


if __name__ == "__main__":
    main()
