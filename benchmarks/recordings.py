"""Scores of methods on recordings with truth: python benchmarks/recordings.py FOLDER... [--methods A,B] [--shaken N].

A folder is a recording (pings.csv, rig.toml, truth.json) or holds recordings; those without truth are passed over.
Prints a row for each recording and method, and a row for all recordings of a method together, with the seconds of
the processor that mapping took, once the compiled code for exact poses was loaded; then wall lengths, wall ends and
openings in tables of their own.  ``--shaken`` scores copies with
a millimetre of noise instead of the recordings themselves.
"""

import argparse
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from math import degrees
from pathlib import Path
from time import process_time

import numpy as np

from echoplan.cli.terminal import show
from echoplan.evaluation import (
    Evaluation,
    EvaluationSettings,
    FloorPlanScore,
    MatchingSettings,
    Summary,
    evaluate,
    floor_plan_tables,
    pool,
)
from echoplan.io import read_recording, read_truth
from echoplan.methods import METHODS, find_method, map_sweeps
from echoplan.model import FeatureClass, Table
from echoplan.sources import open_source
from library.noisy_copies import shaken

COLUMNS = ("recording", "walls", "mm", "deg", "corners", "mm", "cylinders", "mm", "radius mm", "seconds")


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A recording to be mapped by a method."""

    folder: Path
    method: str
    min_heard: int
    copy: int | None = None

    @property
    def name(self) -> str:
        """Its name, and which copy it is."""
        return self.folder.name if self.copy is None else f"{self.folder.name}, copy {self.copy + 1}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What came of it."""

    case: Case
    evaluation: Evaluation
    seconds: float


def main() -> None:
    """Map every recording with every method and print the scores."""
    arguments = parse()
    folders = [found for folder in arguments.folders for found in recordings(folder)]
    methods = arguments.methods.split(",")
    cases = [
        Case(folder=folder, method=method, min_heard=arguments.min_heard, copy=copy)
        for method, folder, copy in product(methods, folders, range(arguments.shaken) or [None])
    ]
    with ProcessPoolExecutor(initializer=warm_up, initargs=(methods,)) as workers:
        outcomes = list(workers.map(run, cases))
    for method in methods:
        for scores in tables(method, [outcome for outcome in outcomes if outcome.case.method == method]):
            show(scores)


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Scores of methods on recordings with truth.")
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--methods", default=",".join(METHODS))
    parser.add_argument("--min-heard", type=int, default=2)
    parser.add_argument("--shaken", type=int, default=0)
    return parser.parse_args()


def recordings(folder: Path) -> list[Path]:
    """Find the recordings with truth in a folder."""
    inside = [folder, *sorted(path for path in folder.iterdir() if path.is_dir())]
    return [path for path in inside if (path / "truth.json").exists() and (path / "pings.csv").exists()]


def warm_up(methods: Iterable[str]) -> None:
    """Map a small room by each method: what only drives need is still to be loaded."""
    source = open_source("sim:square")
    for method in methods:
        map_sweeps(find_method(method).build(source.rig), source)


def run(case: Case) -> Outcome:
    """Map one recording and hold the map against its truth."""
    recording = read_recording(case.folder)
    start = process_time()
    feature_map = map_sweeps(find_method(case.method).build(recording.rig), shaken(recording, case.copy))
    seconds = process_time() - start
    matching = MatchingSettings(min_heard=case.min_heard, opening_reach=float(recording.rig.max_ranges.max()))
    truth = read_truth(case.folder / "truth.json")
    return Outcome(
        case=case,
        evaluation=evaluate(feature_map, truth, EvaluationSettings(matching=matching)),
        seconds=seconds,
    )


def tables(method: str, outcomes: list[Outcome]) -> tuple[Table, ...]:
    """Lay out the scores of one method."""
    rows = [row(outcome.case.name, [outcome.evaluation], outcome.seconds) for outcome in outcomes]
    total = row("all", [outcome.evaluation for outcome in outcomes], sum(outcome.seconds for outcome in outcomes))
    title = f"{method}: recall / precision (%), mean deviation"
    plans = {outcome.case.name: outcome.evaluation.floor_plan for outcome in outcomes}
    plans["all"] = sum(plans.values(), start=FloorPlanScore())
    return Table(title=title, columns=COLUMNS, rows=(*rows, total)), *floor_plan_tables(plans, rows=COLUMNS[0])


def row(name: str, evaluations: Iterable[Evaluation], seconds: float) -> tuple[str, ...]:
    """Write one row of scores."""
    summary = pool(evaluations, rng=np.random.default_rng(0))
    walls, corners, cylinders = (FeatureClass.WALL, FeatureClass.CORNER, FeatureClass.CYLINDER)
    return (
        name,
        shares(summary, walls),
        number(1000 * summary.classes[walls].distance.mean.value),
        number(degrees(summary.wall_angle.mean.value), digits=2),
        shares(summary, corners),
        number(1000 * summary.classes[corners].distance.mean.value),
        shares(summary, cylinders),
        number(1000 * summary.classes[cylinders].distance.mean.value),
        number(1000 * summary.cylinder_radius.mean.value),
        number(seconds, digits=2),
    )


def shares(summary: Summary, name: FeatureClass) -> str:
    """Write recall and precision of a class."""
    of_class = summary.classes[name]
    return f"{number(100 * of_class.recall.value, digits=0)} / {number(100 * of_class.precision.value, digits=0)}"


def number(value: float, *, digits: int = 1) -> str:
    """Write a number, or a dash where nothing was measured."""
    return "-" if np.isnan(value) else f"{value:.{digits}f}"


if __name__ == "__main__":
    main()
