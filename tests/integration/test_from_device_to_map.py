"""The whole chain: a board in a room, its serial port or network, ``echoplan record`` and ``echoplan map``."""

import re
import shutil
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest

from echoplan.evaluation import evaluate
from echoplan.hardware import Device
from echoplan.hardware.virtual import SERVO_GAIN, SERVO_ZERO, VirtualBoard
from echoplan.io import Recorder, read_map, read_rig
from echoplan.model import FeatureClass, FeatureMap, Route, Truth
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.sources import find_world
from helpers.avr import Uno, build, serial_port, skip_without_simulator
from helpers.devices import Line
from helpers.micropython import needs_micropython, running_device
from helpers.typed import Done, echoplan

ROOT = Path(__file__).parents[2]
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
        text = (ROOT / "src/echoplan/data/rigs/rotary-array.toml").read_text()
        text = text.replace("step = 0.017453", "step = 0.0523598").replace("[[0, 1, 2, 3]]", "[[0], [1], [2], [3]]")
        self.rig_file = folder / "rig.toml"
        self.rig_file.write_text(text)
        self.rig = read_rig(self.rig_file)
        assert self.rig.servo is not None
        self.pings = len(self.rig.servo.angles) * len(self.rig.sensors)
        self.places = folder / "places.txt"
        self.places.write_text("\n".join(f"{100 * x} {100 * y} {np.degrees(yaw)}" for x, y, yaw in stations))
        self.boards = [self.board([station], seed=number) for number, station in enumerate(stations)]
        self.stations = stations
        self.truth = Simulation(world=self.world, rig=self.rig, route=Route(map_from_base=np.array(stations))).truth
        self.answered = Counter[str]()

    def board(self, stations: Sequence[tuple[float, float, float]], *, seed: int = 0) -> VirtualBoard:
        """Return a robot at the first of its stations."""
        return VirtualBoard(
            world=self.world, rig=self.rig, stations=np.array(stations), settings=SimulationSettings(), seed=seed
        )

    def table(self, board: VirtualBoard) -> Iterator[tuple[int, list[int]]]:
        """Yield the pulses of a sweep [us] and the times of flight of the sensors there [us]."""
        assert self.rig.servo is not None
        for number, angle in enumerate(np.degrees(self.rig.servo.angles)):
            pulse = round(SERVO_ZERO + SERVO_GAIN * angle / 90)
            flights = list[int]()
            for sensor in range(len(self.rig.sensors)):
                board.advance(100_000 * (4 * number + sensor))
                board.servo(pulse)
                board.fire([sensor], 25_000)
                board.advance(100_000 * (4 * number + sensor) + 25_000)
                flights += board.flights() or [0]
            yield pulse, flights

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


def check_map(path: Path, truth: Truth) -> None:
    """Check that a map has all walls within 5 mm, and nothing else."""
    found = read_map(path)
    score = evaluate(found, truth)
    walls = score.matches.walls
    tally = score.matches.by_class[FeatureClass.WALL].tally
    assert (tally.right, tally.spurious) == (len(truth.walls_xy), 0)
    assert max(match.distance for match in walls.right) < 0.005
    assert (found.cylinders, found.openings) == ((), ())


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


@needs_micropython
def test_micropython_is_recorded_over_the_network_and_mapped(tmp_path: Path) -> None:
    room = Room("square", tmp_path)
    for number, (board, place) in enumerate(zip(room.boards, room.places.read_text().splitlines(), strict=True)):
        flights = tmp_path / f"flights-{number}.txt"
        flights.write_text("\n".join(" ".join(map(str, [pulse, *row])) for pulse, row in room.table(board)))
        with running_device(flights) as port:
            words: list[str | Path] = ["--rig", room.rig_file, "--place", place, *(["--append"] if number else [])]
            done = echoplan("record", f"tcp://127.0.0.1:{port}", "--out", tmp_path / "rec", *words)
        assert (done.status, done.err) == (0, "")
    done = echoplan("map", tmp_path / "rec", "--out", tmp_path / "map")
    assert (done.status, done.err) == (0, "")
    check_map(tmp_path / "map" / "map.json", room.truth)


def check_same_walls(found: FeatureMap, expected: FeatureMap) -> None:
    """Check that the walls of two maps are within 2 mm of each other."""
    assert len(found.walls) == len(expected.walls) == 4
    for wall, same in zip(found.walls, expected.walls, strict=True):
        np.testing.assert_allclose(wall.endpoints_xy, same.endpoints_xy, atol=0.002)


def map_over(line: Line, room: Room, folder: Path) -> FeatureMap:
    """Carry a robot through a room, record its stations over a line, and return their map."""
    with (
        Device("line", connect=line.connect) as device,
        Recorder(folder / "rec", rig=room.rig_file.read_text()) as recorder,
    ):
        for board, station in zip(room.boards, room.stations, strict=True):
            line.carry(board)
            device.place(np.array(station))
            for sweep in device.sweeps(1, rig=room.rig):
                recorder.add(sweep)
    assert echoplan("map", folder / "rec", "--out", folder / "map").status == 0
    return read_map(folder / "map" / "map.json")


def test_one_wrong_bit_in_a_hundred_resets_and_cuts_change_no_wall(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("time.sleep", lambda _: None)
    room = Room("square", tmp_path)
    sound = map_over(Line(room.boards[0]), room, tmp_path / "sound")
    # A read takes 2 ms: the device is reset, and the line is cut, every 80 seconds.
    rng = np.random.default_rng(1)
    resets, cuts = (np.cumsum(rng.integers(20_000, 60_000, size=50)).tolist() for _ in range(2))
    line = Line(room.boards[0], bit_errors=0.01, resets=resets, cuts=cuts)
    spoilt = map_over(line, room, tmp_path / "spoilt")
    assert line.reads[0] > resets[1]
    assert line.reads[0] > cuts[1]
    check_same_walls(spoilt, sound)


def recorded_with_faults(folder: Path, seed: int) -> Done:
    """Record a simulated device that is reset and unplugged at random times, over a noisy line."""
    faults = ["--faults", "resets,unplug,noise=0.0002", "--seed", str(seed)]
    command = [sys.executable, "-m", "echoplan", "device", "square", "--pty", "--speed", "10", *faults]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as device:
        assert device.stdout
        (address,) = re.findall(r"serial://\S+", device.stdout.readline())
        done = echoplan("record", address, "--out", folder)
        device.send_signal(signal.SIGINT)
    return done


def test_a_simulated_device_with_faults_is_recorded_and_mapped(tmp_path: Path) -> None:
    for seed in (3, 4, 5):
        shutil.rmtree(tmp_path / "rec", ignore_errors=True)
        done = recorded_with_faults(tmp_path / "rec", seed)
        # After a reset during a drive nobody knows where the robot is. Whether one happens depends on the machine.
        if "the device was reset while the robot moved" not in done.err:
            break
    assert done.status == 0, done.err
    assert re.search(r"5 sweeps\ndamaged lines: [1-9]", done.out)
    # Which of the two it is depends on the pace of the machine.
    assert re.search(r"^(lost connections|interrupted sweeps): [1-9]", done.out, re.MULTILINE)
    assert echoplan("map", tmp_path / "rec", "--out", tmp_path / "map").status == 0
    found = read_map(tmp_path / "map" / "map.json")
    lengths = [float(np.hypot(*np.diff(wall.endpoints_xy, axis=0)[0])) for wall in found.walls]
    np.testing.assert_allclose(lengths, [3.0] * 4, atol=0.01)
