"""Conventions are read beside the rig, and applied before anything else is checked."""

import json
from math import pi
from pathlib import Path

import pytest

from echoplan.errors import InputError
from echoplan.io import read_conventions, read_recording, read_rig, write_recording
from echoplan.model import Axes, Conventions, Heading

RIG = """\
[[sensor]]
id = 0
half_aperture = 0.26
min_range = 0.02
max_range = 4.0
resolution = 0.003
"""
PINGS = "t,sweep,sensor,servo,range,x,y,yaw\n0,0,0,0,44.2,100,50,0\n0.1,0,0,1.570796,inf,100,50,0\n"
WRITTEN = """
[conventions]
servo_sign = -1
servo_offset = 1.570796
range_unit = "in"
position_unit = "cm"
heading = "compass"
axes = "x-y"
"""


def folder(tmp_path: Path, conventions: str) -> Path:
    (tmp_path / "rig.toml").write_text(RIG + conventions)
    (tmp_path / "pings.csv").write_text(PINGS)
    return tmp_path


def test_a_rig_without_conventions_is_in_si(tmp_path: Path) -> None:
    assert read_conventions(folder(tmp_path, "") / "rig.toml") == Conventions()


def test_conventions_are_read_from_the_end_of_a_rig(tmp_path: Path) -> None:
    path = folder(tmp_path, WRITTEN) / "rig.toml"
    assert read_conventions(path) == Conventions(
        servo_sign=-1,
        servo_offset=1.570796,
        range_unit=0.0254,
        position_unit=0.01,
        heading=Heading.COMPASS,
        axes=Axes.Y_DOWN,
    )
    assert len(read_rig(path).sensors) == 1


def test_a_unit_may_be_given_in_metres(tmp_path: Path) -> None:
    conventions = read_conventions(folder(tmp_path, "[conventions]\nrange_unit = 2.54\n") / "rig.toml")
    assert conventions.range_unit == 2.54


def test_sweeps_are_in_si_whatever_was_recorded(tmp_path: Path) -> None:
    (sweep,) = read_recording(folder(tmp_path, WRITTEN))
    assert sweep.ranges[0] == pytest.approx(1.12268)
    assert sweep.servo_angles == pytest.approx([pi / 2, 0.0], abs=1e-5)
    assert sweep.map_from_base[0] == pytest.approx([1.0, -0.5, pi / 2])


def test_a_recording_is_written_in_si(tmp_path: Path) -> None:
    recording = read_recording(folder(tmp_path, WRITTEN))
    write_recording(tmp_path / "new", recording)
    assert read_recording(tmp_path / "new").conventions == Conventions()
    (before,), (after,) = recording, read_recording(tmp_path / "new")
    assert after.ranges.tolist() == before.ranges.tolist()


def test_ranges_in_an_unknown_unit_are_refused_with_the_units_that_are_possible(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r'column range: .* set range_unit = "cm" or "mm" or "in" under \[conventions\]'
    ):
        list(read_recording(folder(tmp_path, "")))


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        ("cm", r'not in the range_unit that is set, "cm": .* set range_unit = "mm" under'),
        (2.0, r'not in the range_unit that is set, 2: .* set range_unit = "mm" under'),
        ("in", r'not in the range_unit that is set, "in": .* set range_unit = "mm" under'),
    ],
)
def test_ranges_in_another_unit_than_the_one_set_are_refused_with_those_that_are_possible(
    tmp_path: Path, unit: str | float, said: str
) -> None:
    path = folder(tmp_path, f"[conventions]\nrange_unit = {json.dumps(unit)}\n")
    rows = [f"{k},0,0,0,{1000 * metres:.0f},0,0,0\n" for k, metres in enumerate((0.6, 1.2, 2.9, 3.1))]
    (path / "pings.csv").write_text("".join([PINGS.splitlines(keepends=True)[0], *rows]))
    with pytest.raises(InputError, match=said):
        list(read_recording(path))


def degrees(tmp_path: Path, conventions: str) -> Path:
    """A recording of which servo angles and headings are written in degrees."""
    path = folder(tmp_path, f"[conventions]\n{conventions}\n")
    rows = [f"{k},0,0,{10 * k},1.5,0,0,{yaw}\n" for k, yaw in enumerate([90] * 19)]
    (path / "pings.csv").write_text("".join([PINGS.splitlines(keepends=True)[0], *rows]))
    return path


@pytest.mark.parametrize("offset", ["servo_offset = -1.570796", "servo_gain = 0.94", 'heading = "compass"'])
def test_degrees_are_refused_whatever_conventions_make_of_them(tmp_path: Path, offset: str) -> None:
    with pytest.raises(InputError, match="column servo: the angles look like degrees"):
        list(read_recording(degrees(tmp_path, offset)))


def test_headings_of_a_compass_in_degrees_are_refused(tmp_path: Path) -> None:
    path = degrees(tmp_path, 'servo_gain = 0.0174533\nheading = "compass"')
    with pytest.raises(InputError, match="column yaw: the angles look like degrees"):
        list(read_recording(path))


def test_a_gain_may_make_radians_of_degrees(tmp_path: Path) -> None:
    path = degrees(tmp_path, "servo_gain = 0.0174533")
    (path / "pings.csv").write_text((path / "pings.csv").read_text().replace(",90\n", ",1.5\n"))
    (sweep,) = read_recording(path)
    assert sweep.servo_angles[-1] == pytest.approx(pi, abs=1e-4)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("servo_sign = 2", r"conventions\.servo_sign: must be 1 or -1, not 2"),
        ('range_unit = "yd"', r"conventions\.range_unit"),
        ('heading = "left"', r"conventions\.heading: must be 'counter-clockwise', 'clockwise' or 'compass'"),
        ("servo_sing = -1", r"the key 'servo_sing' is unknown; did you mean 'servo_sign'\?"),
        ("servo_offset = 90.0", r"90 looks like degrees; write radians: 1\.570796"),
    ],
)
def test_a_wrong_convention_is_refused_with_its_place(tmp_path: Path, line: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        read_recording(folder(tmp_path, f"[conventions]\n{line}\n"))
