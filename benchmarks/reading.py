"""Time and memory of reading and writing a long recording: python benchmarks/reading.py [ROWS].

Writes a recording of the rotary array with many pings (10 million by default), counts its sweeps, reads it, and writes
a copy of it, each in a process of its own so that the greatest memory is that of the one task.
"""

import json
import platform
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import TextIO

import numpy as np

from echoplan.io import builtin_rig, read_recording, write_recording, write_rig

PINGS_PER_SWEEP = 364
TASKS = ("count", "read", "write")


def main(arguments: list[str]) -> None:
    """Make the recording and run each task on it."""
    rows = int(arguments[0]) if arguments else 10_000_000
    with tempfile.TemporaryDirectory() as folder:
        make_recording(Path(folder), rows)
        size = (Path(folder) / "pings.csv").stat().st_size / 1e6
        report = {"machine": platform.platform(), "rows": rows, "size_megabytes": round(size)}
        print(json.dumps(report | {task: run_apart(task, folder, rows) for task in TASKS}, indent=2))


def make_recording(folder: Path, rows: int) -> None:
    """Write pings with the digits of a real recording; one in eleven is without echo."""
    write_rig(folder / "rig.toml", builtin_rig("rotary-array"))
    with (folder / "pings.csv").open("w", encoding="utf-8") as file:
        file.write("t,sweep,sensor,servo,range,x,y,yaw\n")
        for sweep in range(-(-rows // PINGS_PER_SWEEP)):
            write_sweep(file, sweep, min(PINGS_PER_SWEEP, rows - sweep * PINGS_PER_SWEEP))


def write_sweep(file: TextIO, sweep: int, rows: int) -> None:
    """Write the rows of one sweep at a station of its own."""
    rng = np.random.default_rng(sweep)
    x, y, yaw = rng.uniform(-3.0, 3.0, 3)
    ranges = np.where(rng.random(rows) < 1 / 11, np.inf, rng.uniform(0.03, 3.0, rows))
    for ping, reading in enumerate(ranges.tolist()):
        stamp = 1_763_700_000 + 4 * sweep + 0.025 * (ping // 4)
        servo = np.deg2rad(ping // 4 - 45)
        file.write(f"{stamp:.3f},{sweep},{ping % 4},{servo:.6f},{reading:.4f},{x:.5f},{y:.5f},{yaw:.6f}\n")


def run_apart(task: str, folder: str, rows: int) -> dict[str, float]:
    """Run a task in another process."""
    command = [sys.executable, __file__, f"--{task}", folder]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    seconds, megabytes = map(float, done.stdout.split())
    return {
        "seconds": round(seconds, 1),
        "rows_per_second": round(rows / seconds, -3),
        "greatest_memory_megabytes": round(megabytes),
    }


def run_here(task: str, folder: Path) -> None:
    """Run a task and print its seconds and the greatest memory of this process in megabytes."""
    import resource  # noqa: PLC0415 - not on every system

    start = time.perf_counter()
    recording = read_recording(folder)
    if task == "count":
        len(recording)
    elif task == "read":
        sum(map(len, recording))
    else:
        write_recording(folder / "copy", recording)
    print(time.perf_counter() - start, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3)


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1].startswith("--"):
        run_here(sys.argv[1].removeprefix("--"), Path(sys.argv[2]))
    else:
        main(sys.argv[1:])
