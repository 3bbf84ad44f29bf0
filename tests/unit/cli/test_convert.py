"""``echoplan convert``: what it says, asks, refuses and writes."""

import os
import pty
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from echoplan.cli.sketch import sketch_sweep
from echoplan.io import builtin_rig, read_recording
from echoplan.model import Sweep
from helpers.typed import echoplan, succeed


def log_lines(factor: float = 1.0) -> list[str]:
    """A log of two places in a room; distances in centimetres times a factor."""
    lines = []
    for place in ("60,60,30", "160,80,20"):
        readings = (f"{angle},{factor * (150 + 1.37 * abs(angle)):.1f}" for angle in range(-90, 91, 10))
        lines += [place, *readings]
    return lines


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "log.txt"
    path.write_text("\n".join(log_lines()))
    return path


def test_a_log_becomes_a_recording_and_is_shown_before(log: Path, tmp_path: Path) -> None:
    out = succeed("convert", log, "--to", tmp_path / "rec")
    assert [len(sweep) for sweep in read_recording(tmp_path / "rec")] == [19, 19]
    rows = {line.split("  ")[1]: line for line in out.splitlines() if line.startswith("  ")}
    assert "cm" in rows["unit of distances"]
    assert rows["unit of distances"].endswith("default")
    assert rows["columns"].split()[1] == "angle,range"
    assert "face 3 cm from the axis" in rows["sensors"]
    assert "38 pings in 2 sweeps; 0 of 40 lines skipped" in out
    assert re.search(r"^ *[oO ]*R[oO ]*$", out, flags=re.MULTILINE)
    assert out.isascii()
    assert out.splitlines()[-1] == f"Written to {tmp_path / 'rec'}: pings.csv, rig.toml"


def test_a_guess_is_refused_in_a_pipe_with_the_option_that_states_it(tmp_path: Path) -> None:
    (tmp_path / "log.txt").write_text("\n".join(log_lines(10.0)))
    done = echoplan("convert", tmp_path / "log.txt", "--to", tmp_path / "rec")
    assert done.status == 2
    assert "unit of distances: mm; if that is right, add --range-unit mm (or --yes); nothing was written" in done.err
    assert done.err.count("\n") == 1
    assert "unit of distances" in done.out
    assert not (tmp_path / "rec").exists()
    succeed("convert", tmp_path / "log.txt", "--to", tmp_path / "rec", "--range-unit", "mm")
    succeed("convert", tmp_path / "log.txt", "--to", tmp_path / "again", "--yes")
    assert (tmp_path / "rec" / "pings.csv").read_bytes() == (tmp_path / "again" / "pings.csv").read_bytes()


@pytest.mark.parametrize(("answer", "status"), [(b"y\n", 0), (b"n\n", 2)])
def test_a_guess_is_asked_about_on_a_terminal(answer: bytes, status: int, tmp_path: Path) -> None:
    (tmp_path / "log.txt").write_text("\n".join(log_lines(10.0)))
    ours, theirs = pty.openpty()
    command = [sys.executable, "-m", "echoplan", "convert", "log.txt", "--to", "rec"]
    child = subprocess.Popen(command, cwd=tmp_path, stdin=theirs, stdout=theirs, stderr=subprocess.PIPE)
    os.close(theirs)
    os.write(ours, answer)
    seen = b""
    try:
        while piece := os.read(ours, 4096):
            seen += piece
    except OSError:
        pass
    _, errors = child.communicate()
    os.close(ours)
    assert (child.returncode, b"Is that right?" in seen) == (status, True), errors
    assert (tmp_path / "rec").exists() is (status == 0)


def test_lines_that_were_skipped_are_counted_and_three_are_shown(log: Path, tmp_path: Path) -> None:
    log.write_text("\n".join([*log_lines()[:9], *["Ready"] * 4, *log_lines()[9:]]))
    out = succeed("convert", log, "--to", tmp_path / "rec")
    assert "4 of 44 lines skipped" in out
    assert out.count("'Ready'") == 3
    assert f"{log}, line 10: 'Ready'" in out


