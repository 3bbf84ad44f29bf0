"""Load of a live page: python benchmarks/live.py [--seconds 120] [--viewers 3] [--source SOURCE].

Runs ``echoplan live --out`` on a source and looks at it with some viewers and one more that reads only every tenth
second.  By default the source is a simulated device that drives through the flat of two rooms and sweeps at full rate
(160 pings a second), as often at each station as the time needs.  Prints the frames that each viewer saw, the CPU time
of the server and of its mapper as shares of one core, their memory over time, the notices of the page, and how many
pings each sweep of the recording has, as JSON.  Needs Linux, where ``/proc`` shows how much each process uses.
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
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic

import numpy as np
from websockets.asyncio.client import ClientConnection, connect

from echoplan.sources import open_source

TICKS = os.sysconf("SC_CLK_TCK")
WORLD = "two-room-flat"
PAGE_MEGABYTES = os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    """Run the device, the server and the viewers, and print what they measured."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument("--viewers", type=int, default=3)
    parser.add_argument("--source", help="What echoplan live takes; by default a simulated device at full rate.")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, ExitStack() as stack:
        source, repeats = arguments.source, 1
        if source is None:
            source = stack.enter_context(started("device", WORLD, "--tcp", "0", shows=r"(tcp://\S+)"))[1]
            source, repeats = f"{source},rig=rotary-array", sweeps_at_each_station(arguments.seconds)
        out = Path(folder) / "map"
        options = ("--sweeps", str(repeats), "--out", str(out), "--port", "0", "--no-browser")
        with started("live", source, *options, shows=r"http://(\S+)/") as (server, address):
            report = asyncio.run(watch(address, server.pid, arguments))
        report |= recorded(out / "recording")
    source = arguments.source or f"simulated device in {WORLD}"
    print(json.dumps({"machine": platform.platform(), "source": source} | report, indent=2))


@contextmanager
def started(*command: str, shows: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """Run a command of echoplan while the block runs; yield it, and what it shows in its first lines."""
    with subprocess.Popen([sys.executable, "-m", "echoplan", *command], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout
            found = next((match for line in process.stdout if (match := re.search(shows, line))), None)
            assert found, f"echoplan {command[0]} did not start"
            yield process, found[1]
        finally:
            process.terminate()


def sweeps_at_each_station(seconds: float) -> int:
    """Return how often the device has to sweep at each station to need more than so many seconds."""
    stations = tuple(open_source(f"sim:{WORLD}"))
    duration = float(np.mean([np.ptp(each.stamps_ns) for each in stations])) / 1e9
    return int(1.1 * seconds / duration / len(stations)) + 1


def recorded(folder: Path) -> dict[str, object]:
    """Return how many sweeps and pings were recorded, and the numbers of pings that sweeps have."""
    pings = [len(sweep) for sweep in open_source(str(folder))]
    return {"sweeps": len(pings), "pings": sum(pings), "pings_of_a_sweep": sorted(set(pings))}


@dataclass(frozen=True, slots=True, kw_only=True)
class Viewer:
    """What one viewer saw."""

    frames: list[float] = field(default_factory=list)
    maps: list[float] = field(default_factory=list)
    notices: list[str] = field(default_factory=list)

    async def look(self, connection: ClientConnection, *, pause: float) -> None:
        """Note when frames and maps come; read only now and then if there is a pause."""
        async for text in connection:
            message = json.loads(text)
            topic = message["topic"]
            if topic == "frame":
                self.frames.append(monotonic())
                await asyncio.sleep(pause)
            elif topic == "map":
                self.maps.append(monotonic())
            elif topic == "notice":
                self.notices.append(message["text"])


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
        "notices": viewers[0].notices,
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
