"""The examples run as they stand."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_the_square_room_comes_out_square(tmp_path: Path) -> None:
    command = [sys.executable, str(EXAMPLES / "square_room.py")]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    errors = [float(line.split()[3]) for line in done.stdout.splitlines() if line.startswith("wall")]
    assert len(errors) == 4
    assert max(errors) < 5.0
    assert ET.parse(tmp_path / "square-room.svg").getroot().tag.endswith("svg")
