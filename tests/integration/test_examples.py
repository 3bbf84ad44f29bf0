"""The examples run as they stand."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from echoplan.evaluation import evaluate
from echoplan.io import builtin_rig, builtin_route, builtin_world, read_recording
from echoplan.methods import find_method, map_sweeps
from echoplan.simulation import Simulation
from helpers.typed import succeed

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
    succeed("convert", EXAMPLES / "serial-log.txt", "--to", tmp_path / "recording")
    recording = read_recording(tmp_path / "recording")
    assert [len(sweep) for sweep in recording] == [91] * 5
    found = map_sweeps(find_method("joint").build(recording.rig), recording)
    truth = Simulation(
        world=builtin_world("square"), rig=builtin_rig("hc-sr04-servo"), route=builtin_route("square")
    ).truth
    matches = evaluate(found, truth).matches.walls
    assert len(found.walls) == len(matches.right) == 4
    assert max(match.distance for match in matches.right) < 0.01
