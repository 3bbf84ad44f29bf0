"""Poses corrected by sonar on random drives: python benchmarks/poses.py [DRIVES] [--array NAME] [--noisy].

Simulates drives through random rooms (50 by default) with odometry that is off by 2 % of the way and 2 degrees a metre,
maps them with ``--poses correct``, and prints the errors of poses and features, the worst drives, the scores of maps of
the same echoes from the true poses, the readings of walls that were missed, and the consistency of the pose
covariances.  ``--array`` and ``--stations`` choose another built-in rig and another number of stations than 22.
``--noisy`` doubles the errors of odometry, with 8 % dropouts and 6 % strays.  ``--slip`` adds sideways slip: its
standard deviation [m] on the first metre, growing with the root of the way.  ``--air`` sets how much warmer or colder
the air may be than the modules assume [degrees], which no drive can observe without a ``--thermometer`` of the given
standard deviation [degrees].  ``--specified`` specifies this share of the errors of odometry in the rig, 1 for all.
``--lag`` sets the largest lag of the servo behind the commanded angle [s].  ``--exact FOLDER`` also maps recordings
with exact poses, once trusted and once corrected, to measure the harm of a needless correction.  ``--save FILE`` writes
the figures of each drive as JSON.
"""

import argparse
import json
import math
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path

import numpy as np

from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import Consistency, Evaluation, consistency_table, evaluate, pool, tally_table
from echoplan.evaluation.consistency import pool_consistency
from echoplan.io import read_recording, read_truth, rig_names
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.methods import map_sweeps
from echoplan.model import FeatureClass, Rig, Source, Sweep, Table, Truth
from echoplan.simulation import OdometryNoise
from library.oracle_readings import readings_of
from library.rooms import ARRAY, DRIFT, LEGS, Drive, random_drive

DRIVES = 50
WORST = 5
# Least number of readings by which a station has detected a wall.
CLEAR = 3
# Names of recordings whose poses are exact.
EXACT = ("room*", "oblique*")
DOUBLE = OdometryNoise(**{name: 2 * value for name, value in DRIFT.model_dump().items()})
QUIET, NOISY = (0.02, 0.02), (0.08, 0.06)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """One drive: its map and its evaluation.

    Parameters
    ----------
    name : str
        Of the drive.
    evaluation : Evaluation
        The map against the truth.
    odometry_errors : tuple of float
        Root mean square errors of position [m] and heading [rad] by odometry alone.
    sweeps : int
        How many were mapped.
    seconds : float
        Of the processor.
    undrifted : Evaluation, optional
        As the evaluation, of a map of the same echoes from the true poses.
    traces : dict of int to ndarray of int, optional
        By the number of a wall that was missed, how many readings of each sweep may be of it.
    """

    name: str
    evaluation: Evaluation
    odometry_errors: tuple[float, float]
    sweeps: int
    seconds: float
    undrifted: Evaluation | None = None
    traces: Mapping[int, np.ndarray] = field(default_factory=dict)


def main() -> None:
    """Map all drives and print tables."""
    arguments = parse()
    with ProcessPoolExecutor(arguments.workers) as workers:
        runs = workers.map(partial(drive, how=conditions(arguments)), range(arguments.drives))
        outcomes = list(tracked(runs, total=arguments.drives, task="mapping"))
    for table in (*tables(outcomes), *harm(arguments.exact)):
        show(table)
    if arguments.save:
        arguments.save.write_text(json.dumps(document(outcomes)) + "\n", encoding="utf-8")


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Poses corrected by sonar on random drives.")
    parser.add_argument("drives", type=int, nargs="?", default=DRIVES)
    parser.add_argument("--array", choices=rig_names(), default=ARRAY)
    parser.add_argument("--stations", type=int, default=LEGS)
    parser.add_argument("--noisy", action="store_true")
    parser.add_argument("--slip", type=float, default=0.0)
    parser.add_argument("--air", type=float, default=0.0)
    parser.add_argument("--thermometer", type=float, default=math.inf)
    parser.add_argument("--specified", type=float)
    parser.add_argument("--lag", type=float, default=0.0)
    parser.add_argument("--exact", type=Path)
    parser.add_argument("--workers", type=int)
    parser.add_argument("--save", type=Path)
    return parser.parse_args()


