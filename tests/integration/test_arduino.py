"""The Arduino firmware, compiled and run in a simulated Uno whose sensors measure what a test answers."""

import random
import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from echoplan.hardware.faulty import with_wrong_bits
from echoplan.hardware.head import FIRMWARE, SETTINGS, Board, Head
from echoplan.hardware.messages import (
    Accepted,
    Ack,
    Air,
    Begin,
    Config,
    Done,
    Echo,
    End,
    Hello,
    Identify,
    Message,
    Move,
    Ping,
    Pong,
    Record,
    Refused,
    Set,
    Stop,
    Sweeps,
    Value,
    Wheels,
)
from echoplan.hardware.protocol import Decoder, encode
from helpers.avr import DISCONNECTED, Flight, Uno, build, serial_port, skip_without_compiler, skip_without_simulator

ROOT = Path(__file__).parents[2]
ARDUINO = ROOT / "firmware" / "arduino"
DEFAULTS = {name: default for name, _, _, default in SETTINGS}
# Quick sweeps of seven steps.
QUICK = {"start": -300, "stop": 300, "dwell": 5, "guard": 5, "settle": 0, "listen": 5}


class Host:
    """The host's end of the line: what it sends is obeyed while the device runs."""

    def __init__(self, uno: Uno) -> None:
        self.uno = uno
        self.decoder = Decoder()

    def run(self, milliseconds: float) -> list[Message]:
        """Let time pass and return what came."""
        self.uno.run(milliseconds)
        return list(self.decoder.feed(self.uno.read()))

    def send(self, *commands: Message) -> None:
        """Send commands; they arrive while time passes."""
        self.uno.write(b"".join(map(encode, commands)))

    def ask(self, *commands: Message, wait: float = 20) -> list[Message]:
        """Send commands and return what comes in the next milliseconds."""
        self.send(*commands)
        return self.run(wait)

    def set(self, **settings: int) -> None:
        """Change settings."""
        for name, value in settings.items():
            assert self.ask(Set(name=name, value=value), wait=7) == [Value(name=name, value=value)]

    def until_done(self, *, limit: float = 3000, acknowledge: int = 0) -> list[Record]:
        """Return the records of a job; acknowledge them all every so many milliseconds."""
        records: list[Record] = []
        waited = 0.0
        while not (records and isinstance(records[-1], Done)):
            assert waited < limit, records
            slice_ms = acknowledge or 10
            for message in self.run(slice_ms):
                if isinstance(message, Record) and message.number == len(records):
                    records.append(message)
            if acknowledge and records:
                self.uno.write(encode(Ack(job=records[-1].job, next=len(records))))
            waited += slice_ms
        return records


@pytest.fixture(scope="session")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    skip_without_compiler()
    return tmp_path_factory.mktemp("firmware")


@pytest.fixture(scope="session")
def program(folder: Path) -> Path:
    return build(folder)


@pytest.fixture(scope="session")
def rover(folder: Path) -> Path:
    """The firmware for two sensors without a servo, on wheels, with a thermometer."""
    skip_without_simulator()
    return build(folder, name="rover", SENSORS=2, SERVO=0, THERMOMETER=1, WHEELS=2)


@pytest.fixture
def start(program: Path) -> Callable[..., Host]:
    skip_without_simulator()

    def start(flight: Flight = lambda *_: 600.0, **settings: int) -> Host:
        host = Host(Uno(program, flight=flight))
        assert [type(message) for message in host.run(15)] == [Hello]
        host.set(**settings)
        return host

    return start


def echoes(records: Sequence[Message]) -> list[Echo]:
    return [record for record in records if isinstance(record, Echo)]


def is_numbered(records: Sequence[Record]) -> bool:
    return [record.number for record in records] == list(range(len(records)))


@pytest.mark.skipif(shutil.which("g++") is None, reason="g++ is missing")
def test_the_code_of_the_firmware_reads_and_writes_the_shared_lines(tmp_path: Path) -> None:
    sources = [ARDUINO / "tests" / "vectors.cpp", ARDUINO / "echohead" / "protocol.cpp"]
    compiler = ["g++", "-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsanitize=undefined"]
    subprocess.run([*compiler, *sources, "-o", tmp_path / "vectors"], check=True)
    lines = ROOT / "tests" / "golden" / "protocol" / "lines.tsv"
    done = subprocess.run([tmp_path / "vectors", lines], capture_output=True, text=True, check=False)
    count = lines.read_bytes().count(b"\n") - 1
    assert (done.returncode, done.stdout) == (0, f"{count} vectors\n"), done.stdout