def test_one_file_for_each_place_with_a_list_of_places(tmp_path: Path) -> None:
    logs = tmp_path / "logs"
    logs.mkdir()
    for number in (1, 2, 10):
        (logs / f"loc_{number}.dat").write_text("\n".join(str(150 + number + angle) for angle in range(0, 60, 3)))
    (tmp_path / "places.txt").write_text("0 0 0\n100 0 0\n100 100 90\n")
    words: list[str | Path] = [
        "convert",
        logs,
        "--to",
        tmp_path / "rec",
        "--places",
        tmp_path / "places.txt",
        "--angles",
        "-90 9",
    ]
    succeed(*words, "--range-unit", "cm")
    sweeps = list(read_recording(tmp_path / "rec"))
    assert [sweep.ranges[0] for sweep in sweeps] == [1.51, 1.52, 1.6]
    assert [sweep.map_from_base[0].round(4).tolist() for sweep in sweeps] == [[0, 0, 0], [1, 0, 0], [1, 1, 1.5708]]


def test_a_simulation_and_a_recording_are_written_as_a_recording(tmp_path: Path) -> None:
    succeed("convert", "sim:square,rig=hc-sr04-servo,seed=1", "--to", tmp_path / "rec")
    succeed("convert", tmp_path / "rec", "--to", tmp_path / "again")
    assert (tmp_path / "rec" / "pings.csv").read_bytes() == (tmp_path / "again" / "pings.csv").read_bytes()
    done = echoplan("convert", tmp_path / "rec", "--to", tmp_path / "third", "--center", "90")
    assert (done.status, "it is no text log" in done.err) == (2, True)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--heading", "left"], "unknown value of --heading 'left'; known: clockwise, compass, counter-clockwise"),
        (["--angle-unit", "turns"], "--angle-unit: 'turns' is no unit of angle"),
        (["--range-unit", "furlong"], "--range-unit: 'furlong' is no unit of length"),
        (["--tick", "5"], "--tick: '5' is no length; write one with its unit"),
        (["--place", "1 2"], "--place: '1 2' is no place"),
        (["--angles", "0 0"], "--angles: '0 0' is not a first angle and a step"),
        (["--columns", "angl,range"], "unknown column in --columns 'angl'; did you mean 'angle'?"),
    ],
)
def test_options_that_cannot_be_are_refused(words: list[str], message: str, log: Path, tmp_path: Path) -> None:
    done = echoplan("convert", log, "--to", tmp_path / "rec", *words)
    assert done.status == 2
    assert message in done.err
    assert not (tmp_path / "rec").exists()


@pytest.mark.parametrize(
    ("name", "message"),
    [("missing.txt", "there is no such file; check the name"), ("folder", "there is neither pings.csv nor a text log")],
)
def test_sources_that_are_none_are_refused(name: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    done = echoplan("convert", tmp_path / name, "--to", tmp_path / "rec")
    assert (done.status, message in done.err) == (2, True)


def sweep_of(ranges: list[float], angles: list[float]) -> Sweep:
    count = len(ranges)
    return Sweep(
        index=0,
        stamps_ns=np.arange(count),
        sensor_ids=np.zeros(count, dtype=int),
        servo_angles=np.radians(angles),
        ranges=np.array(ranges),
        map_from_base=np.tile([5.0, 5.0, 1.0], (count, 1)),
    )


def test_the_picture_shows_echoes_where_they_are_seen_from_above() -> None:
    picture = sketch_sweep(sweep_of([0.97, 0.97, 0.97, np.inf], [0, 90, -90, 45]), builtin_rig("hc-sr04-servo"))
    head, *lines, scale, _ = picture.split("\n")
    assert "4 pings, 3 echoes" in head
    assert scale == "One column is 5 cm, one row 10 cm."
    assert lines[0].index("o") == lines[-1].index("R") == 20
    assert lines[-1] == "o" + " " * 19 + "R" + " " * 19 + "o"
    assert len(lines) == 11


def test_a_sweep_without_an_echo_has_no_picture() -> None:
    assert "no echo" in sketch_sweep(sweep_of([np.inf], [0]), builtin_rig("hc-sr04-servo"))
