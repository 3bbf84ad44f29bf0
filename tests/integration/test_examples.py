"""The examples run as they stand."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from echoplan.evaluation import evaluate
from echoplan.io import builtin_rig, builtin_route, builtin_world, read_recording
from echoplan.methods import find_method, map_sweeps
from echoplan.simulation import Simulation

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_square_room_comes_out_square(tmp_path: Path) -> None:
    command = [sys.executable, str(EXAMPLES / "square_room.py")]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    errors = [float(line.split()[3]) for line in done.stdout.splitlines() if line.startswith("wall")]
    assert len(errors) == 4
    assert max(errors) < 5.0
    assert ET.parse(tmp_path / "square-room.svg").getroot().tag.endswith("svg")


def test_the_log_of_a_serial_port_becomes_a_recording_that_maps_to_the_room(tmp_path: Path) -> None:
    # The log was made by the simulator, in the built-in square room.
    command = [sys.executable, str(EXAMPLES / "from_serial_log.py"), str(EXAMPLES / "serial-log.txt"), "recording"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
    recording = read_recording(tmp_path / "recording")
    assert [len(sweep) for sweep in recording] == [91] * 5
    found = map_sweeps(find_method("joint").build(recording.rig), recording)
    truth = Simulation(
        world=builtin_world("square"), rig=builtin_rig("hc-sr04-servo"), route=builtin_route("square")
    ).truth
    matches = evaluate(found, truth).matches.walls
    assert len(found.walls) == len(matches.right) == 4
    assert max(match.distance for match in matches.right) < 0.01


def test_a_serial_log_with_crlf_and_a_reading_without_echo_is_read(tmp_path: Path) -> None:
    (tmp_path / "log.txt").write_bytes(b"100,50,90\r\r\n-90,123.4\r\n-88,0.0\r\n\r\n")
    command = [sys.executable, str(EXAMPLES / "from_serial_log.py"), "log.txt", "recording"]
    subprocess.run(command, cwd=tmp_path, capture_output=True, check=True)
    (sweep,) = read_recording(tmp_path / "recording")
    assert sweep.ranges.tolist() == [1.234, float("inf")]
    assert sweep.map_from_base[0].round(4).tolist() == [1.0, 0.5, 1.5708]


def converted(folder: Path, log: str) -> subprocess.CompletedProcess[str]:
    (folder / "log.txt").write_text(log)
    command = [sys.executable, str(EXAMPLES / "from_serial_log.py"), "log.txt", "new/recording"]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


def test_four_sensors_on_a_servo_and_the_stamps_of_a_serial_monitor_are_understood(tmp_path: Path) -> None:
    log = "10:33:01.123 -> Ready\n10:33:01.200 -> 100,50,0\n10:33:01.300 -> -90,10,20,0,40.5\n"
    assert converted(tmp_path, log).returncode == 0
    recording = read_recording(tmp_path / "new" / "recording")
    (sweep,) = recording
    assert sweep.ranges.tolist() == [0.1, 0.2, float("inf"), 0.405]
    assert [round(each.yaw, 3) for each in recording.rig.sensors] == [0.0, 1.571, 3.142, 4.712]


@pytest.mark.parametrize(
    ("log", "message"),
    [
        ("1,2,3\n-88,\n", "log.txt, line 2: '' is no number; fix or delete this line"),
        ("-88,20\n", "log.txt, line 1: a reading before any place; write x,y,heading in a line before it"),
        ("1,2,3\n1,2,3,4\n", "log.txt, line 2: 4 numbers; write"),
        ("Ready\n1,2,3\n", "log.txt: there is no reading in it; write"),
    ],
)
def test_a_log_that_cannot_be_read_is_refused_in_one_line(tmp_path: Path, log: str, message: str) -> None:
    done = converted(tmp_path, log)
    assert done.returncode == 2
    assert done.stderr.startswith(message)
    assert done.stderr.count("\n") == 1
    assert not (tmp_path / "new").exists()
