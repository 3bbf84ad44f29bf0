"""A simulated device: a board whose echoes come from the simulator, and which drives from station to station."""

import math
from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from echoplan.acoustics import typical_transducer
from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InvalidValueError
from echoplan.geometry import compose, wrap
from echoplan.hardware.head import Board
from echoplan.hardware.readings import FAULTY, NO_ECHO
from echoplan.model import Rig, World
from echoplan.simulation import SimulationSettings
from echoplan.simulation.detector import Detector, build_detector
from echoplan.simulation.module import Module, build_module
from echoplan.simulation.receiver import ReceiverSimulation
from echoplan.simulation.scene import Scene, build_scene
from echoplan.simulation.schedule import Schedule
from echoplan.simulation.shots import build_shots, memory_of
from echoplan.simulation.sonar import Sonar, build_sonar
from echoplan.simulation.stage import Stage

__all__ = ["COUNTS_PER_METRE", "SERVO_GAIN", "SERVO_ZERO", "WHEEL_BASE", "VirtualBoard"]

# Wheels of 65 mm with magnetic encoders of 4096 counts a turn, 20 cm apart [1/m, m].
COUNTS_PER_METRE, WHEEL_BASE = 20_000, 0.2
# Pulse of a common hobby servo at 0 and its change for +90 degrees [us].
SERVO_ZERO, SERVO_GAIN = 1500, 1000
# How fast the robot drives [m/s] and turns [rad/s], and how long it stands between the two [us]: longer than the 50 ms
# from report to report of the wheels, so that dead reckoning knows each part of its route.
_SPEED, _TURN_RATE, _PAUSE = 0.3, 1.5, 120_000
_MOST_SENSORS = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class _Shot:
    """A burst: when [us], by which sensor, from which pose of its acoustic centre [m, m, rad]."""

    clock_us: int
    sensor: int
    map_from_sensor: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Acoustics:
    """What decides what a sensor detects."""

    module: Module
    scene: Scene
    sonar: Sonar
    detector: Detector
    memory: float | None

    def ranges(self, before: list[_Shot], shots: list[_Shot], *, rng: np.random.Generator) -> FloatArray:
        """Return the reading of each shot [m], shape (n,); bursts before may still be in the air."""
        every = [*before, *shots]
        count, still = len(every), np.zeros((len(every), 3))
        sensors = np.array([shot.sensor for shot in every])
        schedule = Schedule(
            stamps_ns=np.array([1000 * shot.clock_us for shot in every]),
            sensors=sensors,
            servo_angles=np.zeros(count),
            map_from_base=still,
            map_from_sensors=np.array([shot.map_from_sensor for shot in every]),
            velocities=still,
            bounds=np.array([0, count]),
        )
        shots_of_all = build_shots(schedule, self.module, memory=self.memory)
        stage = Stage(scene=self.scene, sonar=self.sonar, shots=shots_of_all)
        pings = np.arange(len(before), count)
        instants = ReceiverSimulation(stage=stage, detector=self.detector).instants(pings)
        return self.module.readings(instants, sensors[pings], rng)


class _Leg(NamedTuple):
    """A part of a drive: straight ahead [m], a turn on the spot [rad], or a pause; from when until when [us]."""

    begin: int
    end: int
    distance: float
    turn: float

    def until(self, clock_us: int) -> FloatArray:
        """Return the motion until a time as a pose in the frame of the leg's begin, shape (3,)."""
        share = min(max((clock_us - self.begin) / (self.end - self.begin), 0.0), 1.0)
        return np.array([share * self.distance, 0.0, share * self.turn])


