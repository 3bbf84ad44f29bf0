"""The device's side of the protocol, in conversation with the host's side."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from echoplan.hardware.head import FIRMWARE, SETTINGS, Board, Head, line_of, read_command
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
from echoplan.version import __version__

LINES = Path(__file__).parents[2] / "golden" / "protocol" / "lines.tsv"
MILLISECOND = 1000


class Bench(Board):
    """A board with four sensors on a servo that answers at once, and notes what was done to it."""

    name = "bench"
    sensors = 4
    capabilities = ("servo", "air", "wheels", "drive")
    tick, base = 50, 2000

    def __init__(self, *, flights: tuple[int, ...] = (1000, 2000, 0, -1), delay: int = 0) -> None:
        self.answers = flights
        self.delay = delay
        self.fired: list[tuple[int, list[int]]] = []
        self.turned: list[tuple[int, int]] = []
        self.resting: list[int] = []
        self.clocks = [0]
        self.arrival = [0]

    def advance(self, clock_us: int) -> None:
        self.clocks[0] = clock_us

    def servo(self, pulse_us: int) -> None:
        self.turned.append((self.clocks[0], pulse_us))

    def fire(self, sensors: list[int], listen_us: int) -> None:
        self.fired.append((self.clocks[0], sensors))

    def recovering(self) -> list[int]:
        return self.resting

    def flights(self) -> list[int] | None:
        clock, sensors = self.fired[-1]
        return [self.answers[sensor] for sensor in sensors] if self.clocks[0] - clock >= self.delay else None

    def wheels(self) -> tuple[int, int]:
        on_the_way = min(self.clocks[0], self.arrival[0])
        return on_the_way // 1000, -on_the_way // 1000

    def depart(self) -> None:
        self.arrival[0] = self.clocks[0] + 210 * MILLISECOND

    def has_arrived(self) -> bool:
        return self.clocks[0] >= self.arrival[0]

    def halt(self) -> None:
        self.arrival[0] = min(self.arrival[0], self.clocks[0])


class Conversation:
    """A device and the little of a host that it takes to test it."""

    def __init__(self, board: Board, *, clock: int = 0, **settings: int) -> None:
        self.head = Head(board)
        self.decoder = Decoder()
        self.clocks = [clock]
        self.run(1)
        for name, value in settings.items():
            assert Value(name=name, value=value) in self.say(Set(name=name, value=value))

    def say(self, *messages: Message) -> list[Message]:
        """Send commands, and return what comes within a millisecond."""
        self.head.receive(b"".join(map(encode, messages)))
        return self.run(1)

    def run(self, milliseconds: int) -> list[Message]:
        """Let time pass."""
        return [message for _ in range(milliseconds) for message in self.decoder.feed(self.tick())]

    def tick(self) -> bytes:
        """Let a millisecond pass."""
        self.clocks[0] += MILLISECOND
        return self.head.advance(self.clocks[0])


def of_kind(kind: Any, messages: list[Message]) -> list[Any]:
    return [message for message in messages if isinstance(message, kind)]


def test_it_reads_and_writes_the_shared_lines() -> None:
    for row in LINES.read_text(encoding="ascii").rstrip("\n").split("\n")[1:]:
        sender, payload, line = row.split("\t")
        sent = line.replace("\\r", "\r").encode("ascii")
        if sender == "host":
            assert ",".join(read_command(sent)) == payload.strip("-"), line
        elif payload != "-":
            assert line_of(payload) == sent + b"\n"


def test_it_introduces_itself_after_a_reset_and_when_asked() -> None:
    hello = Hello(
        protocol=1, firmware=__version__, board="bench", sensors=4, window=64, capabilities="servo-air-wheels-drive"
    )
    assert __version__ == FIRMWARE
    head = Head(Bench())
    assert list(Decoder().feed(head.advance(5))) == [hello]
    head.receive(encode(Identify()))
    assert list(Decoder().feed(head.advance(6))) == [hello]


def test_a_board_with_nothing_but_sensors_says_so() -> None:
    (hello,) = Decoder().feed(Head(Board()).advance(0))
    assert isinstance(hello, Hello)
    assert hello.capabilities == "none"


def test_it_reports_all_settings() -> None:
    values = of_kind(Value, Conversation(Bench()).say(Config()))
    assert [each.name for each in values] == [name for name, *_ in SETTINGS]
    assert {each.name: each.value for each in values} == {
        "start": -4500,
        "stop": 4500,
        "step": 100,
        "zero": 1500,
        "gain": 1000,
        "dwell": 25,
        "guard": 25,
        "together": 0,
        "settle": 500,
        "listen": 25,
        "tick": 50,
        "base": 2000,
        "window": 0,
    }


@pytest.mark.parametrize(
    ("name", "value", "reason"),
    [
        ("start", 4500, "range"),
        ("stop", -4500, "range"),
        ("step", 9, "range"),
        ("gain", 0, "range"),
        ("gain", 1201, "range"),
        ("window", 65, "range"),
        ("colour", 1, "unknown"),
    ],
)
def test_it_refuses_a_setting_that_cannot_be(name: str, value: int, reason: str) -> None:
    conversation = Conversation(Bench())
    before = dict(conversation.head.settings)
    assert conversation.say(Set(name=name, value=value)) == [Refused(command="set", reason=reason)]
    assert conversation.head.settings == before


def test_it_refuses_settings_while_it_sweeps_and_takes_them_afterwards() -> None:
    conversation = Conversation(Bench(), settle=0)
    conversation.say(Sweeps(job=7, count=0))
    assert Refused(command="set", reason="busy") in conversation.say(Set(name="step", value=50))
    conversation.say(Stop(job=7))
    conversation.run(30)
    assert conversation.say(Set(name="step", value=50)) == [Value(name="step", value=50)]


def test_it_refuses_a_sweep_for_which_the_servo_would_run_against_its_stop() -> None:
    conversation = Conversation(Bench(), gain=1200, stop=9000)
    assert conversation.say(Sweeps(job=7, count=1)) == [Refused(command="sweep", reason="range")]


def test_it_answers_pings_with_job_and_clock() -> None:
    # It takes the time of the last advance, which was half a millisecond before the clock wraps.
    conversation = Conversation(Bench(), clock=2**32 - 1500)
    assert conversation.say(Ping(token=9)) == [Pong(token=9, job=0, clock=2**32 - 500)]
    conversation.say(Sweeps(job=7, count=1))
    (pong,) = of_kind(Pong, conversation.say(Ping(token=10)))
    assert pong.job == 7
    assert pong.clock == 1500


def test_a_sweep_fires_one_sensor_after_the_other_at_every_angle_to_and_fro() -> None:
    board = Bench()
    conversation = Conversation(board, start=-200, stop=250, step=200, dwell=30, guard=10, settle=20)
    records = of_kind(Record, [*conversation.say(Sweeps(job=7, count=2)), *conversation.run(300)])
    assert [each.number for each in records] == list(range(len(records)))
    assert [type(each) for each in records[:3]] == [Begin, Air, Wheels]
    assert [type(each) for each in records[-3:]] == [Wheels, End, Done]
    echoes = of_kind(Echo, list(records))
    angles = [-200, 0, 200, 200, 0, -200]
    assert [each.angle for each in echoes] == list(np.repeat(angles, 4))
    assert [each.pulse for each in echoes[::4]] == [1478, 1500, 1522, 1522, 1500, 1478]
    assert [each.sensor for each in echoes] == [0, 1, 2, 3] * 6
    assert [each.flight for each in echoes] == [1000, 2000, 0, -1] * 6
    # Four sensors 10 ms apart take longer than the 30 ms of a step.
    assert set(np.diff([each.clock for each in echoes])) == {10 * MILLISECOND}
    assert echoes[0].clock - board.turned[0][0] == 20 * MILLISECOND


def test_sensors_that_fire_together_do_so_once_a_step() -> None:
    board = Bench(delay=12 * MILLISECOND)
    conversation = Conversation(board, start=0, stop=200, dwell=20, together=1, settle=0)
    echoes = of_kind(Echo, [*conversation.say(Sweeps(job=7, count=1)), *conversation.run(100)])
    assert [each.sensor for each in echoes] == [0, 1, 2, 3] * 3
    assert [each.clock - echoes[0].clock for each in echoes[::4]] == [0, 20 * MILLISECOND, 40 * MILLISECOND]
    assert board.fired == [(each.clock, [0, 1, 2, 3]) for each in echoes[::4]]
    # The servo turns as soon as the echoes have come.
    assert board.turned[1][0] == board.fired[0][0] + 12 * MILLISECOND


def test_without_a_servo_a_sweep_fires_each_sensor_once() -> None:
    conversation = Conversation(Board())
    records = of_kind(Record, [*conversation.say(Sweeps(job=7, count=2)), *conversation.run(60)])
    assert [type(each) for each in records] == [Begin, Echo, End, Begin, Echo, End, Done]
    assert {(each.pulse, each.angle) for each in of_kind(Echo, list(records))} == {(0, 0)}


def test_a_sensor_is_not_triggered_before_it_has_recovered() -> None:
    board = Bench()
    conversation = Conversation(board, settle=0)
    board.resting.append(1)
    conversation.say(Sweeps(job=7, count=1))
    conversation.run(70)
    assert [sensors for _, sensors in board.fired] == [[0]]
    board.resting.clear()
    conversation.run(30)
    assert [sensors for _, sensors in board.fired] == [[0], [1], [2]]


def test_an_echo_later_than_it_listens_is_none() -> None:
    conversation = Conversation(Bench(flights=(25_001, 25_000, 99_999, -1)), settle=0)
    echoes = of_kind(Echo, [*conversation.say(Sweeps(job=7, count=1)), *conversation.run(120)])
    assert [each.flight for each in echoes[:4]] == [0, 25_000, 0, -1]


def test_a_repeated_command_changes_nothing() -> None:
    conversation = Conversation(Bench(), settle=0)
    conversation.say(Sweeps(job=7, count=0))
    conversation.run(60)
    answers = conversation.say(Sweeps(job=7, count=0), Sweeps(job=7, count=0))
    assert of_kind(Accepted, answers) == [Accepted(command="sweep", job=7)] * 2
    assert not of_kind(Begin, [*answers, *conversation.run(60)])
    conversation.say(Stop(job=7))
    conversation.run(30)
    assert conversation.say(Sweeps(job=7, count=0)) == [Accepted(command="sweep", job=7)]
    assert not conversation.run(100)


def test_stop_ends_the_job_after_the_ping_and_stop_of_another_does_nothing() -> None:
    conversation = Conversation(Bench(delay=10 * MILLISECOND), settle=0)
    conversation.say(Sweeps(job=7, count=0))
    conversation.run(52)
    assert not of_kind(Done, [*conversation.say(Stop(job=6)), *conversation.run(40)])
    conversation.run(10)
    records = of_kind(Record, [*conversation.say(Stop(job=7)), *conversation.run(100)])
    assert [type(each) for each in records] == [Echo, Done]


def test_a_new_job_replaces_the_running_one() -> None:
    conversation = Conversation(Bench(), settle=0, window=8)
    conversation.say(Sweeps(job=7, count=0))
    conversation.run(120)
    records = of_kind(Record, [*conversation.say(Sweeps(job=8, count=1)), *conversation.run(500)])
    assert {each.job for each in records} == {8}
    assert records[0].number == 0


def test_a_drive_reports_the_wheels_and_ends_by_itself() -> None:
    conversation = Conversation(Bench())
    records = of_kind(Record, [*conversation.say(Move(job=7)), *conversation.run(300)])
    assert [type(each) for each in records] == [Wheels] * 6 + [Done]
    elapsed = [(each.clock - records[0].clock) // MILLISECOND for each in records[:-1]]
    assert elapsed == [0, 50, 100, 150, 200, 210]
    lefts = [each.left for each in of_kind(Wheels, list(records))]
    assert lefts == sorted(lefts)
    assert lefts[-1] - lefts[0] == 210


def test_a_stopped_drive_reports_where_it_stopped() -> None:
    board = Bench()
    conversation = Conversation(board)
    conversation.say(Move(job=7))
    conversation.run(30)
    records = of_kind(Record, conversation.say(Stop(job=7)))
    assert [type(each) for each in records] == [Wheels, Done]
    assert records[0].clock == conversation.clocks[0] == board.arrival[0]


def test_a_board_without_wheels_refuses_to_move() -> None:
    assert Conversation(Board()).say(Move(job=7)) == [Refused(command="move", reason="unknown")]


def test_the_clock_of_records_wraps() -> None:
    conversation = Conversation(Bench(), clock=2**32 - 60 * MILLISECOND, settle=0)
    echoes = of_kind(Echo, [*conversation.say(Sweeps(job=7, count=1)), *conversation.run(200)])
    steps = np.diff([each.clock for each in echoes])
    assert np.count_nonzero(steps < 0) == 1
    assert set(steps % 2**32) == {25 * MILLISECOND}


def test_without_a_window_nothing_is_repeated() -> None:
    conversation = Conversation(Board())
    conversation.say(Sweeps(job=7, count=1))
    conversation.run(3)
    assert not conversation.run(500)


def test_it_waits_while_the_window_is_full_and_repeats_in_order_until_acknowledged() -> None:
    board = Bench()
    conversation = Conversation(board, settle=0, window=6)
    first = of_kind(Record, [*conversation.say(Sweeps(job=7, count=1)), *conversation.run(90)])
    assert [each.number for each in first] == [0, 1, 2, 3, 4, 5]
    again = of_kind(Record, conversation.run(50))
    assert again == first
    conversation.say(Ack(job=6, next=6), Ack(job=7, next=99))
    assert of_kind(Record, conversation.run(50)) == first
    conversation.say(Ack(job=7, next=5))
    assert [each.number for each in of_kind(Record, conversation.run(40))] == [6, 7]


def lossy(rng: np.random.Generator) -> Callable[[bytes], bytes]:
    """Return a line that loses, repeats and damages what it carries."""

    def carry(data: bytes) -> bytes:
        lines = []
        for line in data.splitlines(keepends=True):
            fate = rng.random()
            if fate < 0.1:
                continue
            place = int(rng.integers(len(line)))
            damaged = line[:place] + bytes([line[place] ^ 1 << int(rng.integers(8))]) + line[place + 1 :]
            lines += [damaged] if fate < 0.2 else [line, line] if fate < 0.3 else [line]
        return b"".join(lines)

    return carry


def delivered(conversation: Conversation, carry: Callable[[bytes], bytes], *, window: int) -> Iterator[Record]:
    """Yield the records of job 7 in order, as a host puts them together from a bad line."""
    arrived: dict[int, Record] = {}
    following = 0
    while True:
        data = carry(conversation.tick())
        for record in of_kind(Record, list(conversation.decoder.feed(data))):
            assert arrived.setdefault(record.number, record) == record
            assert record.number < following + window + 4
        while following in arrived:
            yield arrived[following]
            following += 1
        conversation.head.receive(carry(encode(Ack(job=7, next=following))))
        if following and isinstance(arrived[following - 1], Done):
            return


def test_every_record_arrives_once_and_unchanged_over_a_bad_line() -> None:
    def converse() -> Conversation:
        conversation = Conversation(Bench(), settle=0, dwell=5, guard=5, window=16)
        conversation.say(Sweeps(job=7, count=2))
        return conversation

    clean = list(delivered(converse(), bytes, window=16))
    conversation = converse()
    poor = list(delivered(conversation, lossy(np.random.default_rng(5)), window=16))
    assert conversation.decoder.damaged > 20
    assert conversation.head.damaged > 20

    def without_time(records: list[Record]) -> list[list[object]]:
        return [[getattr(each, name) for name in each.__slots__ if name != "clock"] for each in records]

    assert [type(each) for each in poor] == [type(each) for each in clean]
    assert without_time(poor) == without_time(clean)
    assert all(np.diff([each.clock for each in poor]) >= 0)


def test_a_device_that_was_reset_has_no_job_and_its_default_settings() -> None:
    board = Bench()
    conversation = Conversation(board, settle=0, step=50)
    conversation.say(Sweeps(job=7, count=0))
    conversation.head = Head(board)
    assert [type(each) for each in conversation.run(200)] == [Hello]
    (pong,) = of_kind(Pong, conversation.say(Ping(token=1)))
    assert pong.job == 0
    assert conversation.head.settings["step"] == 100


def test_noise_is_counted_and_never_answered() -> None:
    conversation = Conversation(Bench())
    rng = np.random.default_rng(3)
    for _ in range(50):
        conversation.head.receive(rng.bytes(200))
    conversation.head.receive(b"\n")
    assert not conversation.run(10)
    assert conversation.head.damaged > 10
    assert conversation.say(Ping(token=1))


def test_a_command_arrives_in_pieces_and_after_endless_noise() -> None:
    conversation = Conversation(Bench())
    line = b"x" * 5000 + encode(Ping(token=1))
    for place in range(0, len(line), 7):
        conversation.head.receive(line[place : place + 7])
    assert [type(each) for each in conversation.run(1)] == [Pong]
