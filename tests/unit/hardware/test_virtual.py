"""The simulated device: its echoes, its drives, its faults, and its ports."""

import _thread
import os
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from echoplan.cli.device import run
from echoplan.errors import InputError, InvalidValueError
from echoplan.geometry import wrap
from echoplan.hardware.faulty import Faults, VirtualDevice, parse_faults
from echoplan.hardware.messages import Done, Echo, Hello, Identify, Message, Move, Set, Sweeps, Wheels
from echoplan.hardware.protocol import Decoder, encode
from echoplan.hardware.readings import Track, Wheelbase, driven, ranges_of
from echoplan.hardware.serving import PtyEndpoint, TcpEndpoint, serve
from echoplan.hardware.virtual import COUNTS_PER_METRE, WHEEL_BASE, VirtualBoard
from echoplan.io import builtin_rig, builtin_route, builtin_world
from echoplan.simulation import Simulation, SimulationSettings
from helpers.typed import echoplan

STATIONS = builtin_route("square").map_from_base
EXACT = SimulationSettings(jitter=0.0)


def board_of(*, rig: str = "rotary-array", seed: int = 0, faults: Faults | None = None) -> VirtualBoard:
    faults = faults or Faults()
    return VirtualBoard(
        world=builtin_world("square"),
        rig=builtin_rig(rig),
        stations=STATIONS,
        settings=EXACT if seed == 0 else None,
        seed=seed,
        silent=faults.silent,
        stuck=faults.stuck,
    )


def device_of(*, rig: str = "rotary-array", seed: int = 0, faults: Faults | None = None) -> VirtualDevice:
    return VirtualDevice(board_of(rig=rig, seed=seed, faults=faults), faults=faults, seed=seed)


class Host:
    """A host that sends commands and returns the answers, a millisecond at a time."""

    def __init__(self, device: VirtualDevice) -> None:
        self.device = device
        self.decoder = Decoder()
        self.clocks = [0]

    def bytes_after(self, *messages: Message, milliseconds: int) -> bytes:
        self.device.receive(b"".join(map(encode, messages)))
        self.clocks[0] += 1000 * milliseconds
        return b"".join(self.device.advance(self.clocks[0] - 1000 * left) for left in range(milliseconds, 0, -1))

    def ask(self, *messages: Message, milliseconds: int) -> list[Message]:
        return list(self.decoder.feed(self.bytes_after(*messages, milliseconds=milliseconds)))


def settings(**values: int) -> list[Message]:
    return [Set(name=name, value=value) for name, value in values.items()]


def test_a_sweep_reads_what_the_simulator_makes_of_the_first_station() -> None:
    rig = builtin_rig("rotary-array")
    simulation = Simulation(world=builtin_world("square"), rig=rig, route=builtin_route("square"), settings=EXACT)
    sweep = next(iter(simulation))
    messages = Host(device_of()).ask(*settings(together=1, settle=0), Sweeps(job=1, count=1), milliseconds=2400)
    echoes = [each for each in messages if isinstance(each, Echo)]
    assert [each.sensor for each in echoes] == sweep.sensor_ids.tolist()
    np.testing.assert_allclose([each.angle for each in echoes], 100 * np.degrees(sweep.servo_angles), atol=0.6)
    ranges = ranges_of([each.flight for each in echoes], [each.sensor for each in echoes], rig=rig)
    # The simulator's servo turns while a ping is in the air, and that of the device stands still.
    detected = np.isfinite(ranges) & np.isfinite(sweep.ranges)
    assert np.mean(np.isfinite(ranges) == np.isfinite(sweep.ranges)) > 0.97
    assert np.quantile(np.abs(ranges[detected] - sweep.ranges[detected]), 0.95) < 0.006


def test_the_same_seed_sends_the_same_bytes() -> None:
    def sent(seed: int) -> bytes:
        device = device_of(seed=seed, faults=Faults(noise=0.001))
        return Host(device).bytes_after(*settings(settle=0), Sweeps(job=1, count=0), milliseconds=300)

    assert sent(1) == sent(1)
    assert sent(1) != sent(2)


