"""A corridor without ground truth: python benchmarks/corridor.py FOLDER [--poses MODE] [--noisy-copies COPIES].

Maps the recording twice, because the first run compiles.  Prints the width of the corridor between the two facing walls
that most stations detected, how parallel they are, how many sweeps are placed along the corridor by odometry alone, how
much less certain that is than across, and the CPU time.  ``--noisy-copies`` also maps copies with 1 mm of noise in
readings that have a resolution of 1 cm, and prints how often the result is the same: where poses are found by a search,
this shows how much of the result is luck.
"""

import argparse
import math
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from echoplan.cli.terminal import show, tracked
from echoplan.geometry import wrap
from echoplan.io import read_recording
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Source, Table, Wall
from library.noisy_copies import noisy_copy

# Walls that face each other within this are sides of one corridor [rad].
OPPOSITE = 0.1
# Results within this distance [m] and angle [rad] count as the same.
NEAR, PARALLEL = 0.03, math.radians(0.5)


def main() -> None:
    """Map the recording and print the results."""
    parser = argparse.ArgumentParser(description="A corridor without ground truth.")
    parser.add_argument("folder", type=Path)
    parser.add_argument("--noisy-copies", type=int, default=0)
    parser.add_argument("--poses", type=PoseMode, choices=list(PoseMode), default=PoseMode.AUTO)
    arguments = parser.parse_args()
    recording = read_recording(arguments.folder)
    mapped(recording, arguments.poses)
    begun = time.process_time()
    found = mapped(recording, arguments.poses)
    seconds = time.process_time() - begun
    rows = [*sides(found), *open_ways(found), ("processor (s)", f"{seconds:.1f}")]
    show(Table(title=f"{recording.name}: {len(found.poses)} sweeps", columns=("what", "value"), rows=tuple(rows)))
    if arguments.noisy_copies:
        with ProcessPoolExecutor() as workers:
            runs = workers.map(partial(width, arguments.folder, arguments.poses), range(arguments.noisy_copies))
            show(repeated(list(tracked(runs, total=arguments.noisy_copies, task="mapping copies"))))


def width(folder: Path, poses: PoseMode, seed: int) -> tuple[float, float]:
    """Map a copy with a little noise: how far apart the sides are [m], and how far off parallel [rad]."""
    recording = read_recording(folder)
    found = map_sweeps(JointMapper(recording.rig, JointSettings(poses=poses)), noisy_copy(recording, seed))
    pair = opposite(found)
    return (pair[0].offset + pair[1].offset, abs(turn(*pair))) if pair else (np.nan, np.nan)


def repeated(copies: list[tuple[float, float]]) -> Table:
    """Count the copies with the same result."""
    apart, not_parallel = np.array(copies).T
    usual = float(np.nanmedian(apart))
    alike = (np.abs(apart - usual) < NEAR) & (not_parallel < PARALLEL)
    rows = (
        ("apart, median (m)", f"{usual:.3f}"),
        ("so within 3 cm, and parallel within half a degree", f"{alike.sum()}"),
    )
    return Table(title=f"{len(copies)} copies with a millimetre of noise", columns=("what", "value"), rows=rows)


def mapped(recording: Source, poses: PoseMode) -> FeatureMap:
    """Map a recording."""
    return map_sweeps(JointMapper(recording.rig, JointSettings(poses=poses)), recording)


def sides(found: FeatureMap) -> Iterator[tuple[str, str]]:
    """Describe the two sides."""
    pair = opposite(found)
    if pair:
        one, other = pair
        yield "walls detected by (stations)", f"{one.stations}, {other.stations}"
        yield "apart (m)", f"{one.offset + other.offset:.3f}"
        yield "off parallel (°)", f"{np.degrees(abs(turn(one, other))):.2f}"


def opposite(found: FeatureMap) -> tuple[Wall, Wall] | None:
    """Find the two walls that face each other and that most stations detected."""
    facing = [pair for pair in combinations(found.walls, 2) if abs(turn(*pair)) < OPPOSITE]
    return max(facing, key=lambda pair: min(each.stations for each in pair), default=None)


def turn(one: Wall, other: Wall) -> float:
    """By how much two walls do not face each other [rad]."""
    return float(wrap(one.normal_angle - other.normal_angle + np.pi))


def open_ways(found: FeatureMap) -> Iterator[tuple[str, str]]:
    """Describe where only odometry gives the position."""
    learned: Any = found.parameters["found"]
    ways = learned["undetermined"]
    yield "sweeps placed by odometry alone", str(sum(way["last"] - way["first"] + 1 for way in ways))
    if ways:
        yield "along over across (median)", f"{np.median([way['along'] / way['across'] for way in ways]):.1f}"


if __name__ == "__main__":
    main()
