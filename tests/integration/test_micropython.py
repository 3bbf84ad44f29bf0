"""The firmware of MicroPython boards in MicroPython's unix port: shared lines, and sweeps over TCP."""

import socket
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from echoplan.hardware.messages import Ack, Done, Echo, Hello, Identify, Message, Record, Set, Sweeps
from echoplan.hardware.protocol import Decoder, encode
from helpers.micropython import MICROPYTHON, needs_micropython, running_device

ROOT = Path(__file__).parents[2]
pytestmark = needs_micropython

LINES_CHECK = """
import sys
sys.path.insert(0, "src/echoplan/hardware")
from head import line_of, read_command
for row in open("tests/golden/protocol/lines.tsv").read().split("\\n")[1:-1]:
    sender, payload, line = row.split("\\t")
    sent = line.replace("\\\\r", "\\r").encode()
    if sender == "host":
        good = ",".join(read_command(sent)) == ("" if payload == "-" else payload)
    else:
        good = payload == "-" or line_of(payload) == sent + b"\\n"
    print("good" if good else "bad: " + row)
"""
PULSES_CHECK = """
import machine, time
class Echo(machine.PinBase):
    def value(self, level=None):
        return int(460 <= time.ticks_diff(time.ticks_us(), started) < 460 + 5831)
errors = []
for _ in range(20):
    started = time.ticks_us()
    errors.append(abs(machine.time_pulse_us(Echo(), 1, 25000) - 5831))
print(min(errors))
"""


def output_of(program: str) -> str:
    assert MICROPYTHON
    done = subprocess.run([MICROPYTHON, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout


def flight(sensor: int, pulse: int) -> int:
    """Return the time of flight of a sensor at a pulse of the servo [us]."""
    return [5000 + pulse, 0, -1, 30_000 - 10 * pulse][sensor]


class Client:
    """A host with one connection."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.settimeout(0.02)
        self.decoder = Decoder()
        self.answers: list[Message] = []

    def say(self, *messages: Message) -> None:
        self.socket.sendall(b"".join(map(encode, messages)))

    def receive(self) -> list[Message]:
        try:
            return list(self.decoder.feed(self.socket.recv(4096)))
        except TimeoutError:
            return []

    def records(self, job: int) -> list[Record]:
        """Return the records of a job, acknowledged one by one."""
        arrived: list[Record] = []
        until = time.monotonic() + 15
        while not (arrived and isinstance(arrived[-1], Done)):
            assert time.monotonic() < until
            for message in self.receive():
                if isinstance(message, Record) and message.number == len(arrived):
                    arrived.append(message)
                    self.say(Ack(job=job, next=len(arrived)))
                elif not isinstance(message, Record):
                    self.answers.append(message)
        return arrived


@contextmanager
def device(folder: Path) -> Iterator[Client]:
    table = folder / "flights.txt"
    rows = ([pulse, *(flight(sensor, pulse) for sensor in range(4))] for pulse in range(1000, 2001))
    table.write_text("".join(" ".join(map(str, row)) + "\n" for row in rows), encoding="ascii")
    with running_device(table) as port:
        client = Client(port)
        try:
            yield client
        finally:
            client.socket.close()


def test_micropython_reads_and_writes_the_shared_lines() -> None:
    rows = output_of(LINES_CHECK).splitlines()
    assert len(rows) > 80
    assert set(rows) == {"good"}


def test_micropython_times_the_pulse_of_an_echo_pin() -> None:
    # A busy computer delays most of them.
    assert float(output_of(PULSES_CHECK)) < 50


def test_a_board_sweeps_over_tcp_and_a_new_host_takes_over(tmp_path: Path) -> None:
    short = [("start", -300), ("stop", 300), ("dwell", 10), ("guard", 5), ("settle", 0), ("window", 32)]
    with device(tmp_path) as client:
        client.say(Identify(), *(Set(name=name, value=value) for name, value in short), Sweeps(job=5, count=2))
        records = client.records(5)
        assert any(isinstance(each, Hello) and each.board == "unix" and each.sensors == 4 for each in client.answers)
        echoes = [each for each in records if isinstance(each, Echo)]
        assert [each.sensor for each in echoes] == [0, 1, 2, 3] * 14
        assert [each.flight for each in echoes] == [flight(each.sensor, each.pulse) for each in echoes]
        other = Client(client.socket.getpeername()[1])
        other.say(Set(name="together", value=1), Sweeps(job=6, count=1))
        echoes = [each for each in other.records(6) if isinstance(each, Echo)]
        assert len({each.clock for each in echoes}) == 7
        # The loop that watches several pins at once looks every 10 us.
        assert all(abs(each.flight - flight(each.sensor, each.pulse)) <= 10 for each in echoes)
        assert client.decoder.damaged == other.decoder.damaged == 0
        other.socket.close()
