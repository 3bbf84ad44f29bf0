"""The driver of a device: complete sweeps, whatever the line does to its messages."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from echoplan.acoustics import Air
from echoplan.errors import InputError
from echoplan.hardware.driver import Device, device_settings
from echoplan.hardware.head import Head
from echoplan.hardware.port import Port
from echoplan.io import builtin_rig
from echoplan.model import Rig, Sweep
from helpers.devices import Cart, Line, Room, flight

RIG = builtin_rig("rotary-array")


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("time.sleep", lambda _: None)


def sweeps(line: Line, *, count: int = 2, rig: Rig = RIG) -> tuple[list[Sweep], dict[str, int]]:
    with Device("test", connect=line.connect) as device:
        made = list(device.sweeps(count, rig=rig))
        return made, dict(device.counts)


def check(made: list[Sweep], *, count: int = 2) -> None:
    """Check that sweeps are complete, run to and fro, and have the flights of the board."""
    assert len(made) == count
    for number, sweep in enumerate(made):
        angles = np.repeat(np.arange(-45, 46), 4)
        np.testing.assert_allclose(np.degrees(sweep.servo_angles), angles if number % 2 == 0 else angles[::-1])
        pulses = np.round(1500 + 1000 * np.degrees(sweep.servo_angles) / 90).astype(int)
        flights = [flight(pulse, sensor) for pulse, sensor in zip(pulses, sweep.sensor_ids, strict=True)]
        np.testing.assert_allclose(sweep.ranges, 0.5e-6 * np.array(flights) * Air().speed_of_sound, rtol=1e-3)
        assert sweep.temperature == 21.5
        assert (np.diff(sweep.stamps_ns) >= 0).all()


def test_a_device_makes_complete_sweeps_to_and_fro_while_its_clock_wraps() -> None:
    made, counts = sweeps(Line())
    check(made)
    assert not any(counts.values())


def test_wrong_bits_of_the_line_change_no_ping() -> None:
    line = Line(bit_errors=0.01, seed=1)
    made, counts = sweeps(line)
    check(made)
    assert counts["damaged lines"] > 1000


@pytest.mark.parametrize("where", [300, 700, 1100, 1400, 2000])
def test_a_sweep_that_a_reset_interrupts_is_made_again(where: int) -> None:
    made, counts = sweeps(Line(resets=(where,)))
    check(made[:1], count=1)
    assert len(made) == 2
    assert counts["interrupted sweeps"] == 1


@pytest.mark.parametrize("where", [300, 700, 1100, 1400, 2000])
def test_a_sweep_during_which_the_line_is_cut_is_continued(where: int) -> None:
    made, counts = sweeps(Line(cuts=(where, where + 2)))
    check(made)
    assert set(counts) == {"lost connections"}


def test_a_rig_with_more_sensors_than_the_device_is_refused() -> None:
    with pytest.raises(
        InputError, match="the device has 4 sensors, and the rig 'ring of sixteen' has a sensor 4; name a rig"
    ):
        sweeps(Line(), rig=builtin_rig("ring-16"))


def test_a_rig_without_one_of_the_sensors_of_the_device_is_refused() -> None:
    rig = replace(RIG, sensors=RIG.sensors[:3], firing=None)
    with pytest.raises(InputError, match="the device has 4 sensors, and the rig 'rotary array' has no sensor 3; name"):
        sweeps(Line(), rig=rig)


@pytest.mark.parametrize(("start", "stop"), [(-9000, -5000), (5000, 9000)])
def test_settings_are_changed_in_an_order_that_the_device_accepts(start: int, stop: int) -> None:
    line = Line()
    line.heads[0].settings.update(start=start, stop=stop)
    made, _ = sweeps(line, count=1)
    check(made, count=1)


def test_a_device_that_always_cuts_the_connection_is_given_up() -> None:
    with pytest.raises(InputError, match="test: the connection is lost at once; check that the device runs the firmw"):
        sweeps(Line(cuts=range(1000)))


def test_a_job_that_a_reset_deprived_of_its_settings_is_begun_again() -> None:
    class Forgetful(Line):
        def write(self, data: bytes) -> None:
            if b"$sweep" in data and not self.resets:
                self.resets.add(0)
                self.heads[:] = [Head(self.heads[0].board)]
            super().write(data)

    made, counts = sweeps(Forgetful(), count=1)
    check(made, count=1)
    assert not any(counts.values())


def test_damaged_lines_are_counted_once_however_often_a_connection_fails() -> None:
    line, refusals = Line(bit_errors=0.003, cuts=(700,), seed=1), [0]

    def connect(name: str) -> Port:
        refusals[0] += 1
        if 1 < refusals[0] < 50:
            raise OSError
        return line.connect(name)

    with Device("test", connect=connect) as device:
        check([*device.sweeps(1, rig=RIG)], count=1)
        counts = device.counts["damaged lines"]
    _, once = sweeps(Line(bit_errors=0.003, cuts=(700,), seed=1), count=1)
    assert refusals[0] == 50
    assert counts < 1.5 * once["damaged lines"]


def test_the_temperature_of_a_broken_thermometer_is_not_recorded() -> None:
    class Broken(Room):
        def temperature(self) -> int:
            return 8500

    made, _ = sweeps(Line(Broken()), count=1)
    assert np.isnan(made[0].temperature)


def test_the_settings_are_those_of_the_rig() -> None:
    assert device_settings(RIG) == {
        "guard": 25,
        "dwell": 25,
        "together": 1,
        "listen": 18,
        "start": -4500,
        "stop": 4500,
        "step": 100,
    }
    assert device_settings(builtin_rig("hc-sr04-servo")) == {
        "guard": 60,
        "dwell": 60,
        "together": 0,
        "listen": 24,
        "start": -9000,
        "stop": 9000,
        "step": 100,
    }


def wait_for(line: Line, now: float) -> None:
    """Wait until it is so late by the clock of the host [s]."""
    while line.now() < now:
        pass


def test_a_robot_is_pushed_until_somebody_says_that_it_is_there() -> None:
    line = Line(Cart())
    with Device("test", connect=line.connect) as device:
        for _ in range(2):
            began, before = line.now(), device.pose[0]
            device.push(partial(wait_for, line, began + 2.0))
            # A count each millisecond, of 0.1 mm.
            assert device.pose[0] - before == pytest.approx(0.1 * (line.now() - began), abs=0.02)
        assert device.pose[0] > 0.3


def test_a_reset_while_a_robot_is_pushed_is_an_error() -> None:
    line = Line(Cart(), resets=(900,))
    with Device("test", connect=line.connect) as device, pytest.raises(InputError, match="reset while the robot moved"):
        device.push(partial(wait_for, line, 1.8))


def test_a_reset_between_two_jobs_does_not_move_the_robot() -> None:
    line = Line(Cart())
    with Device("test", connect=line.connect) as device:
        next(iter(device.sweeps(1, rig=RIG)))
        before = device.pose[0]
        # The device is reset while it waits: its wheels are counted from another number.
        line.heads[:] = [Head(Cart(count=-1_000_000))]
        next(iter(device.sweeps(1, rig=RIG)))
        assert 0.0 < device.pose[0] - before < 1.0