def conditions(arguments: argparse.Namespace) -> Drive:
    """Conditions of the drives."""
    odometry, (dropout, stray) = (DOUBLE, NOISY) if arguments.noisy else (DRIFT, QUIET)
    return Drive(
        array=arguments.array,
        stations=arguments.stations,
        odometry=odometry.model_copy(update={"lateral": arguments.slip}),
        dropout=dropout,
        stray=stray,
        air=arguments.air,
        lag=arguments.lag,
        thermometer=arguments.thermometer,
        specified=arguments.specified,
    )


def drive(seed: int, *, how: Drive) -> Outcome:
    """Map one drive and compare the map with the truth."""
    simulation = random_drive(seed, how)
    outcome = mapped(simulation, tuple(simulation), simulation.truth, PoseMode.CORRECT)
    # Odometry does not change the echoes.
    undrifted = random_drive(seed, replace(how, odometry=OdometryNoise()))
    sweeps, truth, walls = tuple(undrifted), undrifted.truth, outcome.evaluation.matches.walls
    trusted = mapped(undrifted, sweeps, truth, PoseMode.TRUST)
    missed = sorted(set(walls.wanted) - set(walls.found))
    traces = {number: readings_of(truth.walls_xy[number], sweeps, undrifted.rig) for number in missed}
    return replace(outcome, undrifted=trusted.evaluation, traces=traces)


def mapped(source: Source, sweeps: Sequence[Sweep], truth: Truth, poses: PoseMode) -> Outcome:
    """Map sweeps, and measure the CPU time."""
    rig: Rig = source.rig
    begun = time.process_time()
    feature_map = map_sweeps(JointMapper(rig, JointSettings(poses=poses)), sweeps)
    seconds = time.process_time() - begun
    off = truth.given - truth.poses
    turned = np.angle(np.exp(1j * off[:, 2]))
    return Outcome(
        name=source.name,
        evaluation=evaluate(feature_map, truth),
        odometry_errors=(root_mean_square(np.hypot(off[:, 0], off[:, 1])), root_mean_square(turned)),
        sweeps=len(sweeps),
        seconds=seconds,
    )


