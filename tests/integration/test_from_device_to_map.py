"""The whole chain: a board in a room, its serial port or network, ``echoplan record`` and ``echoplan map``."""

import re
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from echoplan.evaluation import evaluate
from echoplan.hardware.virtual import VirtualBoard
from echoplan.io import read_map, read_recording, read_rig, write_rig
from echoplan.model import FeatureMap, Rig, Truth
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.sources import find_rig, find_world
from helpers.avr import Uno, build, serial_port, skip_without_simulator
from helpers.typed import echoplan

ROOMS = {
    "square": (
        "[[-1.0, -0.5], [2.0, -0.5], [2.0, 2.5], [-1.0, 2.5]]",
        [
            (-0.4, 0.2, 0.3),
            (0.9, 0.1, 1.2),
            (1.5, 1.1, 2.4),
            (0.8, 1.9, -2.6),
            (-0.5, 1.4, -0.7),
        ],
    ),
    "L-shaped": (
        "[[0.0, 0.0], [3.6, 0.0], [3.6, 1.7], [1.8, 1.7], [1.8, 3.4], [0.0, 3.4]]",
        [
            (0.6, 0.5, 0.0),
            (1.4, 0.9, 0.8),
            (2.4, 0.7, 1.6),
            (3.1, 1.1, 2.5),
            (1.3, 1.5, -2.4),
            (1.2, 2.4, -1.2),
            (0.5, 2.9, -0.3),
            (0.5, 1.8, 0.5),
        ],
    ),
}


class Room:
    """A room around a board that is carried from station to station; a sweep later it stands at the next."""

    def __init__(self, name: str, folder: Path) -> None:
        points, stations = ROOMS[name]
        path = folder / "world.toml"
        path.write_text(f'name = "{name}"\n[[wall]]\npoints = {points}\nclosed = true\n')
        self.world = find_world(str(path))
        # Three degrees a step, one sensor after the other, as HC-SR04 need it.
        text = (Path(__file__).parents[2] / "src/echoplan/data/rigs/rotary-array.toml").read_text()
        text = text.replace("step = 0.017453", "step = 0.0523598").replace("[[0, 1, 2, 3]]", "[[0], [1], [2], [3]]")
        self.rig_file = folder / "rig.toml"
        self.rig_file.write_text(text)
        self.rig = read_rig(self.rig_file)
        assert self.rig.servo is not None
        self.pings = len(self.rig.servo.angles) * len(self.rig.sensors)
        self.places = folder / "places.txt"
        self.places.write_text("\n".join(f"{100 * x} {100 * y} {np.degrees(yaw)}" for x, y, yaw in stations))
        self.boards = [
            VirtualBoard(
                world=self.world, rig=self.rig, stations=np.array([station]), settings=SimulationSettings(), seed=number
            )
            for number, station in enumerate(stations)
        ]
        self.truth = Simulation(world=self.world, rig=self.rig, route=_route(stations)).truth
        self.answered = Counter[str]()

    def flight(self, sensor: int, pulse_us: float, clock_us: float) -> float | None:
        """Return the time of flight [us] of a ping; None without an echo."""
        board = self.boards[min(self.answered["pings"] // self.pings, len(self.boards) - 1)]
        self.answered["pings"] += 1
        board.advance(round(clock_us))
        board.servo(round(pulse_us))
        board.fire([sensor], 25_000)
        board.advance(round(clock_us) + 25_000)
        (flight,) = board.flights() or [0]
        return float(flight) if flight > 0 else None


def _route(stations):
    from echoplan.model import Route

    return Route(map_from_base=np.array(stations))


def check_map(path: Path, truth: Truth) -> None:
    """Check that a map has all walls within 5 mm, and nothing else."""
    found = read_map(path)
    score = evaluate(found, truth)
    walls = score.matches.walls
    print([1000 * match.distance for match in walls.right], found.quality)
    tally = score.matches.by_class["wall"].tally
    assert (tally.right, tally.spurious) == (len(truth.walls_xy), 0)
    assert max(match.distance for match in walls.right) < 0.005
    assert not found.cylinders and not found.openings


@pytest.mark.parametrize("name", ROOMS)
def test_an_arduino_is_recorded_and_mapped(name: str, tmp_path: Path, tmp_path_factory: pytest.TempPathFactory) -> None:
    skip_without_simulator()
    room = Room(name, tmp_path)
    uno = Uno(build(tmp_path_factory.mktemp("firmware")), flight=room.flight)
    with serial_port(uno) as port:
        done = echoplan(
            "record", f"serial://{port}", "--out", tmp_path / "rec", "--rig", room.rig_file, "--places", room.places
        )
    assert (done.status, done.err) == (0, "")
    done = echoplan("map", tmp_path / "rec", "--out", tmp_path / "map")
    assert (done.status, done.err) == (0, "")
    assert done.out.startswith("Good map")
    check_map(tmp_path / "map" / "map.json", room.truth)