def test_the_build_prints_the_use_of_flash_and_ram(program: Path) -> None:
    used = re.findall(r"(flash|RAM): (\d+) of (\d+) bytes", program.with_suffix(".txt").read_text())
    assert [(name, total) for name, _, total in used] == [("flash", "32256"), ("RAM", "2048")]
    assert all(int(size) < 0.6 * int(total) for _, size, total in used)
    assert program.with_name("echohead.hex").read_bytes().startswith(b":")


def test_the_build_refuses_a_line_that_the_configuration_does_not_have(program: Path) -> None:
    command = [str(ARDUINO / "build"), str(program.parent), "SENSOR=2"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "no line '#define SENSOR'" in done.stderr


def test_the_device_introduces_itself_after_a_reset_and_when_asked(start: Callable[..., Host]) -> None:
    hello = Hello(protocol=1, firmware=FIRMWARE, board="uno", sensors=4, window=24, capabilities="servo")
    host = start()
    assert host.ask(Identify()) == [hello]
    (pong,) = host.ask(Ping(token=77))
    assert isinstance(pong, Pong)
    assert (pong.token, pong.job) == (77, 0)
    assert pong.clock == pytest.approx(host.uno.clock_us, abs=20_000)


def test_flights_are_as_answered_and_times_are_those_of_the_triggers(start: Callable[..., Host]) -> None:
    rng = random.Random(1)
    host = start(lambda *_: rng.uniform(150, 23_000), **QUICK | {"listen": 25, "dwell": 25, "guard": 24})
    host.send(Sweeps(job=1, count=1))
    found = echoes(host.until_done())
    assert len(found) == len(host.uno.answers) == 28
    for echo, answer in zip(found, host.uno.answers, strict=True):
        assert echo.sensor == answer.sensor
        assert echo.flight == pytest.approx(answer.flight_us, abs=8)
    delays = [answer.clock_us - echo.clock for echo, answer in zip(found, host.uno.answers, strict=True)]
    assert max(delays) - min(delays) < 30


def test_sweeps_go_to_and_fro_and_the_servo_has_its_pulse_before_each_ping(start: Callable[..., Host]) -> None:
    settings = QUICK | {"start": -1000, "stop": 850, "step": 400, "zero": 1450, "gain": -900, "together": 1}
    host = start(lambda sensor, *_: 300.0 + sensor, **settings)
    host.send(Sweeps(job=9, count=3))
    records = host.until_done()
    assert is_numbered(records)
    assert [type(record).__name__ for record in records if not isinstance(record, Echo)] == [
        *["Begin", "End"] * 3,
        "Done",
    ]
    assert [record.sweep for record in records if isinstance(record, Begin | End)] == [0, 0, 1, 1, 2, 2]
    there = [-1000, -600, -200, 200, 600]
    assert [echo.angle for echo in echoes(records)[::4]] == there + there[::-1] + there
    for echo, answer in zip(echoes(records), host.uno.answers, strict=True):
        assert echo.pulse == pytest.approx(1450 - 900 * echo.angle / 9000, abs=0.51)
        assert answer.pulse_us == pytest.approx(echo.pulse, abs=0.6)


def test_it_makes_the_same_pings_as_the_python_program(start: Callable[..., Host]) -> None:
    settings = QUICK | {"start": -95, "stop": 155, "step": 45, "gain": 100}

    class Sonar(Board):
        sensors = 4
        capabilities = ("servo",)

        def flights(self) -> list[int]:
            return [600]

    head = Head(Sonar())
    commands = [*(Set(name=name, value=value) for name, value in settings.items()), Sweeps(job=1, count=2)]
    head.receive(b"".join(map(encode, commands)))
    decoder = Decoder()
    expected = echoes([each for ms in range(900) for each in decoder.feed(head.advance(1000 * ms))])
    host = start(**settings)
    host.send(Sweeps(job=1, count=2))
    found = echoes(host.until_done())
    assert len(found) == 48
    assert [(echo.number, echo.sensor, echo.pulse, echo.angle) for echo in found] == [
        (echo.number, echo.sensor, echo.pulse, echo.angle) for echo in expected
    ]


def test_the_servo_settles_after_a_jump_and_keeps_the_dwell(start: Callable[..., Host]) -> None:
    host = start(**QUICK | {"together": 1, "settle": 200, "dwell": 40})
    before = host.uno.clock_us
    host.send(Sweeps(job=1, count=2))
    records = host.until_done()
    begins = [record.clock for record in records if isinstance(record, Begin)]
    assert 200_000 < begins[0] - before < 215_000
    clocks = [echo.clock for echo in echoes(records)[::4]]
    assert all(40_000 <= later - sooner < 42_000 for sooner, later in pairwise(clocks))


def test_sensors_fire_one_after_the_other_with_the_guard_time(start: Callable[..., Host]) -> None:
    host = start(**QUICK | {"guard": 15})
    host.send(Sweeps(job=1, count=1))
    found = echoes(host.until_done())
    assert [echo.sensor for echo in found] == [0, 1, 2, 3] * 7
    # Also from step to step.
    assert all(15_000 <= later.clock - sooner.clock < 16_500 for sooner, later in pairwise(found))


def test_sensors_fire_together(start: Callable[..., Host]) -> None:
    # Echoes that end within a few microseconds are the hardest to time.
    host = start(lambda sensor, *_: 1500.0 + 4 * sensor, **QUICK | {"together": 1})
    host.send(Sweeps(job=1, count=1))
    found = echoes(host.until_done())
    steps = [found[at : at + 4] for at in range(0, len(found), 4)]
    assert all(len({(echo.clock, echo.pulse) for echo in step}) == 1 for step in steps)
    assert all(echo.flight == pytest.approx(1500 + 4 * echo.sensor, abs=12) for echo in found)
    ends = {answer.sensor: answer.clock_us for answer in host.uno.answers}
    assert max(ends.values()) - min(ends.values()) < 5


def test_faulty_and_silent_sensors_are_distinguished(start: Callable[..., Host]) -> None:
    answers = {0: 1000.0, 1: None, 2: DISCONNECTED, 3: DISCONNECTED}
    host = start(lambda sensor, *_: answers[sensor], **QUICK | {"step": 600, "listen": 20, "guard": 20, "dwell": 100})
    host.uno.set_pin("PC3", is_high=True)
    host.send(Sweeps(job=1, count=1))
    found = echoes(host.until_done())
    assert [echo.flight == pytest.approx(1000, abs=8) for echo in found] == [True, False, False, False] * 2
    assert [echo.flight for echo in found if echo.sensor] == [0, -1, -1] * 2


def test_a_sensor_that_detects_nothing_has_time_to_recover(start: Callable[..., Host]) -> None:
    # Its echo pin is high for 38 ms, and it ignores triggers meanwhile.
    host = start(lambda sensor, *_: None if sensor == 2 else 600.0, **QUICK | {"together": 1})
    host.send(Sweeps(job=1, count=1))
    found = echoes(host.until_done())
    assert [echo.flight for echo in found if echo.sensor == 2] == [0] * 7
    assert len(host.uno.answers) == 28
    # One whose pin never goes low again takes that time once.
    host = start(lambda sensor, *_: 1e9 if sensor == 2 else 600.0, **QUICK | {"together": 1})
    host.send(Sweeps(job=1, count=1))
    found = echoes(host.until_done())
    assert [echo.flight for echo in found if echo.sensor == 2] == [0, *[-1] * 6]
    assert found[-1].clock - found[0].clock < 300_000


def test_settings_are_kept_and_refused_by_the_rules(start: Callable[..., Host]) -> None:
    host = start()
    assert host.ask(Config(), wait=80) == [Value(name=name, value=value) for name, value in DEFAULTS.items()]
    for name, value in {"start": 4500, "stop": -4500, "step": 9, "gain": 0, "dwell": 1001, "window": 25}.items():
        assert host.ask(Set(name=name, value=value)) == [Refused(command="set", reason="range")]
    assert host.ask(Set(name="speed", value=1)) == [Refused(command="set", reason="unknown")]
    host.set(gain=-1200, start=-9000, window=24)
    # The servo would need pulses of 300 to 2100 us.
    assert host.ask(Sweeps(job=1, count=1)) == [Refused(command="sweep", reason="range")]
    changed = DEFAULTS | {"gain": -1200, "start": -9000, "window": 24}
    assert host.ask(Config(), wait=80) == [Value(name=name, value=value) for name, value in changed.items()]


def test_settings_cannot_change_during_a_sweep(start: Callable[..., Host]) -> None:
    host = start(**QUICK)
    host.ask(Sweeps(job=1, count=0))
    assert Refused(command="set", reason="busy") in host.ask(Set(name="step", value=50))
    assert Accepted(command="stop", job=1) in host.ask(Stop(job=1), wait=40)
    host.set(step=50)


def test_commands_can_be_repeated(start: Callable[..., Host]) -> None:
    host = start(**QUICK)
    accepted = Accepted(command="sweep", job=5)
    messages = host.ask(Sweeps(job=5, count=1), Sweeps(job=5, count=1), wait=12)
    assert messages.count(accepted) == 2
    messages += host.ask(Sweeps(job=5, count=1), Stop(job=4), wait=300)
    assert is_numbered([message for message in messages if isinstance(message, Record)])
    assert len(echoes(messages)) == 28
    # Also after the job: a late repetition does not begin it again.
    assert host.ask(Sweeps(job=5, count=1), Stop(job=5), wait=40) == [
        accepted,
        Accepted(command="stop", job=5),
    ]


def test_stop_ends_the_job_after_the_current_ping(start: Callable[..., Host]) -> None:
    host = start(**QUICK)
    host.ask(Sweeps(job=1, count=0), wait=100)
    messages = host.ask(Stop(job=1), wait=60)
    assert isinstance(messages[-1], Done)
    assert not any(isinstance(message, End) for message in messages[-3:])
    assert host.run(100) == []


def test_a_new_job_ends_the_one_before(start: Callable[..., Host]) -> None:
    host = start(**QUICK)
    host.ask(Sweeps(job=1, count=0), wait=50)
    host.send(Sweeps(job=2, count=1))
    messages = host.run(400)
    new = [message for message in messages if isinstance(message, Record) and message.job == 2]
    assert is_numbered(new)
    assert isinstance(new[-1], Done)
    assert len(echoes(new)) == 28
    assert all(echo.flight > 0 for echo in echoes(new))


def test_no_ping_is_made_while_the_window_is_full(start: Callable[..., Host]) -> None:
    host = start(**QUICK | {"window": 8})
    host.ask(Sweeps(job=1, count=1), wait=150)
    assert len(host.uno.answers) == 7
    host.ask(Ack(job=1, next=5), wait=30)
    assert len(host.uno.answers) == 12


def test_unacknowledged_records_come_again_until_they_are_acknowledged(start: Callable[..., Host]) -> None:
    host = start(**QUICK | {"window": 8})
    came = [message for message in host.ask(Sweeps(job=1, count=1), wait=300) if isinstance(message, Record)]
    assert [record.number for record in came][:24] == [*range(8)] * 3
    records = host.until_done(acknowledge=15)
    assert is_numbered(records)
    assert len(echoes(records)) == 28
    host.run(20)
    assert host.run(200) == []


def test_nothing_is_lost_on_a_line_that_damages_one_bit_in_a_thousand(start: Callable[..., Host]) -> None:
    host = start(**QUICK | {"window": 24, "together": 1})
    rng = np.random.default_rng(2)
    records: dict[int, Record] = {}
    is_accepted = False
    for _ in range(400):
        expected = next(number for number in range(1000) if number not in records)
        command = Ack(job=3, next=expected) if is_accepted else Sweeps(job=3, count=4)
        host.uno.write(with_wrong_bits(encode(command), 0.001, rng=rng))
        host.uno.run(10)
        for message in host.decoder.feed(with_wrong_bits(host.uno.read(), 0.001, rng=rng)):
            is_accepted |= isinstance(message, Accepted | Record)
            if isinstance(message, Record):
                assert records.setdefault(message.number, message) == message
        if any(isinstance(record, Done) for record in records.values()) and len(records) == max(records) + 1:
            break
    assert host.decoder.damaged > 10
    complete = [records[number] for number in sorted(records)]
    assert is_numbered(complete)
    assert [echo.sensor for echo in echoes(complete)] == [0, 1, 2, 3] * 28


def test_noise_is_never_answered(start: Callable[..., Host]) -> None:
    host = start()
    rng = random.Random(3)
    host.uno.write(rng.randbytes(400) + b"$ping,7*392F2A6B\n$jump*A7B30616\n$" + b"x" * 200 + b"\n")
    assert host.run(80) == []
    assert host.ask(Ping(token=1)) != []


def test_a_device_without_wheels_refuses_to_move(start: Callable[..., Host]) -> None:
    assert start().ask(Move(job=1)) == [Refused(command="move", reason="unknown")]


def test_a_reset_in_the_middle_of_a_sweep_forgets_job_and_settings(start: Callable[..., Host]) -> None:
    host = start(**QUICK | {"window": 24})
    host.ask(Sweeps(job=1, count=0), wait=60)
    host.uno.reset()
    messages = host.run(60)
    assert isinstance(messages[-1], Hello)
    (pong,) = host.ask(Ping(token=1))
    assert isinstance(pong, Pong)
    assert pong.job == 0
    assert pong.clock < 200_000
    assert host.ask(Config(), wait=80) == [Value(name=name, value=value) for name, value in DEFAULTS.items()]
    host.set(**QUICK)
    host.send(Sweeps(job=2, count=1))
    assert len(echoes(host.until_done())) == 28


def test_the_wrap_of_the_clock_disturbs_nothing(start: Callable[..., Host]) -> None:
    host = start(**QUICK)
    host.uno.set_clock(2**32 - 60_000)
    host.send(Sweeps(job=1, count=1))
    records = host.until_done()
    clocks = [record.clock for record in records]
    wraps = [at for at, (sooner, later) in enumerate(pairwise(clocks)) if later < sooner]
    assert len(wraps) == 1
    assert all((later - sooner) % 2**32 < 20_000 for sooner, later in pairwise(clocks))
    assert [echo.flight for echo in echoes(records)] == pytest.approx([600] * 28, abs=8)


def test_a_long_wait_for_acknowledgements_does_not_confuse_the_clock(start: Callable[..., Host]) -> None:
    host = start(**QUICK | {"window": 8})
    host.ask(Sweeps(job=1, count=1), wait=100)
    for quarter in range(1, 5):
        host.uno.set_clock(quarter * 2**30 - 1)
        host.run(5)
    assert len(echoes(host.until_done(acknowledge=15))) == 28


def test_a_full_serial_port_does_not_delay_the_pings(start: Callable[..., Host]) -> None:
    # 4 sensors in 5 ms make more records than the serial port can send.
    host = start(**QUICK | {"together": 1, "window": 0})
    host.send(Sweeps(job=1, count=2))
    records = host.until_done()
    assert is_numbered(records)
    assert [echo.flight for echo in echoes(records)] == pytest.approx([600] * 56, abs=8)


def test_the_thermometer_is_reported_after_the_beginning_of_a_sweep(rover: Path) -> None:
    host = Host(Uno(rover, flight=lambda *_: 700.0))
    host.uno.set_voltage("PC4", 0.5 + 0.01 * 21.5)
    (hello,) = host.run(15)
    assert isinstance(hello, Hello)
    assert (hello.sensors, hello.capabilities) == (2, "air-wheels")
    host.set(**QUICK)
    host.send(Sweeps(job=1, count=2))
    records = host.until_done()
    # Without a servo, each sensor fires once in a sweep.
    assert [type(record).__name__ for record in records] == [
        *["Begin", "Air", "Wheels", "Echo", "Echo", "Wheels", "End"] * 2,
        "Done",
    ]
    assert {(echo.pulse, echo.angle) for echo in echoes(records)} == {(0, 0)}
    temperatures = [record.temperature for record in records if isinstance(record, Air)]
    assert temperatures == pytest.approx([2150] * 2, abs=50)


def test_wheels_are_counted_while_they_turn(rover: Path) -> None:
    host = Host(Uno(rover, flight=lambda *_: 700.0))
    for name in ("PD6", "PD7", "PB3", "PB2"):
        host.uno.set_pin(name, is_high=False)
    host.run(15)
    assert Accepted(command="move", job=4) in host.ask(Move(job=4))
    messages: list[Message] = []
    # The left wheel turns forward, the right one backward.
    for state in [(1, 0), (1, 1), (0, 1), (0, 0)] * 30:
        for name, is_high in zip(("PD6", "PD7", "PB3", "PB2"), state + state, strict=True):
            host.uno.set_pin(name, is_high=bool(is_high))
        messages += host.run(1)
    messages += host.run(120)
    found = [message for message in messages if isinstance(message, Wheels)]
    assert 3 <= len(found) <= 4
    assert (found[-1].left, found[-1].right) == (120, -120)
    assert all(49_000 < later.clock - sooner.clock < 60_000 for sooner, later in pairwise(found))
    assert [type(message) for message in host.ask(Stop(job=4))] == [Accepted, Wheels, Done]


def test_a_program_talks_to_the_device_through_a_serial_port(start: Callable[..., Host]) -> None:
    host = start(**QUICK)
    with serial_port(host.uno) as name, Path(name).open("r+b", buffering=0) as port:
        port.write(encode(Sweeps(job=1, count=1)))
        messages: list[Message] = []
        while not (messages and isinstance(messages[-1], Done)):
            messages += host.decoder.feed(port.read(64))
    assert messages[0] == Accepted(command="sweep", job=1)
    assert len(echoes(messages)) == 28
