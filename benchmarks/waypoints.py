"""Way-points that nobody measured well: python benchmarks/waypoints.py FOLDER... [--off METRES] [--copies N] ...

Maps each recording as it is, and copies of it whose headings are all zero and whose way-points are each off by so many
metres in some direction (5 cm unless told otherwise), all of them together neither moved nor turned.  Prints how much
of the walls is found and right, how far they are off, and, but for one turn of all, how far headings are from those of
the recording as it is, and from those that all copies have in the median.  ``--poses correct`` asks for correction
instead of leaving it to doubt.  ``--told`` does not map the copies: it adjusts what was made of the recording as it is
to their way-points, to show how far these alone bring walls off.
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
from library.known_associations import told_map

OFF, COPIES = 0.05, 12
MIN_HEARD = 1


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """What came of one copy, or of the recording itself."""

    name: str
    walls: Tally
    distances: list[float]
    angles: list[float]
    headings: np.ndarray


def main() -> None:
    """Map all and print what came of it."""
    arguments = parse()
    cases = list(product(arguments.folders, [None, *range(arguments.copies)]))
    with ProcessPoolExecutor() as workers:
        run = partial(mapped, off=arguments.off, poses=arguments.poses, told=arguments.told)
        outcomes = list(workers.map(run, cases))
    tables = [outcomes[first : first + arguments.copies + 1] for first in range(0, len(cases), arguments.copies + 1)]
    show(table(rows(tables)))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Way-points that nobody measured well.")
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--off", type=float, default=OFF)
    parser.add_argument("--copies", type=int, default=COPIES)
    parser.add_argument("--poses", type=PoseMode, choices=list(PoseMode), default=PoseMode.AUTO)
    parser.add_argument("--told", action="store_true")
    return parser.parse_args()


def mapped(case: tuple[Path, int | None], *, off: float, poses: PoseMode, told: bool) -> Outcome:
    """Map a copy and hold it against the truth."""
    folder, copy = case
    recording, truth = read_recording(folder), read_truth(folder / "truth.json")
    itself = list(recording)
    sweeps = itself if copy is None else astray(itself, off, np.random.default_rng(copy))
    if told and copy is not None:
        found = told_map(recording.rig, itself, sweeps, off=off)
    else:
        found = map_sweeps(JointMapper(recording.rig, JointSettings(poses=poses)), sweeps)
    walls = evaluate(found, truth, EvaluationSettings(matching=MatchingSettings(min_heard=MIN_HEARD))).matches.walls
    return Outcome(
        name=folder.name,
        walls=walls.tally,
        distances=[1000 * each.distance for each in walls.right],
        angles=[float(np.degrees(each.angle)) for each in walls.right],
        headings=found.poses[:, 2],
    )


def astray(sweeps: list[Sweep], off: float, rng: np.random.Generator) -> list[Sweep]:
    """Forget all headings, and put each way-point elsewhere, but all of them together neither moved nor turned."""
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
    astray, apart = list[np.ndarray](), list[np.ndarray]()
    for itself, *copies in tables:
        nothing = np.zeros_like(itself.headings)
        lines.append(row(itself.name, [itself], nothing, nothing))
        off = differences(copies, itself)
        astray.append(off.ravel())
        apart.append((off - np.median(off, axis=0)).ravel())
        lines.append(row(f"{itself.name}, {len(copies)} copies", copies, astray[-1], apart[-1]))
        everything += copies
    return [*lines, row("all copies", everything, np.concatenate(astray), np.concatenate(apart))]


def differences(copies: list[Outcome], itself: Outcome) -> np.ndarray:
    """Tell how far headings are from those of the recording as it is, but for a turn of all, by copy [deg]."""
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
    return Table(title="Headings forgotten, way-points astray", columns=columns, rows=tuple(lines))


if __name__ == "__main__":
    main()
