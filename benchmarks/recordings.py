"""Scores on recordings with truth: python benchmarks/recordings.py FOLDER... [--methods A,B] [--noisy-copies N].

A folder is a recording (pings.csv, rig.toml, truth.json) or contains recordings; those without truth are skipped.
Prints a row for each recording and method, and a row for all recordings of a method together, with the CPU time of the
mapping after the compiled code for exact poses was loaded; then wall lengths, wall ends and openings in tables of their
own.  ``--noisy-copies`` scores copies with 1 mm of noise instead of the recordings themselves.
"""

import argparse
from collections.abc import Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from time import process_time

from echoplan.cli.terminal import show
from echoplan.evaluation import (
    Evaluation,
    EvaluationSettings,
    FloorPlanScore,
    MatchingSettings,
    evaluate,
    floor_plan_tables,
)
from echoplan.io import read_recording, read_truth
from echoplan.methods import METHODS, find_method, map_sweeps
from echoplan.model import Table
from echoplan.sources import open_source
from library.noisy_copies import noisy_copy
from library.score_tables import SCORE_COLUMNS, score_row


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """A recording to be mapped by a method."""

    folder: Path
    method: str
    min_stations: int
    copy: int | None = None

    @property
    def name(self) -> str:
        """Its name, and which copy it is."""
        return self.folder.name if self.copy is None else f"{self.folder.name}, copy {self.copy + 1}"


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """A mapped recording."""

    case: Case
    evaluation: Evaluation
    seconds: float


def main() -> None:
    """Map every recording with every method and print the scores."""
    arguments = parse()
    folders = [found for folder in arguments.folders for found in recordings(folder)]
    methods = arguments.methods.split(",")
    cases = [
        Case(folder=folder, method=method, min_stations=arguments.min_stations, copy=copy)
        for method, folder, copy in product(methods, folders, range(arguments.noisy_copies) or [None])
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
    parser.add_argument("--min-stations", type=int, default=2)
    parser.add_argument("--noisy-copies", type=int, default=0)
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
    """Map one recording and compare the map with its truth."""
    recording = read_recording(case.folder)
    start = process_time()
    feature_map = map_sweeps(find_method(case.method).build(recording.rig), noisy_copy(recording, case.copy))
    seconds = process_time() - start
    matching = MatchingSettings(min_stations=case.min_stations, opening_reach=float(recording.rig.max_ranges.max()))
    truth = read_truth(case.folder / "truth.json")
    return Outcome(
        case=case,
        evaluation=evaluate(feature_map, truth, EvaluationSettings(matching=matching)),
        seconds=seconds,
    )


def tables(method: str, outcomes: list[Outcome]) -> tuple[Table, ...]:
    """Lay out the scores of one method."""
    rows = [score_row(outcome.case.name, [outcome.evaluation], outcome.seconds) for outcome in outcomes]
    total = score_row("all", [outcome.evaluation for outcome in outcomes], sum(outcome.seconds for outcome in outcomes))
    title = f"{method}: recall / precision (%), mean deviation"
    plans = {outcome.case.name: outcome.evaluation.floor_plan for outcome in outcomes}
    plans["all"] = sum(plans.values(), start=FloorPlanScore())
    return Table(title=title, columns=SCORE_COLUMNS, rows=(*rows, total)), *floor_plan_tables(
        plans, rows=SCORE_COLUMNS[0]
    )


if __name__ == "__main__":
    main()
