"""The calibration of devices whose servo, sensors and ranges are wrong on purpose."""

import math
import re
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from echoplan.acoustics import Air
from echoplan.cli.calibrate import run
from echoplan.errors import InputError
from echoplan.hardware import Device
from echoplan.hardware.walls import find_arcs
from echoplan.io import builtin_rig, read_conventions, read_rig, write_rig
from echoplan.model import Conventions, Polyline, Rig, Sweep, World
from echoplan.simulation import SimulationSettings
from helpers.calibrating import (
    Answers,
    Bench,
    Step,
    does,
    faces_corner,
    faces_wall,
    identifies,
    quick,
    skips,
    turns,
)

FOUR, ONE = quick(builtin_rig("rotary-array")), quick(builtin_rig("hc-sr04-servo"))


@dataclass(frozen=True, kw_only=True)
class Result:
    """What a calibration wrote, and its values with standard deviations as written in the comments."""

    rig: Rig
    conventions: Conventions
    values: dict[str, tuple[float, float]]
    output: str

    def check(self, name: str, truth: float, *, largest_sigma: float) -> None:
        """Check that a value agrees with the truth within three stated deviations, and that these are small."""
        value, sigma = self.values[name]
        assert sigma <= largest_sigma, name
        assert abs(value - truth) <= 3 * sigma, f"{name}: {value} ± {sigma} for {truth}"


