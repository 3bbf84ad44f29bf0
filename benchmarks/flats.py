"""The method joint in random flats: python benchmarks/flats.py [FLATS] [--first SEED], or --write DIR --seeds 0-19.

Simulates so many flats (20 by default) of two to four rooms with doors and furniture, maps them, and prints how
complete and exact the maps are: flats with exact poses, flats with odometry that drifts (2 % of the way, 2 degrees a
metre), and all of them; then each flat by itself.  ``--write`` writes flats as recordings with truth instead:
DIR/flat00 and so on.
"""

import argparse
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import (
    ErrorSummary,
    Evaluation,
    EvaluationSettings,
    MatchingSettings,
    consistency_table,
    evaluate,
    floor_plan_tables,
    pool,
)
from echoplan.io import write_recording, write_truth
from echoplan.joint.settings import PoseMode
from echoplan.model import FeatureClass, Table
from library.flats import is_drifting, random_flat
from library.jambs import JambErrors, jamb_errors
from library.mapping import map_by_joint
from library.score_tables import percent

# Seeds below 300 were looked at while the method was written.
FLATS, FIRST = 20, 300


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """The map of one flat against the truth."""

    seed: int
    evaluation: Evaluation
    jambs: JambErrors
    stations: int
    seconds: float


def main() -> None:
    """Map all flats and print the scores, or write them as recordings."""
    arguments = parse()
    if arguments.write:
        for seed in arguments.seeds:
            write(arguments.write / f"flat{seed:02d}", seed)
        return
    seeds = range(arguments.first, arguments.first + arguments.flats)
    with ProcessPoolExecutor() as workers:
        outcomes = list(tracked(workers.map(run, seeds), total=len(seeds), task="mapping"))
    for table in tables(outcomes):
        show(table)


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="The method joint in random flats.")
    parser.add_argument("flats", type=int, nargs="?", default=FLATS, help="how many flats to map")
    parser.add_argument("--first", type=int, default=FIRST, metavar="SEED", help="seed of the first flat")
    parser.add_argument("--write", type=Path, metavar="DIR", help="write recordings with truth to this folder instead")
    parser.add_argument("--seeds", type=seed_range, default=range(FLATS), metavar="A-B", help="seeds to write")
    return parser.parse_args()


def seed_range(text: str) -> range:
    """Read a range of seeds: 3, or 0-19, both included."""
    first, _, last = text.partition("-")
    return range(int(first), int(last or first) + 1)


def write(folder: Path, seed: int) -> None:
    """Write a flat as a recording: pings.csv, rig.toml, truth.json."""
    simulation = random_flat(seed)
    write_recording(folder, simulation)
    write_truth(folder / "truth.json", simulation.truth)


def run(seed: int) -> Outcome:
    """Simulate one flat, map it and compare the map with the truth."""
    simulation = random_flat(seed)
    sweeps = tuple(simulation)
    feature_map, seconds = map_by_joint(simulation, sweeps, PoseMode.AUTO, driven=True)
    reach = max(each.max_range for each in simulation.rig.sensors)
    settings = EvaluationSettings(matching=MatchingSettings(opening_reach=reach))
    return Outcome(
        seed=seed,
        evaluation=evaluate(feature_map, simulation.truth, settings),
        jambs=jamb_errors(feature_map, simulation.truth, reach=reach),
        stations=len(sweeps),
        seconds=seconds,
    )


def tables(outcomes: Sequence[Outcome]) -> list[Table]:
    """Lay out all scores: by kind of poses, and flat by flat."""
    groups = {
        "exact": [each for each in outcomes if not is_drifting(each.seed)],
        "drifting": [each for each in outcomes if is_drifting(each.seed)],
        "all": outcomes,
    }
    summaries = {f"{len(members)} {name}": summed(members) for name, members in groups.items() if members}
    plans = {name: summary.floor_plan for name, summary in summaries.items()}
    return [
        feature_table(summaries),
        *floor_plan_tables(plans, rows="flats"),
        jamb_table(groups),
        consistency_table({kind: each.consistency for kind, each in summed(outcomes).classes.items()}),
        flat_table(outcomes),
    ]


def summed(outcomes: Sequence[Outcome]) -> ErrorSummary:
    """Pool flats."""
    return pool((each.evaluation for each in outcomes), rng=np.random.default_rng(0))


def feature_table(summaries: Mapping[str, ErrorSummary]) -> Table:
    """Lay out recall, precision and errors of walls, corners and cylinders."""
    rows = [
        (
            f"{name}: {kind}s",
            str(each.tally.wanted),
            percent(each.recall),
            percent(each.precision),
            f"{1000 * each.distance.median.value:.2f}",
            f"{1000 * each.distance.percentile95.value:.1f}",
        )
        for name, summary in summaries.items()
        for kind, each in summary.classes.items()
    ]
    return Table(
        title="joint in random flats [95 % intervals over flats]",
        columns=("flats", "wanted", "recall (%)", "precision (%)", "median error (mm)", "95th percentile"),
        rows=tuple(rows),
    )


def jamb_table(groups: Mapping[str, Sequence[Outcome]]) -> Table:
    """Lay out how far jambs are off, and how far the middle between the nearest feet would be."""
    rows = []
    for name, members in groups.items():
        mapped = [error for each in members for error in each.jambs.mapped]
        halfway = [error for each in members for error in each.jambs.halfway]
        if mapped:
            rows.append((name, str(len(mapped)), f"{1000 * np.mean(mapped):.0f}", f"{1000 * np.mean(halfway):.0f}"))
    return Table(
        title="Jambs between two feet of perpendiculars, mean distance",
        columns=("flats", "jambs", "mapped (mm)", "halfway between the feet (mm)"),
        rows=tuple(rows),
    )


def flat_table(outcomes: Sequence[Outcome]) -> Table:
    """Lay out each flat by itself: walls and cylinders found, missed and false, the poses, the time."""
    return Table(
        title="Flat by flat: found / missed / false or duplicate",
        columns=(
            "seed",
            "poses",
            "stations",
            "walls",
            "cylinders",
            "openings",
            "walked through",
            "poses off (mm)",
            "seconds",
        ),
        rows=tuple(
            (
                str(each.seed),
                "drifting" if is_drifting(each.seed) else "exact",
                str(each.stations),
                counts(each.evaluation, FeatureClass.WALL),
                counts(each.evaluation, FeatureClass.CYLINDER),
                opening_counts(each.evaluation),
                str(each.evaluation.floor_plan.lengths.walked_through),
                "-"
                if each.evaluation.trajectory is None
                else f"{1000 * each.evaluation.trajectory.absolute_error:.0f}",
                f"{each.seconds:.1f}",
            )
            for each in outcomes
        ),
    )


def counts(evaluation: Evaluation, kind: FeatureClass) -> str:
    """Count the features of a class that are found, missed, and false or duplicate."""
    matching = evaluation.matches.by_class[kind]
    missed = len(set(matching.wanted) - set(matching.found))
    return f"{len(matching.found)} / {missed} / {len(matching.spurious) + len(matching.duplicate)}"


def opening_counts(evaluation: Evaluation) -> str:
    """Count the openings that are found, missed, and false or duplicate."""
    tally = evaluation.floor_plan.openings
    return f"{tally.found} / {tally.wanted - tally.found} / {tally.estimates - tally.right}"


if __name__ == "__main__":
    main()
