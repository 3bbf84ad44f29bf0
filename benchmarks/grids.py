"""How many pings occupancy grids take in a second: python benchmarks/grids.py [PINGS].

Inserts pings of a room of 4 m by 3 m into grids with cells of 5 cm on one core, by each method of grids, for beams of
15 degrees (as specified by sellers of an HC-SR04) and of 70 degrees (over which it detects a wall).  Each method is run
once before, so that compilation does not count; what counts is CPU time.  MRPT does the same if its library and a
compiler are installed (Debian: libmrpt-maps-dev, g++, cmake): one insertion into a COccupancyGridMap2D a ping.
"""

import platform
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.grids import (
    BayesRule,
    BayesSettings,
    CanvasSettings,
    CemalRule,
    CemalSettings,
    Cones,
    ElfesRule,
    ElfesSettings,
    GridRule,
    MurielRule,
    MurielSettings,
    RangeLayerRule,
    RangeLayerSettings,
)
from echoplan.cli.terminal import show
from echoplan.model import Table

PEER = Path(__file__).parent / "mrpt"
WIDTH, DEPTH, REACH = 4.0, 3.0, 4.0
BEAMS = (15.0, 70.0)
# Pings of a sweep of the array; the slower methods draw fewer pings.
SWEEP, FEW = 364, 3640
ROUNDS = 5
CANVAS = CanvasSettings(resolution=0.05)


def main(arguments: list[str]) -> None:
    """Draw the same pings by every method and print how many they take in a second."""
    count = int(arguments[0]) if arguments else 100_000
    speeds = {beam: speeds_of(room_pings(count, np.radians(beam) / 2)) for beam in BEAMS}
    show(table(speeds, count))


def room_pings(count: int, half_aperture: float) -> Cones:
    """Pings from places in an empty room: each reads the nearest point of a wall within its beam."""
    rng = np.random.default_rng(0)
    hubs = np.repeat(rng.uniform([0.6, 0.6], [WIDTH - 0.6, DEPTH - 0.6], (-(-count // SWEEP), 2)), SWEEP, axis=0)[
        :count
    ]
    x, y = hubs.T.copy()
    bearings = 2 * np.pi * np.arange(count) / SWEEP
    away = np.stack([WIDTH - x, DEPTH - y, x, y], axis=1)
    off = np.abs((bearings[:, None] - 0.5 * np.pi * np.arange(4) + np.pi) % (2 * np.pi) - np.pi)
    slants = np.minimum(np.maximum(off - half_aperture, 0.0), 0.49 * np.pi)
    every = np.ones(count)
    return Cones(
        x=x,
        y=y,
        ux=np.cos(bearings),
        uy=np.sin(bearings),
        half_apertures=half_aperture * every,
        readings=(away / np.cos(slants)).min(axis=1),
        blanks=0.02 * every,
        reaches=REACH * every,
        hub_x=x,
        hub_y=y,
    )


def rules() -> dict[str, GridRule]:
    """Make a new one of each kind."""
    return {
        "grid-bayes": BayesRule(BayesSettings(), CANVAS),
        "grid-elfes": ElfesRule(ElfesSettings(), CANVAS),
        "grid-muriel": MurielRule(MurielSettings(), CANVAS),
        "grid-cemal": CemalRule(CemalSettings(), CANVAS),
        "grid-range-layer": RangeLayerRule(RangeLayerSettings(), CANVAS),
    }


def speeds_of(cones: Cones) -> dict[str, float]:
    """Pings in a second by each method, the fastest of some rounds."""
    few = Cones(*(field[:FEW] for field in cones))
    given = {name: cones if name == "grid-bayes" else few for name in rules()}
    rounds = [{name: seconds(rule, given[name]) for name, rule in rules().items()} for _ in range(ROUNDS)]
    own = {name: len(given[name].x) / min(each[name] for each in rounds) for name in given}
    return own | {"MRPT": mrpt_speed(cones)}


def seconds(rule: GridRule, cones: Cones) -> float:
    """Time to take pings in, sweep by sweep, and to give the grid."""
    parts = [Cones(*(field[start : start + SWEEP] for field in cones)) for start in range(0, len(cones.x), SWEEP)]
    start = time.process_time()
    for part in parts:
        rule.add(part)
    rule.grid  # noqa: B018 - some rules draw when they are asked
    return time.process_time() - start


def mrpt_speed(cones: Cones) -> float:
    """Pings in a second by MRPT; nan if it is not installed."""
    if shutil.which("cmake") is None:
        return float("nan")
    with tempfile.TemporaryDirectory() as folder:
        built = build_peer(Path(folder))
        if built is None:
            return float("nan")
        np.savetxt(Path(folder) / "pings.txt", peer_rows(cones))
        command = [str(built), str(Path(folder) / "pings.txt"), str(CANVAS.resolution)]
        rounds = [subprocess.run(command, check=True, capture_output=True, text=True).stdout for _ in range(ROUNDS)]
    return len(cones.x) / min(map(float, rounds))


def build_peer(folder: Path) -> Path | None:
    """Compile the program that draws with MRPT; None where that fails."""
    steps = (
        ["cmake", "-S", str(PEER), "-B", str(folder), "-DCMAKE_BUILD_TYPE=Release"],
        ["cmake", "--build", str(folder)],
    )
    for step in steps:
        if subprocess.run(step, check=False, capture_output=True).returncode:
            return None
    return folder / "grid"


def peer_rows(cones: Cones) -> FloatArray:
    """Make the rows that the program reads: x, y, bearing, range, reach and full aperture of each ping."""
    bearings = np.arctan2(cones.uy, cones.ux)
    return np.column_stack([cones.x, cones.y, bearings, cones.readings, cones.reaches, 2 * cones.half_apertures])


def table(speeds: dict[float, dict[str, float]], count: int) -> Table:
    """Lay the speeds out, methods below each other."""
    names = list(next(iter(speeds.values())))
    return Table(
        title=f"Pings per second on one core, cells of 5 cm, {count} pings ({platform.machine()})",
        columns=("method", *(f"beam of {beam:.0f} degrees" for beam in speeds)),
        rows=tuple((name, *(cell(by_name[name]) for by_name in speeds.values())) for name in names),
    )


def cell(speed: float) -> str:
    """Write a speed in whole thousands."""
    return "not installed" if np.isnan(speed) else f"{speed:,.0f}"


if __name__ == "__main__":
    main(sys.argv[1:])