@pytest.fixture
def calibrated(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> Callable[[Bench, Iterable[Step]], Result]:
    """Run the command with a bench and a person who does the steps."""

    def calibrate(bench: Bench, steps: Iterable[Step]) -> Result:
        write_rig(tmp_path / "start.toml", replace(bench.rig, name="start"))
        monkeypatch.setattr("echoplan.hardware.Device", partial(Device, connect=bench.connect))
        monkeypatch.setattr("sys.stdin", Answers(iter(steps)))
        out = tmp_path / "rig.toml"
        run("test", out, str(tmp_path / "start.toml"))
        text = out.read_text(encoding="utf-8")
        found = re.findall(r"^# (.*): (-?[\d.]+) ± ([\d.]+)", text, flags=re.MULTILINE)
        assert (tmp_path / "rig-calibration.png").read_bytes().startswith(b"\x89PNG")
        return Result(
            rig=read_rig(out),
            conventions=read_conventions(out),
            values={name: (float(value), float(sigma)) for name, value, sigma in found},
            output=capsys.readouterr().out,
        )

    return calibrate


def test_four_sensors_in_the_wrong_order_on_a_mirrored_servo(
    calibrated: Callable[[Bench, Iterable[Step]], Result], monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = SimulationSettings(
        servo_gain=0.94, servo_offset=math.radians(6.0), zero_error=0.012, air=Air(temperature=26.0)
    )
    # Pictures take a second.
    monkeypatch.setattr("echoplan.viewer.rig_calibration.calibration_png", lambda _: b"\x89PNG")
    bench = Bench(FOUR, settings=settings, order=(2, 0, 3, 1), is_mirrored=True, seed=5)
    aim = math.radians(0.7)
    steps = [
        *identifies(bench),
        faces_wall(bench, distance=1.43, aim=aim, tape=0.001),
        turns(bench, distance=1.43)[0],
        *skips(2),
        faces_corner(bench, distance=1.43, aim=-3 * aim),
    ]
    result = calibrated(bench, steps)
    assert [sensor.sensor_id for sensor in result.rig.sensors] == [1, 3, 0, 2]
    assert result.conventions.servo_sign == -1
    assert result.conventions.servo_gain == result.values["servo gain"][0]
    assert math.degrees(result.conventions.servo_offset) == pytest.approx(result.values["servo offset"][0], abs=0.01)
    result.check("servo gain", 0.94, largest_sigma=0.017)
    result.check("servo offset", 6.0, largest_sigma=1.1)
    for sensor in (1, 3):
        result.check(f"range offset of sensor {sensor}", 12.0, largest_sigma=4.0)
        result.check(f"half aperture of sensor {sensor}", 34.9, largest_sigma=1.0)
    result.check("temperature", 26.0, largest_sigma=1.0)
    front, left, back, right = (sensor for sensor in result.rig.sensors)
    # Readings that are too long begin behind the sensor; those that faced no wall are taken for the same.
    np.testing.assert_allclose([front.x, left.y, -back.x, -right.y], 0.05 - 0.012, atol=0.006)
    assert back.half_aperture == front.half_aperture
    assert "The servo turns clockwise" in result.output


def test_one_sensor_without_a_thermometer(calibrated: Callable[[Bench, Iterable[Step]], Result]) -> None:
    settings = SimulationSettings(
        servo_gain=1.07, servo_offset=math.radians(-8.0), zero_error=-0.015, air=Air(temperature=15.0)
    )
    bench = Bench(ONE, settings=settings, has_thermometer=False, seed=6)
    steps = [
        *identifies(bench),
        does(lambda: None, answer="15,0 °C"),
        faces_wall(bench, distance=1.08, aim=math.radians(-1.0)),
        faces_corner(bench, distance=1.0),
    ]
    result = calibrated(bench, steps)
    assert result.conventions.servo_sign == 1
    result.check("servo gain", 1.07, largest_sigma=0.009)
    result.check("servo offset", -8.0, largest_sigma=1.1)
    result.check("range offset of sensor 0", -15.0, largest_sigma=4.0)
    result.check("half aperture of sensor 0", 22.4, largest_sigma=2.5)
    assert result.rig.speed_of_sound is None
    assert result.rig.servo == ONE.servo
    assert result.rig.transducer is not None
    assert result.rig.transducer.piston_radius == pytest.approx(0.0081, rel=0.03)


def test_bad_results_are_named_and_the_step_is_repeated(
    calibrated: Callable[[Bench, Iterable[Step]], Result], capsys: pytest.CaptureFixture[str]
) -> None:
    bench = Bench(ONE)
    # Two faces of a folded screen.
    points = np.array([[0.6, -1.1], [1.04, 0.0], [0.7, 1.1]])
    folded = World(name="screen", polylines=(Polyline(points_xy=points),))
    steps = [
        does(lambda: None),
        *identifies(bench),
        does(bench.put, folded, answer="far"),
        does(bench.put, folded, answer="100"),
        faces_wall(bench, distance=1.0, tape=0.3),
        *skips(),
    ]
    with pytest.raises(InputError, match=r"no wall was seen at 130 cm \(3 attempts\); check the tape"):
        calibrated(bench, steps)
    output = capsys.readouterr().out
    for problem in ("no hand was seen within 50 cm", "'far' is no distance", "the wall is not flat"):
        assert f"Problem: {problem}" in output


def test_a_calibration_of_which_every_step_is_skipped_writes_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("echoplan.hardware.Device", partial(Device, connect=Bench(FOUR).connect))
    monkeypatch.setattr("sys.stdin", Answers(iter(skips(3))))
    run("test", tmp_path / "rig.toml", "")
    assert not list(tmp_path.iterdir())
    assert "nothing is written" in capsys.readouterr().out


def test_answers_that_end_early_write_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    bench = Bench(ONE)
    monkeypatch.setattr("echoplan.hardware.Device", partial(Device, connect=bench.connect))
    monkeypatch.setattr("sys.stdin", Answers(iter([])))
    with pytest.raises(InputError, match="the answers ended before the calibration; answer each step"):
        run("test", tmp_path / "rig.toml", "")
    assert not list(tmp_path.iterdir())


def test_an_arc_ends_where_nothing_nearer_hides_the_wall() -> None:
    angles = np.radians(np.arange(-40.0, 41.0))
    ranges = np.where(np.abs(angles) < math.radians(20.5), 1.0, np.inf)
    ranges[angles > math.radians(10.5)] = 0.4
    # A lost ping and a stray echo do not split it.
    ranges[[30, 36]] = np.inf, 0.7
    sweep = Sweep(
        index=0,
        stamps_ns=np.arange(81),
        sensor_ids=np.zeros(81, dtype=np.int64),
        servo_angles=angles,
        ranges=ranges,
        map_from_base=np.zeros((81, 3)),
    )
    (arc,) = find_arcs([sweep], sensor_id=0, depth=1.02, gate=0.1, scale=1.01)
    assert math.degrees(arc.lower) == pytest.approx(-20.5)
    assert math.isnan(arc.upper)
    assert len(arc.ranges) == 29
    np.testing.assert_allclose(arc.ranges, 1.01)