def root_mean_square(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def tables(outcomes: Sequence[Outcome]) -> list[Table]:
    """Lay out errors, the worst drives, recall and precision, and whether covariances are true."""
    summary = pool((each.evaluation for each in outcomes), rng=np.random.default_rng(0))
    return [
        error_table(outcomes),
        worst_table(outcomes),
        tally_table({name: each.tally for name, each in summary.classes.items()}),
        undrifted_table(outcomes),
        missed_table(outcomes),
        consistency_table({name: each.consistency for name, each in summary.classes.items()}),
        ellipse_table(outcomes),
    ]


def error_table(outcomes: Sequence[Outcome]) -> Table:
    """Mean, median and maximum of the errors of drives."""
    rows = [(name, *(f"{each:.2f}" for each in spread(values))) for name, values in errors(outcomes).items()]
    return Table(
        title=f"{len(outcomes)} drives", columns=("of each drive", "mean", "median", "worst"), rows=tuple(rows)
    )


def errors(outcomes: Sequence[Outcome]) -> Mapping[str, list[float]]:
    """List what is measured of each drive."""
    trajectories = [each.evaluation.trajectory for each in outcomes if each.evaluation.trajectory]
    matches = [each.evaluation.matches for each in outcomes]
    return {
        "ATE by dead reckoning (mm)": [1000 * each.odometry_errors[0] for each in outcomes],
        "heading by dead reckoning (°)": [float(np.degrees(each.odometry_errors[1])) for each in outcomes],
        "ATE (mm)": [1000 * each.absolute_error for each in trajectories],
        "RPE (mm)": [1000 * each.relative_error for each in trajectories],
        "heading (°)": [float(np.degrees(each.heading_error)) for each in trajectories],
        "walls (mm)": [1000 * match.distance for each in matches for match in each.walls.right],
        "walls (°)": [float(np.degrees(match.angle)) for each in matches for match in each.walls.right],
        "corners (mm)": [1000 * match.distance for each in matches for match in each.corners.right],
        "cylinders (mm)": [1000 * match.distance for each in matches for match in each.cylinders.right],
        "time a sweep (ms)": [1000 * each.seconds / each.sweeps for each in outcomes],
    }


def spread(values: Sequence[float]) -> tuple[float, float, float]:
    """Mean, median and maximum; nan of nothing."""
    return (float(np.mean(values)), float(np.median(values)), float(np.max(values))) if values else (np.nan,) * 3


def undrifted_table(outcomes: Sequence[Outcome]) -> Table:
    """Scores of maps of the same echoes from the true poses."""
    summary = pool((each.undrifted for each in outcomes if each.undrifted), rng=np.random.default_rng(0))
    table = tally_table({name: each.tally for name, each in summary.classes.items()})
    return replace(table, title="The same from the true poses")


def missed_table(outcomes: Sequence[Outcome]) -> Table:
    """List the readings of walls that were missed, the faintest first."""
    found = [(each.name, number, trace) for each in outcomes for number, trace in each.traces.items()]
    rows = [
        (name, str(number), str(trace.sum()), str((trace >= CLEAR).sum()))
        for name, number, trace in sorted(found, key=lambda each: int(each[2].sum()))
    ]
    columns = ("drive", "wall", "readings that may be of it", f"stations with {CLEAR} and more")
    return Table(title="Walls that were missed", columns=columns, rows=tuple(rows))


def worst_table(outcomes: Sequence[Outcome]) -> Table:
    """List the drives whose poses are farthest off."""
    order = sorted(outcomes, key=ate, reverse=True)[:WORST]
    rows = [
        (
            each.name,
            f"{1000 * ate(each):.1f}",
            f"{1000 * each.odometry_errors[0]:.0f}",
            str(walls.found),
            str(walls.wanted),
        )
        for each in order
        for walls in (each.evaluation.matches.walls.tally,)
    ]
    columns = ("drive", "ATE (mm)", "by dead reckoning", "walls found", "wanted")
    return Table(title="The worst drives", columns=columns, rows=tuple(rows))


def ate(outcome: Outcome) -> float:
    """Absolute trajectory error [m]."""
    trajectory = outcome.evaluation.trajectory
    return trajectory.absolute_error if trajectory else np.inf


def ellipse_table(outcomes: Sequence[Outcome]) -> Table:
    """Consistency of the pose covariances."""
    pooled = poses_consistency(outcomes)
    rows = [
        (name, str(len(each.nees)), f"{each.mean:.2f}", str(each.parameters), f"{100 * each.share_inside:.1f}")
        for name, each in pooled.items()
    ]
    columns = ("poses", "count", "mean NEES", "ideal", "inside 95 % (%)")
    return Table(title="Are poses as certain as they say?", columns=columns, rows=tuple(rows))


def poses_consistency(outcomes: Sequence[Outcome]) -> Mapping[str, Consistency]:
    """Pool errors of poses against their covariances."""
    trajectories = [each.evaluation.trajectory for each in outcomes if each.evaluation.trajectory]
    return {
        "position": pool_consistency((each.positions for each in trajectories), parameters=2),
        "heading": pool_consistency((each.headings for each in trajectories), parameters=1),
    }


def harm(folder: Path | None) -> list[Table]:
    """Map recordings with exact poses, trusted and corrected."""
    found = sorted(path for name in EXACT for path in folder.glob(name)) if folder else []
    rows = [(path.name, *cells) for path in found for cells in exact(path)]
    columns = ("recording", "poses", "walls", "right", "walls (mm)", "ATE (mm)")
    return [Table(title="Exact poses", columns=columns, rows=tuple(rows))] if rows else []


def exact(folder: Path) -> list[tuple[str, ...]]:
    """Map one recording with exact poses in both ways."""
    source, truth = read_recording(folder), read_truth(folder / "truth.json")
    sweeps, rows = tuple(source), list[tuple[str, ...]]()
    for mode in (PoseMode.TRUST, PoseMode.CORRECT):
        outcome = mapped(source, sweeps, truth, mode)
        walls = outcome.evaluation.matches.walls
        off = 1000 * float(np.mean([match.distance for match in walls.right])) if walls.right else np.nan
        counts = (f"{walls.tally.found}/{walls.tally.wanted}", f"{walls.tally.right}/{walls.tally.estimates}")
        rows.append((mode.value, *counts, f"{off:.2f}", f"{1000 * ate(outcome):.1f}"))
    return rows


def document(outcomes: Sequence[Outcome]) -> dict[str, object]:
    """Keep the figures of all drives for other programs, with their units in the names."""
    summary = pool((each.evaluation for each in outcomes), rng=np.random.default_rng(0))
    return {
        "drives": len(outcomes),
        "errors": {name: [round(value, 4) for value in values] for name, values in errors(outcomes).items()},
        "recall": {name: summary.classes[name].recall.value for name in FeatureClass},
        "precision": {name: summary.classes[name].precision.value for name in FeatureClass},
        "nees": {name: [round(v, 3) for v in each.nees.tolist()] for name, each in poses_consistency(outcomes).items()},
    }


if __name__ == "__main__":
    main()
