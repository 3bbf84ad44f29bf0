"""A person who calibrates a simulated device: what each step asks for is done to the world before it is answered."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from echoplan.hardware.head import Board, Head
from echoplan.hardware.port import Port
from echoplan.hardware.virtual import SERVO_ZERO, VirtualBoard
from echoplan.model import Pillar, Polyline, Rig, World
from echoplan.simulation import SimulationSettings

# What is done, and what is answered.
Step: TypeAlias = tuple[Callable[[], None], str]

# Time that passes from read to read of the host [us].
_TICK_US = 20_000
_NOTHING = World(name="nothing", polylines=())
# Time of flight of a sensor that is covered [us].
_COVERED = 50


class Bench(Board):
    """A board in front of whatever a person puts there, and the line to it.

    ``order`` has, for each sensor number of the device, its place in the rig; the servo may be mirrored.
    """

    name = "bench"

    def __init__(
        self,
        rig: Rig,
        *,
        settings: SimulationSettings | None = None,
        order: tuple[int, ...] = (),
        is_mirrored: bool = False,
        has_thermometer: bool = True,
        seed: int = 0,
    ) -> None:
        self.rig = rig
        self.settings = settings or SimulationSettings()
        self.order = order or tuple(range(len(rig.sensors)))
        self.is_mirrored = is_mirrored
        self.sensors = len(rig.sensors)
        self.capabilities = ("servo", "air") if has_thermometer else ("servo",)
        self.seed = seed
        self.covered: list[int] = []
        self._boards: list[VirtualBoard] = []
        self._fired: list[int] = []
        self._heads = [Head(self)]
        self._reads = [0]
        self.put(_NOTHING)

    def put(self, world: World, *, heading: float = 0.0) -> None:
        """Place the robot in another world, where it heads in a direction [rad]."""
        poses = np.array([[0.0, 0.0, heading]])
        board = VirtualBoard(world=world, rig=self.rig, stations=poses, settings=self.settings, seed=self.seed)
        self._boards[:] = [board]

    def advance(self, clock_us: int) -> None:
        self._boards[0].advance(clock_us)

    def servo(self, pulse_us: int) -> None:
        self._boards[0].servo(2 * SERVO_ZERO - pulse_us if self.is_mirrored else pulse_us)

    def fire(self, sensors: list[int], listen_us: int) -> None:
        self._fired[:] = [self.order[each] for each in sensors]
        self._boards[0].fire(self._fired, listen_us)

    def flights(self) -> list[int] | None:
        flights = self._boards[0].flights()
        covered = [place in self.covered for place in self._fired]
        return flights and [_COVERED if is_covered else each for is_covered, each in zip(covered, flights, strict=True)]

    def temperature(self) -> int:
        return self._boards[0].temperature()

    def connect(self, name: str) -> Port:
        """Open a port to the board; its time passes while the host reads."""
        return Port(name=name, transport=self, clock=lambda: 1e-6 * _TICK_US * self._reads[0])

    def read(self) -> bytes:
        self._reads[0] += 1
        return self._heads[0].advance(_TICK_US * self._reads[0])

    def write(self, data: bytes) -> None:
        self._heads[0].receive(data)

    def close(self) -> None:
        """Nothing has to be closed."""


class Answers:
    """Standard input of a person: does what a step asks for, and answers it."""

    def __init__(self, steps: Iterator[Step]) -> None:
        self.steps = steps

    def isatty(self) -> bool:
        return False

    def readline(self) -> str:
        for act, answer in self.steps:
            act()
            return f"{answer}\n"
        return ""


def wall(distance: float) -> World:
    """Return a wall across the x axis."""
    points = np.array([[distance, -3.0], [distance, 3.0]])
    return World(name="wall", polylines=(Polyline(points_xy=points),))


def corner(distance: float) -> World:
    """Return a right-angled corner: the right wall is so far from a robot that faces it, the left one 15 cm less."""
    right, left = distance, distance - 0.15
    vertex = np.array([left + right, left - right]) / np.sqrt(2.0)
    points = vertex + np.array([[-3.0, -3.0], [0.0, 0.0], [-3.0, 3.0]])
    return World(name="corner", polylines=(Polyline(points_xy=points),))


def hand(*, bearing: float = np.pi / 4) -> World:
    """Return a hand in front of the robot."""
    center = 0.34 * np.array([np.cos(bearing), np.sin(bearing)])
    return World(name="hand", polylines=(), pillars=(Pillar(center_xy=center, radius=0.04),))


def does(act: Callable[..., None], *args: object, answer: str = "", **kwargs: object) -> Step:
    """Return a step."""
    return lambda: act(*args, **kwargs), answer


def skips(count: int = 1) -> list[Step]:
    """Return steps that are skipped."""
    return count * [(lambda: None, "s")]


def identifies(bench: Bench) -> list[Step]:
    """Return the steps in which all sensors but the last are covered, and then a hand is held on the left."""

    def cover(*places: int) -> None:
        bench.covered[:] = places

    def show_hand() -> None:
        cover()
        bench.put(hand())

    return [*(does(cover, place) for place in range(bench.sensors - 1)), does(show_hand)]


def faces_wall(bench: Bench, *, distance: float, aim: float = 0.0, tape: float = 0.0) -> Step:
    """Return the step in which the robot faces a wall [m]; it aims so far off [rad], the tape is so wrong [m]."""
    return does(bench.put, wall(distance), heading=aim, answer=f"{100 * (distance + tape):.1f} cm")


def turns(bench: Bench, *, distance: float) -> list[Step]:
    """Return the steps in which the other sensors face the wall."""
    return [does(bench.put, wall(distance), heading=-sensor.yaw) for sensor in bench.rig.sensors[1:]]


def faces_corner(bench: Bench, *, distance: float, aim: float = 0.0) -> Step:
    """Return the step in which the robot faces a corner."""
    return does(bench.put, corner(distance), heading=aim)


def quick(rig: Rig) -> Rig:
    """Return a rig that turns in steps of 2 degrees."""
    assert rig.servo is not None
    return replace(rig, servo=replace(rig.servo, step=2.0 * rig.servo.step))
