"""The build guide does what it says: its commands run against a simulated device, and print what the page shows."""

import io
import re
import shlex
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.hardware.faulty import VirtualDevice
from echoplan.hardware.messages import Hello
from echoplan.hardware.protocol import Decoder
from echoplan.hardware.serving import TcpEndpoint, serve
from echoplan.hardware.virtual import VirtualBoard
from echoplan.io import builtin_rig, builtin_world, read_map, read_recording
from echoplan.model import Polyline, World
from helpers.typed import echoplan, succeed

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "build.md").read_text(encoding="utf-8")
SKETCH = ROOT / "firmware" / "arduino" / "echohead"
BLOCKS = re.findall(r"^```(sh|text)\n(.*?)^```$", PAGE, flags=re.DOTALL | re.MULTILINE)
# Programs that need a board.
OTHERS = ("sudo", "firmware/arduino/build", "avrdude", "pip", "mpremote", "python")
PROMPT = re.compile(r"^station \d+ \(empty: finish\): *(.*)$", flags=re.MULTILINE)


class HandBoard(VirtualBoard):
    """A board on a robot that somebody puts from place to place."""

    name = "uno"

    def __init__(self, *, world: World, stations: FloatArray) -> None:
        super().__init__(world=world, rig=builtin_rig("rotary-array"), stations=stations)
        self.capabilities = ("servo",)

    def put(self, station: FloatArray) -> None:
        """Put it there [m, m, rad]."""
        self._pose[:] = station


class Typist(io.StringIO):
    """Somebody at a terminal who puts the robot where she types that it is."""

    def __init__(self, lines: list[str], board: HandBoard) -> None:
        super().__init__()
        self.lines = iter(lines)
        self.board = board

    def isatty(self) -> bool:
        return True

    def readline(self, size: int | None = -1, /) -> str:  # type: ignore[override]  # as in the types of io
        # Whoever has no more to say presses Enter.
        line = next(self.lines, "")
        if line:
            self.board.put(pose_of(line))
        return line + "\n"


def pose_of(text: str) -> FloatArray:
    """The pose [m, m, rad] of "x y heading" [cm, cm, degrees]."""
    x, y, heading = map(float, text.split())
    return np.array([0.01 * x, 0.01 * y, np.radians(heading)])


@contextmanager
def served(board: HandBoard) -> Iterator[str]:
    """Serve a device, ten times faster than real time, and give its address."""
    over, port = threading.Event(), TcpEndpoint(0)
    device = VirtualDevice(board)
    thread = threading.Thread(target=lambda: serve(device, port, speed=10.0, is_over=over.is_set))
    thread.start()
    try:
        yield port.address
    finally:
        over.set()
        thread.join()
        port.close()


def commands(content: str) -> list[list[str]]:
    """Words of the commands of echoplan in a block."""
    lines = [shlex.split(line, comments=True) for line in content.replace("\\\n", "").splitlines()]
    assert [words for words in lines if words and words[0] not in ("echoplan", *OTHERS)] == []
    return [words[1:] for words in lines if words and words[0] == "echoplan"]


def shown(content: str) -> set[str]:
    """Lines of a block or an output without what may differ from run to run: numbers, and blanks between columns."""
    plain = (re.sub(r"-?\d+(\.\d+)?", "#", " ".join(line.split())) for line in content.splitlines())
    return {re.sub(r"(serial|tcp)://\S+?(?=:? |$)", "ADDRESS", line) for line in plain if line}


def prompts(content: str) -> str:
    """A dialogue without what was typed."""
    return PROMPT.sub(lambda found: found[0].removesuffix(found[1]).rstrip(), content)


def run_with_simulated_device(words: list[str], others: list[list[str]]) -> str:
    """Run the page's command for a simulated device at a free port, and other commands against it."""
    command = [sys.executable, "-m", "echoplan", *("0" if each == "4000" else each for each in words)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as device:
        try:
            assert device.stdout is not None
            printed = device.stdout.readline()
            address = re.search(r"tcp://\S+", printed)
            assert address is not None
            for other in others:
                printed += succeed(*(each.replace("tcp://localhost:4000", address[0]) for each in other))
        finally:
            device.terminate()
    return printed


def test_the_commands_of_the_page_run_and_print_what_it_shows(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (typed,) = [
        PROMPT.findall(content) for language, content in BLOCKS if language == "text" and "station 1" in content
    ]
    assert typed[-1] == ""
    board = HandBoard(world=builtin_world("square"), stations=pose_of(typed[0])[None])
    monkeypatch.setattr(sys, "stdin", Typist(typed, board))
    ran = [words for language, content in BLOCKS if language == "sh" for words in commands(content)]
    simulated = [words for words in ran if words[0] == "device" or "tcp://localhost:4000" in words]
    printed = ""
    with served(board) as address:
        for words in (each for each in ran if each not in simulated):
            # Two sweeps show what twenty do.
            replaced = {"serial:///dev/ttyUSB0": address, "20": "2"}
            done = echoplan(*(replaced.get(word, word) for word in words))
            assert done.status == 0, done.err
            printed += done.out + done.err.replace(": station", ": \nstation") + "\n"
    printed += run_with_simulated_device(simulated[0], simulated[1:])
    outputs = shown(prompts(printed))
    for language, content in BLOCKS:
        if language == "text" and not content.startswith("$"):
            assert shown(prompts(content)) <= outputs
    assert {words[0] for words in ran} >= {"info", "record", "map", "device"}
    found = read_map(Path("map"))
    assert "Good map: the echoes fit together." in printed
    assert (len(found.walls), len(found.corners)) == (4, 4)
    assert [wall.length for wall in found.walls] == pytest.approx([3.0] * 4, abs=0.01)
    assert len(list(read_recording(Path("sim")))) == 5


def test_the_line_that_a_builder_sees_first_is_that_of_the_sketch() -> None:
    (line,) = [content for language, content in BLOCKS if language == "text" and content.startswith("$hello")]
    (hello,) = Decoder().feed(line.encode())
    assert isinstance(hello, Hello)
    sketch = "\n".join(path.read_text() for path in sorted(SKETCH.iterdir()))
    for pattern, value in (
        (r'#define BOARD "(\w+)"', hello.board),
        (r"#define SENSORS (\d+)", str(hello.sensors)),
        (r"MOST_UNACKNOWLEDGED = (\d+);", str(hello.window)),
        (r'FIRMWARE\[\] PROGMEM = "([\d.]+)"', hello.firmware),
    ):
        assert re.findall(pattern, sketch) == [value]
    assert hello.capabilities == "servo"


def test_a_box_on_the_left_is_nearest_to_sensor_1() -> None:
    box = Polyline(points_xy=np.array([[0.35, 1.2], [0.65, 1.2], [0.65, 1.4], [0.35, 1.4]]), closed=True)
    room = builtin_world("square")
    world = World(name="box", polylines=(*room.polylines, box))
    with served(HandBoard(world=world, stations=np.array([[0.5, 1.0, 0.0]]))) as address:
        table = succeed("info", address)
    nearest = [float(each) for each in re.findall(r"^\d .* (\S+) to \S+$", table, flags=re.MULTILINE)]
    assert len(nearest) == 4
    assert nearest[1] == min(nearest) == pytest.approx(0.15, abs=0.01)
