"""Load of a live page: python benchmarks/live.py [--seconds 120] [--viewers 3] [--source SOURCE].

Runs ``echoplan live`` on a source, by default the flat of two rooms recorded at full rate (160 pings a second) with as
many sweeps at each station as the time needs, and looks at it with some viewers and one more that reads only every
tenth second.  Prints the frames that each viewer saw, the CPU time of the server and of its mapper as shares of one
core, and their memory over time, as JSON.  Needs Linux, which says how much each process uses in ``/proc``.
"""

import argparse
import asyncio
import json
import os
import platform
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import monotonic

import numpy as np
from websockets.asyncio.client import ClientConnection, connect

from echoplan.io import write_recording
from echoplan.model import Recording, Sweep
from echoplan.sources import open_source

TICKS = os.sysconf("SC_CLK_TCK")
PAGE_MEGABYTES = os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    """Run the server and the viewers, and print what they measured."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--viewers", type=int, default=3)
    parser.add_argument("--source", help="What echoplan live takes; by default a recording at full rate.")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        source = arguments.source or str(full_rate_recording(Path(folder) / "rec", arguments.seconds))
        command = [sys.executable, "-m", "echoplan", "live", source, "--port", "0", "--no-browser"]
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as server:
            try:
                assert server.stdout
                address = re.search(r"http://(\S+)/", server.stdout.readline())
                assert address, "the server did not start"
                report = asyncio.run(watch(address[1], server.pid, arguments))
            finally:
                server.terminate()
    print(
        json.dumps({"machine": platform.platform(), "source": arguments.source or "flat, full rate"} | report, indent=2)
    )


def full_rate_recording(folder: Path, seconds: float) -> Path:
    """Write a recording of so many seconds: sweeps follow each other at once, and repeat each other at each station."""
    simulation = open_source("sim:two-room-flat")
    once = tuple(simulation)
    step_ns = int(np.median(np.diff(np.unique(once[0].stamps_ns))))
    length_ns = int(once[0].stamps_ns[-1] - once[0].stamps_ns[0]) + step_ns
    count = int(1.1 * seconds * 1e9 / length_ns) + 1

    def sweeps() -> Iterator[Sweep]:
        for number in range(count):
            sweep = once[number * len(once) // count]
            stamps = sweep.stamps_ns - sweep.stamps_ns[0] + number * length_ns
            yield replace(sweep, index=number, stamps_ns=stamps)

    write_recording(folder, Recording(name="full rate", rig=simulation.rig, sweeps=tuple(sweeps())))
    return folder


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewer:
    """What one viewer saw."""

    frames: list[float] = field(default_factory=list)
    maps: list[float] = field(default_factory=list)

    async def look(self, connection: ClientConnection, *, pause: float) -> None:
        """Note when frames and maps come; read only now and then if there is a pause."""
        async for text in connection:
            topic = json.loads(text)["topic"]
            if topic == "frame":
                self.frames.append(monotonic())
                await asyncio.sleep(pause)
            elif topic == "map":
                self.maps.append(monotonic())


async def watch(host: str, server: int, arguments: argparse.Namespace) -> dict[str, object]:
    """Connect the viewers, and look at the processes every twentieth of the time."""
    viewers = [Viewer() for _ in range(arguments.viewers + 1)]
    connections = [
        await connect(f"ws://{host}/ws", origin=f"http://{host}", max_size=None, ping_interval=None)  # type: ignore[arg-type]
        for _ in viewers
    ]
    pauses = [0.0] * arguments.viewers + [10.0]
    looking = [
        asyncio.create_task(viewer.look(connection, pause=pause))
        for viewer, connection, pause in zip(viewers, connections, pauses, strict=True)
    ]
    start, used, memory = monotonic(), cpu_seconds(server), list[dict[str, float]]()
    for _ in range(20):
        await asyncio.sleep(arguments.seconds / 20)
        memory.append({"seconds": round(monotonic() - start)} | megabytes(server))
    elapsed = monotonic() - start
    shares = {name: seconds - used.get(name, 0.0) for name, seconds in cpu_seconds(server).items()}
    for task in looking:
        task.cancel()
    return {
        "seconds": round(elapsed),
        "frames_per_second": [round(len(each.frames) / elapsed, 2) for each in viewers],
        "longest_gap_seconds": [round(float(np.diff(each.frames).max(initial=0.0)), 2) for each in viewers],
        "maps": len(viewers[0].maps),
        "cpu_share": {name: round(seconds / elapsed, 3) for name, seconds in shares.items()},
        "memory_megabytes": memory,
    }


def processes(server: int) -> dict[str, int]:
    """Find the server and the greatest of its children, the mapper."""
    children = Path(f"/proc/{server}/task/{server}/children").read_text().split()
    children += [each for path in Path(f"/proc/{server}/task").glob("*/children") for each in path.read_text().split()]
    mapper = max((int(each) for each in children), key=resident_megabytes, default=None)
    return {"server": server} | ({} if mapper is None else {"mapper": mapper})


def cpu_seconds(server: int) -> dict[str, float]:
    """CPU time of each process so far."""
    found = {}
    for name, process in processes(server).items():
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        found[name] = (int(fields[11]) + int(fields[12])) / TICKS
    return found


def megabytes(server: int) -> dict[str, float]:
    """Resident memory of each process."""
    return {name: round(resident_megabytes(process), 1) for name, process in processes(server).items()}


def resident_megabytes(process: int) -> float:
    """Resident memory of one process."""
    return int(Path(f"/proc/{process}/statm").read_text().split()[1]) * PAGE_MEGABYTES


if __name__ == "__main__":
    main()
