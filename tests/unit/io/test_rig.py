"""Rigs are read from what people write, and wrong units in them are reported."""

import tomllib
from math import pi
from pathlib import Path

import numpy as np
import pytest

from echoplan.errors import InputError
from echoplan.io import builtin_rig, read_rig, write_rig
from echoplan.io.rig import format_rig
from echoplan.model import Odometry, Rig, Sensor, Transducer

PLAIN = """\
name = "bumper"
[[sensor]]
id = 4
half_aperture = 0.26
min_range = 0.02
max_range = 4.0
resolution = 0.003
"""
TURNED = """\
[turret]
x = 0.1
yaw = 3.0
[servo]
start = -1.5
stop = 1.5
step = 0.1
[firing]
period = 0.06
groups = [[4]]
[transducer]
piston_radius = 0.008
[odometry]
along = 0.02
yaw_per_metre = 0.03
"""
ASSUMED = "speed_of_sound = 340.0\nrays = false\n"


def read(tmp_path: Path, text: str) -> Rig:
    path = tmp_path / "rig.toml"
    path.write_text(text, encoding="utf-8")
    return read_rig(path)


def test_what_is_not_specified_is_the_origin_or_unknown(tmp_path: Path) -> None:
    rig = read(tmp_path, PLAIN)
    assert rig.name == "bumper"
    assert rig.base_from_turret.tolist() == [0.0, 0.0, 0.0]
    assert (rig.servo, rig.firing, rig.transducer, rig.odometry) == (None, None, None, None)
    assert (rig.speed_of_sound, rig.rays) == (None, None)
    assert rig.sensors == (Sensor(sensor_id=4, half_aperture=0.26, min_range=0.02, max_range=4.0, resolution=0.003),)


def test_everything_else_can_be_specified(tmp_path: Path) -> None:
    rig = read(tmp_path, ASSUMED + TURNED + PLAIN.replace('name = "bumper"\n', ""))
    assert rig.name == "rig"
    assert rig.base_from_turret.tolist() == [0.1, 0.0, 3.0]
    assert rig.servo is not None
    assert (rig.servo.start, rig.servo.stop, rig.servo.step) == (-1.5, 1.5, 0.1)
    assert rig.firing is not None
    assert (rig.firing.period, rig.firing.groups) == (0.06, ((4,),))
    assert rig.odometry == Odometry(along=0.02, yaw_per_metre=0.03)
    assert (rig.speed_of_sound, rig.rays) == (340.0, False)
    assert rig.transducer == Transducer(piston_radius=0.008)


def test_what_is_not_known_is_not_written(tmp_path: Path) -> None:
    write_rig(tmp_path / "new.toml", read(tmp_path, PLAIN))
    written = tomllib.loads((tmp_path / "new.toml").read_text())
    assert list(written) == ["name", "turret", "sensor"]


def test_numbers_of_numpy_are_written_as_numbers(tmp_path: Path) -> None:
    sensor = Sensor(
        sensor_id=0, yaw=np.float64(pi), half_aperture=np.pi / 6, min_range=0.02, max_range=4.0, resolution=0.003
    )
    write_rig(tmp_path / "rig.toml", Rig(name="one", sensors=(sensor,)))
    assert read_rig(tmp_path / "rig.toml").sensors[0].yaw == pi


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("half_aperture = 0.26", "half_aperture = 15", r"line 4, .*: 15 looks like degrees; write radians: 0\.261799"),
        ("id = 4", "id = 4\nyaw = 90", r"sensor\[0\]\.yaw: 90 looks like degrees; write radians: 1\.570796"),
        ("max_range = 4.0", "max_range = 400", r"max_range: 400 m is beyond the range of ultrasound .* write metres"),
        ("id = 4", "id = 4\nx = -150.0", r"line 4, sensor\[0\]\.x: -150 m is larger than a robot; write metres"),
        ("max_range = 4.0", "max_range = 0.01", r"line 2, sensor\[0\]: min_range must be less than max_range"),
        ("half_aperture", "half_apperture", r"the key 'half_apperture' is unknown; did you mean 'half_aperture'\?"),
        ("resolution = 0.003", "", r"the key 'resolution' is missing; add it: resolution: Step of the readings"),
        ("id = 4", "id = 4.5", r"line 3, sensor\[0\]\.id: must be a valid integer, not 4\.5"),
        ("4.0", "4,0", r"rig\.toml, line 6, column 14: the file is broken"),
    ],
)
def test_an_invalid_sensor_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in PLAIN
    with pytest.raises(InputError, match=message):
        read(tmp_path, PLAIN.replace(old, new))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (PLAIN + PLAIN.partition("\n")[2], r"rig\.toml: sensor id 4 occurs 2 times; every sensor needs its own"),
        ("name = 'none'\n", r"the key 'sensor' is missing; add it"),
        ("sensor = []\n", r"a rig must have at least one sensor"),
        (TURNED.replace("-1.5", "-90") + PLAIN[16:], r"line 5, servo\.start: -90 looks like degrees"),
        (TURNED.replace("[[4]]", "[[4, 5]]") + PLAIN[16:], r"groups name sensor 5, but the sensors are \[4\]"),
        (ASSUMED.replace("340.0", "0.0343") + PLAIN, r"speed_of_sound must be at least 300, not 0\.0343"),
        (TURNED.replace("0.06", "0") + PLAIN[16:], r"line 8, firing: period must be greater than 0, not 0"),
        (TURNED.replace("0.008", "-1") + PLAIN[16:], r"transducer: piston_radius must be greater than 0"),
    ],
)
def test_an_invalid_rig_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, text)


def test_a_rig_given_as_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="it is a folder; name a file in it"):
        read_rig(tmp_path)


def test_built_in_rigs_survive_writing(tmp_path: Path) -> None:
    rig = builtin_rig("ring-16")
    write_rig(tmp_path / "rig.toml", rig)
    again = read_rig(tmp_path / "rig.toml")
    assert again.sensors == rig.sensors
    assert (again.servo, again.firing, again.transducer) == (None, rig.firing, rig.transducer)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("x = 0.05", "x = 1e6"),
        ("[turret]\nx = 0.0", "[turret]\nx = 1e308"),
        ("yaw = 0.0", "yaw = 1e300"),
        ("step = ", "step = 1e-12 #"),
        ("period = ", "period = 1e300 #"),
        ("period = ", "period = 1e-300 #"),
        ("frequency = ", "frequency = 1e300 #"),
        ("figure_of_merit = ", "figure_of_merit = 1e300 #"),
        ("burst_cycles = ", "burst_cycles = 1e12 #"),
        ("[servo]", "[odometry]\nalong = 1e308\n[servo]"),
    ],
)
def test_a_number_beyond_what_a_rig_can_be_is_refused_with_its_line(tmp_path: Path, old: str, new: str) -> None:
    text = format_rig(builtin_rig("rotary-array"))
    assert old in text
    (tmp_path / "rig.toml").write_text(text.replace(old, new, 1))
    with pytest.raises(
        InputError, match=r"rig\.toml, line \d+, .*(must be (less|greater) than|finer than|more than|larger than)"
    ):
        read_rig(tmp_path / "rig.toml")