class VirtualBoard(Board):
    """The board of a simulated device.

    It stands at the first station, and each drive takes it to the next: a turn, a straight line and a turn.  Its servo
    is there at once: what lags in a servo is not simulated here.  Between two triggers it stands still.

    Parameters
    ----------
    world : World
        What stands in the room.
    rig : Rig
        Its sensors.
    stations : ndarray, shape (s, 3)
        Where it stands and drives to [m, m, rad].
    settings : SimulationSettings, optional
        Air, module, paths and noise.
    seed : int, optional
        Seed of all chance.
    silent, stuck : int, optional
        Number of a sensor that never detects anything, and of one whose echo pin is always high.

    Raises
    ------
    InvalidValueError
        If the rig has more sensors than the protocol.
    """

    name = "simulated"
    window = 255
    tick = round(1e6 / COUNTS_PER_METRE)
    base = round(1e4 * WHEEL_BASE)

    def __init__(
        self,
        *,
        world: World,
        rig: Rig,
        stations: FloatArray,
        settings: SimulationSettings | None = None,
        seed: int = 0,
        silent: int | None = None,
        stuck: int | None = None,
    ) -> None:
        if len(rig.sensors) > _MOST_SENSORS:
            raise InvalidValueError(f"a device has at most {_MOST_SENSORS} sensors, and the rig has {len(rig.sensors)}")
        settings = settings or SimulationSettings()
        transducer = rig.transducer or typical_transducer(rig.sensors[0])
        self.rig = rig
        self.stations = stations
        self.settings = settings
        self.sensors = len(rig.sensors)
        self.capabilities = (*(("servo",) if rig.servo else ()), "air", "wheels", "drive")
        self._faulty = {stuck: FAULTY} if silent is None else {silent: NO_ECHO, stuck: FAULTY}
        self._rng = np.random.default_rng(seed)
        self._acoustics = _Acoustics(
            module=build_module(rig, transducer, settings),
            scene=build_scene(world),
            sonar=build_sonar(transducer, settings),
            detector=build_detector(transducer, settings),
            memory=memory_of(transducer, settings.air) if settings.second_time_around else None,
        )
        # Bursts that may still be in the air.
        self._shots = deque[_Shot]()
        self._flights: list[int] = []
        self._legs: list[_Leg] = []
        # Where the robot was when its drive began, or ended.
        self._pose = np.array(stations[0], dtype=np.float64)
        self._wheels = np.zeros(2)
        # The clock, when the sensors are ready, the index of the station where it was last, and whether it has left it
        # or a later one without a ping since.
        self._state = {"clock": 0, "ready": 0, "station": 0, "pulse": SERVO_ZERO, "left": 0}

    @property
    def map_from_base(self) -> FloatArray:
        """Where the robot truly is [m, m, rad], shape (3,)."""
        pose = self._pose
        for leg in self._legs:
            pose = compose(pose, leg.until(self._state["clock"]))
        return pose

    @property
    def is_driving(self) -> bool:
        """Whether the robot has left a station and has not fired since."""
        return bool(self._state["left"])

    def reset(self) -> None:
        """Do to the board what a reset does: it stops, and its counters begin at 0."""
        self.halt()
        self._wheels[:] = 0.0

    def advance(self, clock_us: int) -> None:
        """Take the time."""
        self._state["clock"] = clock_us

    def servo(self, pulse_us: int) -> None:
        """Turn the servo."""
        self._state["pulse"] = pulse_us

    def fire(self, sensors: list[int], listen_us: int) -> None:
        """Trigger sensors at once; their echoes are simulated now."""
        clock, settings = self._state["clock"], self.settings
        turn = (self._state["pulse"] - SERVO_ZERO) / SERVO_GAIN * math.pi / 2
        angle = settings.servo_offset + settings.servo_gain * turn if self.rig.servo else 0.0
        in_base = self.rig.base_from_sensors(self.rig.sensor_ids[sensors], np.full(len(sensors), angle))
        poses = map(tuple, compose(self.map_from_base, in_base).tolist())
        placed = zip(sensors, poses, strict=True)
        shots = [_Shot(clock_us=clock, sensor=sensor, map_from_sensor=pose) for sensor, pose in placed]
        while self._shots and clock - self._shots[0].clock_us > 1e6 * (self._acoustics.memory or 0.0):
            self._shots.popleft()
        ranges = self._acoustics.ranges(list(self._shots), shots, rng=self._rng)
        self._shots.extend(shots)
        self._state["left"] = 0
        flights = _flights_of(ranges, sensors, module=self._acoustics.module, listen_us=listen_us)
        self._flights[:] = [self._faulty.get(sensor, int(each)) for sensor, each in zip(sensors, flights, strict=True)]
        # A faulty sensor answers at once, and one without echo when it stops listening.
        answered = np.array(self._flights)
        waits = np.select([answered == FAULTY, answered > 0], [0, answered], listen_us)
        self._state["ready"] = clock + int(waits.max())

    def flights(self) -> list[int] | None:
        """Return the times of flight, once the last echo has come or the sensors have ceased to listen."""
        return list(self._flights) if self._state["clock"] >= self._state["ready"] else None

    def temperature(self) -> int:
        """Return the temperature of the air [0.01 deg C]."""
        return round(100 * self.settings.air.temperature)

    def wheels(self) -> tuple[int, int]:
        """Return the counts of the wheels."""
        motions = sum((leg.until(self._state["clock"]) for leg in self._legs), start=np.zeros(3))
        left, right = np.round(COUNTS_PER_METRE * (self._wheels + _distances_of_wheels(motions)))
        return int(left), int(right)

    def depart(self) -> None:
        """Start to drive to the next station, if there is one."""
        following = self._state["station"] + 1
        if following < len(self.stations):
            self._legs[:] = _plan(self._pose, self.stations[following], begin=self._state["clock"])
            self._state["left"] = 1

    def has_arrived(self) -> bool:
        """Return whether the drive is over."""
        if self._legs and self._state["clock"] >= self._legs[-1].end:
            self._state["station"] += 1
            self.halt()
            self._pose[:] = self.stations[self._state["station"]]
        return not self._legs

    def halt(self) -> None:
        """Stop where the robot is; the next drive goes on to the same station."""
        motions = sum((leg.until(self._state["clock"]) for leg in self._legs), start=np.zeros(3))
        self._wheels += _distances_of_wheels(motions)
        self._pose[:] = self.map_from_base
        self._legs.clear()