def test_sensors_that_fire_together_detect_each_other_and_those_that_fire_alone_do_not() -> None:
    board = board_of()

    def flights(sensors: list[int], clock: int) -> list[int]:
        board.advance(clock)
        board.fire(sensors, 25_000)
        board.advance(clock + 30_000)
        found = board.flights()
        assert found is not None
        return found

    alone, together = [], []
    for step in range(60):
        board.servo(1000 + 16 * step)
        clock = 10_000_000 * (step + 1)
        alone += [flights([sensor], clock + 1_000_000 * sensor)[0] for sensor in range(4)]
        together += flights([0, 1, 2, 3], clock + 5_000_000)
    is_detected = (np.array(alone) > 0) & (np.array(together) > 0)
    differences = (np.array(together) - np.array(alone))[is_detected]
    assert np.mean(differences < -300) > 0.03
    assert np.mean(differences > 300) < 0.03


def test_sixteen_sensors_are_too_many() -> None:
    with pytest.raises(InvalidValueError, match="at most 8 sensors, and the rig has 16"):
        board_of(rig="ring-16")


def test_dead_reckoning_from_the_counts_finds_every_station() -> None:
    host = Host(device_of())
    wheels = Wheelbase(tick=1 / COUNTS_PER_METRE, width=WHEEL_BASE)
    track = Track(pose=STATIONS[0])
    for number, station in enumerate(STATIONS[1:], start=1):
        records = host.ask(Move(job=number), milliseconds=15_000)
        assert isinstance(records[-1], Done)
        for each in records:
            track = driven(track, each, wheels=wheels) if isinstance(each, Wheels) else track
        np.testing.assert_allclose(host.device.board.map_from_base, station, atol=1e-12)
        np.testing.assert_allclose(track.pose[:2], station[:2], atol=1.5e-3)
        np.testing.assert_allclose(wrap(track.pose[2] - station[2]), 0.0, atol=5e-4)
    # At the last station there is nowhere to go.
    records = host.ask(Move(job=99), milliseconds=100)
    assert isinstance(records[-1], Done)
    assert {(each.left, each.right) for each in records if isinstance(each, Wheels)} == {host.device.board.wheels()}


def test_a_drive_that_was_interrupted_goes_on_to_the_same_station_and_a_reset_zeroes_the_counts() -> None:
    host = Host(device_of())
    host.ask(Move(job=1), milliseconds=1500)
    assert host.device.board.is_driving
    before = host.device.board.map_from_base
    host.device.board.reset()
    assert host.device.board.wheels() == (0, 0)
    np.testing.assert_array_equal(host.device.board.map_from_base, before)
    host.ask(Move(job=2), milliseconds=15_000)
    np.testing.assert_allclose(host.device.board.map_from_base, STATIONS[1])


def test_faults_are_read_and_refused_as_they_are_typed() -> None:
    assert parse_faults("", sensors=4) == Faults()
    assert parse_faults("resets,noise,unplug,silent,stuck", sensors=4) == Faults(
        noise=0.01, resets=True, unplug=True, silent=0, stuck=3
    )
    assert parse_faults("noise=0.001, silent=2", sensors=4) == Faults(noise=0.001, silent=2)
    for text in ("nose", "silent=4", "silent=1.5", "noise=x", "noise=0.6"):
        with pytest.raises(InputError, match="--faults"):
            parse_faults(text, sensors=4)


def test_a_silent_sensor_never_detects_anything_and_a_stuck_one_is_faulty() -> None:
    host = Host(device_of(faults=Faults(silent=0, stuck=3)))
    messages = host.ask(*settings(settle=0), Sweeps(job=1, count=0), milliseconds=1000)
    echoes = [each for each in messages if isinstance(each, Echo)]
    assert {each.flight for each in echoes if each.sensor == 0} == {0}
    assert {each.flight for each in echoes if each.sensor == 3} == {-1}
    assert any(each.flight > 0 for each in echoes)


def test_noise_damages_lines_in_both_directions() -> None:
    host = Host(device_of(faults=Faults(noise=0.01)))
    hellos = [each for _ in range(100) for each in host.ask(Identify(), milliseconds=1) if isinstance(each, Hello)]
    # A line of 17 characters comes through with a probability of a quarter, the longer answer with that of 2 %.
    assert host.device.head.damaged > 50
    assert host.decoder.damaged > 10
    assert len(hellos) < 10


