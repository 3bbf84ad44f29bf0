"""Inexact waypoints: python benchmarks/waypoints.py FOLDER... [--off METRES] [--copies N] [--known-associations].

Maps each recording, and copies of it whose headings are all zero and whose waypoints are each displaced by a fixed
distance in a random direction (5 cm by default), without moving or turning all of them together.  Prints recall and
precision of walls, their errors, and the differences between the headings and those of the recording itself, and those
that all copies have in the median, up to a common rotation.  ``--poses correct`` demands a correction.
``--known-associations`` does not map the copies: it adjusts the map of the recording to their waypoints, which shows
how much these alone displace walls.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path

import numpy as np

from echoplan.cli.terminal import show
from echoplan.evaluation import EvaluationSettings, MatchingSettings, evaluate
from echoplan.evaluation.tally import Tally
from echoplan.geometry import directions, wrap
from echoplan.io import read_recording, read_truth
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.methods import map_sweeps
from echoplan.model import Sweep, Table
from library.known_associations import map_with_known_associations

OFF, COPIES = 0.05, 12
MIN_STATIONS = 1


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """The map of one copy, or of the recording itself."""

    name: str
    walls: Tally
    distances: list[float]
    angles: list[float]
    headings: np.ndarray


def main() -> None:
    """Map all and print a table."""
    arguments = parse()
    cases = list(product(arguments.folders, [None, *range(arguments.copies)]))
    with ProcessPoolExecutor() as workers:
        run = partial(mapped, off=arguments.off, poses=arguments.poses, known_associations=arguments.known_associations)
        outcomes = list(workers.map(run, cases))
    tables = [outcomes[first : first + arguments.copies + 1] for first in range(0, len(cases), arguments.copies + 1)]
    show(table(rows(tables)))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Inexact waypoints.")
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--off", type=float, default=OFF)
    parser.add_argument("--copies", type=int, default=COPIES)
    parser.add_argument("--poses", type=PoseMode, choices=list(PoseMode), default=PoseMode.AUTO)
    parser.add_argument("--known-associations", action="store_true")
    return parser.parse_args()


def mapped(case: tuple[Path, int | None], *, off: float, poses: PoseMode, known_associations: bool) -> Outcome:
    """Map a copy and compare it with the truth."""
    folder, copy = case
    recording, truth = read_recording(folder), read_truth(folder / "truth.json")
    itself = list(recording)
    sweeps = itself if copy is None else at_poses(itself, off, np.random.default_rng(copy))
    if known_associations and copy is not None:
        found = map_with_known_associations(recording.rig, itself, sweeps, off=off)
    else:
        found = map_sweeps(JointMapper(recording.rig, JointSettings(poses=poses)), sweeps)
    walls = evaluate(
        found, truth, EvaluationSettings(matching=MatchingSettings(min_stations=MIN_STATIONS))
    ).matches.walls
    return Outcome(
        name=folder.name,
        walls=walls.tally,
        distances=[1000 * each.distance for each in walls.right],
        angles=[float(np.degrees(each.angle)) for each in walls.right],
        headings=found.poses[:, 2],
    )


def at_poses(sweeps: list[Sweep], off: float, rng: np.random.Generator) -> list[Sweep]:
    """Set all headings to zero and displace each waypoint, without moving or turning all of them together."""
    steps = off * directions(rng.uniform(-np.pi, np.pi, len(sweeps)))
    steps -= steps.mean(axis=0)
    places = np.array([each.map_from_base[0, :2] for each in sweeps])
    arms = quarter(places - places.mean(axis=0))
    steps -= arms * np.sum(arms * steps) / np.sum(arms**2)
    return [
        replace(each, map_from_base=np.column_stack([each.map_from_base[:, :2] + step, np.zeros(len(each))]))
        for each, step in zip(sweeps, steps, strict=True)
    ]


def quarter(vectors: np.ndarray) -> np.ndarray:
    """Turn vectors by a quarter to the left."""
    return np.column_stack([-vectors[:, 1], vectors[:, 0]])


def rows(tables: list[list[Outcome]]) -> list[tuple[str, ...]]:
    """Sum up each recording and its copies, and the copies of all."""
    lines, everything = list[tuple[str, ...]](), list[Outcome]()
    displacements, apart = list[np.ndarray](), list[np.ndarray]()
    for itself, *copies in tables:
        nothing = np.zeros_like(itself.headings)
        lines.append(row(itself.name, [itself], nothing, nothing))
        off = differences(copies, itself)
        displacements.append(off.ravel())
        apart.append((off - np.median(off, axis=0)).ravel())
        lines.append(row(f"{itself.name}, {len(copies)} copies", copies, displacements[-1], apart[-1]))
        everything += copies
    return [*lines, row("all copies", everything, np.concatenate(displacements), np.concatenate(apart))]


def differences(copies: list[Outcome], itself: Outcome) -> np.ndarray:
    """Differences of the headings from those of the recording itself, up to a common rotation, by copy [deg]."""
    turned = np.array([wrap(each.headings - itself.headings) for each in copies])
    return np.degrees(wrap(turned - np.median(turned, axis=1, keepdims=True)))


def row(name: str, outcomes: list[Outcome], off: np.ndarray, apart: np.ndarray) -> tuple[str, ...]:
    """Lay out recall, precision, errors, and the differences of headings."""
    tally = sum((each.walls for each in outcomes[1:]), start=outcomes[0].walls)
    return (
        name,
        f"{100 * tally.found / tally.wanted:.0f} / {100 * tally.right / tally.estimates:.0f}",
        f"{np.mean([value for each in outcomes for value in each.distances]):.1f}",
        f"{np.mean([value for each in outcomes for value in each.angles]):.2f}",
        *(f"{np.abs(each).mean():.1f}, {np.abs(each).max():.1f}" for each in (off, apart)),
    )


def table(lines: list[tuple[str, ...]]) -> Table:
    """Lay out all rows."""
    columns = ("recording", "walls, recall / precision (%)", "mm", "°", "headings off (°), at most", "apart, at most")
    return Table(title="Headings removed, waypoints displaced", columns=columns, rows=tuple(lines))


if __name__ == "__main__":
    main()