def _flights_of(ranges: FloatArray, sensors: list[int], *, module: Module, listen_us: int) -> IntArray:
    """Convert readings [m], shape (n,), to times of flight [us]."""
    # An echo within the dead distance gives a short pulse; a reading at either end of the range stays within it.
    per_metre = 2e6 / module.speed_of_sound
    shortest, longest = module.min_ranges[sensors] * per_metre, module.max_ranges[sensors] * per_metre
    flights = np.clip(np.round(ranges * per_metre), np.ceil(shortest), np.floor(longest))
    flights = np.where(ranges == -np.inf, np.round(shortest / 2), flights)
    return np.where((ranges == np.inf) | (flights > listen_us), NO_ECHO, flights).astype(np.int64)


def _distances_of_wheels(motion: FloatArray) -> FloatArray:
    """Return how far the left and the right wheel roll [m] when the robot drives and turns so much, shape (2,)."""
    distances: FloatArray = motion[0] + 0.5 * WHEEL_BASE * motion[2] * np.array([-1.0, 1.0])
    return distances


def _plan(pose: FloatArray, goal: FloatArray, *, begin: int) -> list[_Leg]:
    """Return the parts of a drive: turn, straight and turn, each followed by a pause."""
    dx, dy = goal[:2] - pose[:2]
    distance = math.hypot(dx, dy)
    heading = math.atan2(dy, dx) if distance > 0 else float(goal[2])
    first, last = float(wrap(heading - pose[2])), float(wrap(goal[2] - heading))
    legs = []
    for straight, turn in ((0.0, first), (distance, 0.0), (0.0, last)):
        duration = max(1, round(1e6 * max(straight / _SPEED, abs(turn) / _TURN_RATE)))
        legs.append(_Leg(begin, begin + duration, straight, turn))
        begin += duration
        legs.append(_Leg(begin, begin + _PAUSE, 0.0, 0.0))
        begin += _PAUSE
    return legs