def test_a_device_resets_and_vanishes_at_random_moments() -> None:
    host = Host(device_of(faults=Faults(resets=True, unplug=True)))
    messages: list[Message] = []
    plugged = []
    for _ in range(1000):
        messages += host.ask(milliseconds=100)
        plugged.append(host.device.is_plugged)
    assert 4 < sum(isinstance(each, Hello) for each in messages) < 20
    away = np.diff(np.array(plugged).astype(int))
    assert 3 < np.count_nonzero(away == -1) < 20
    assert 0.8 < np.mean(plugged) < 0.97


@contextmanager
def served(device: VirtualDevice, port: PtyEndpoint | TcpEndpoint, *, speed: float = 50.0) -> Iterator[None]:
    over = threading.Event()
    thread = threading.Thread(target=lambda: serve(device, port, speed=speed, is_over=over.is_set))
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()
        port.close()


def test_it_can_be_reached_at_a_pseudo_terminal_that_comes_back_under_its_name(tmp_path: Path) -> None:
    link = tmp_path / "port"
    device = device_of(faults=Faults(unplug=True))
    endpoint = PtyEndpoint(link=link)
    assert endpoint.address == f"serial://{link}"
    hellos = lost = 0
    until = time.monotonic() + 10
    with served(device, endpoint):
        while (hellos < 20 or not lost) and time.monotonic() < until:
            try:
                file = os.open(link, os.O_RDWR | os.O_NOCTTY)
            except OSError:
                lost += 1
                time.sleep(0.005)
                continue
            with os.fdopen(file, "r+b", buffering=0) as port:
                try:
                    port.write(encode(Identify()))
                    hellos += b"$hello,1," in port.read(200)
                except OSError:
                    lost += 1
    assert hellos >= 20
    assert lost
    assert not link.is_symlink()


def test_it_can_be_reached_over_tcp_by_one_host_after_the_other() -> None:
    endpoint = TcpEndpoint(0)
    number = int(endpoint.address.rpartition(":")[2])
    with served(device_of(), endpoint):
        for _ in range(2):
            with socket.create_connection(("localhost", number), timeout=5) as host:
                host.sendall(encode(Identify()))
                assert host.recv(200).startswith(b"$hello,1,")


def test_a_port_that_is_taken_is_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as other:
        number = other.getsockname()[1]
        with pytest.raises(InputError, match=f"--tcp {number}: .*use.*; choose another port"):
            TcpEndpoint(number)


def test_the_command_serves_a_device_until_it_is_interrupted(capsys: pytest.CaptureFixture[str]) -> None:
    with socket.create_server(("127.0.0.1", 0)) as free:
        number = free.getsockname()[1]
    answers: list[bytes] = []

    def talk() -> None:
        try:
            with connected(number) as host:
                host.sendall(encode(Identify()))
                answers.append(host.recv(200))
        finally:
            _thread.interrupt_main()

    thread = threading.Thread(target=talk)
    thread.start()
    run("square", rig="hc-sr04-servo", tcp=number)
    thread.join()
    assert b",simulated,1,255,servo-air-wheels-drive*" in answers[0]
    assert capsys.readouterr().out == (
        f"Simulated device: echoplan record tcp://localhost:{number} --rig hc-sr04-servo\n"
    )


def connected(number: int) -> socket.socket:
    until = time.monotonic() + 20
    while True:
        try:
            return socket.create_connection(("localhost", number), timeout=5)
        except ConnectionRefusedError:
            assert time.monotonic() < until
            time.sleep(0.02)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--rig", "ring-16"], "at most 8 sensors, and the rig has 16"),
        (["--faults", "nose"], "'nose' is unknown; choose from resets, noise, unplug, silent, stuck"),
        (["--pty", "--tcp", "4000"], "leave out one of them"),
    ],
)
def test_the_command_refuses_what_cannot_be(words: list[str], message: str) -> None:
    done = echoplan("device", "square", *words)
    assert done.status == 2
    assert message in done.err
