"""The method joint in random rooms: python benchmarks/joint.py [ROOMS] [--stations N] [--recess] ...

Simulates random rooms (100 by default) from 14 stations (``--stations``), maps them, and prints recall, precision and
errors, wall lengths and openings, the rooms with faults, the consistency of covariances and of class probabilities, the
errors in units of the Cramer-Rao bound, the estimated parameters of the sonar, and the CPU time.  The poses are exact;
``--poses trust`` says so to the method.  ``--misset`` gives the modules of each room a zero error of up to half of
their resolution, which is the error that the method assumes.  ``--recess`` adds a pier to one wall of each room, or a
niche.  ``--soft`` makes one wall of each room a curtain, a sofa or foam.  ``--round SIDES`` makes each room a polygon
of so many sides.  ``--by-hand M`` gives each of the two marks on which the robot stands, 0.2 m apart, a normal error of
M metres.  ``--save FILE`` writes the data that docs/joint_pictures.py draws.
"""

import argparse
import json
import math
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import (
    ErrorSummary,
    Evaluation,
    consistency_table,
    deviation_table,
    evaluate,
    floor_plan_tables,
    pool,
)
from echoplan.evaluation.consistency import PARAMETERS
from echoplan.io import rig_names
from echoplan.joint.settings import PoseMode
from echoplan.model import Corner, Cylinder, FeatureClass, FeatureMap, Sweep, Table, Wall
from echoplan.simulation import Simulation
from library.error_bound import against_bound, true_scale
from library.mapping import map_by_joint
from library.populations import random_round_room, random_soft_room
from library.rooms import ARRAY, STATIONS, is_oblique, random_simulation
from library.score_tables import fault_table, percent

ROOMS = 100
# The marks on which a robot is set down are so far apart [m].
MARKS = 0.2
# Borders between classes of confidence.
CONFIDENCES = (0.0, 0.5, 0.9, 0.99, 0.999, 1.0)
# Numbers of the sonar, and what turns them into units that are easily read.
LEARNED = {"range_offset": ("mm", 1e3), "range_scale": ("per mille", 1e3), "servo_latency": ("ms", 1e3)}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """One room: its map and its evaluation.

    Parameters
    ----------
    seed : int
        Of the room.
    evaluation : Evaluation
        Of the map.
    bounded : mapping of str to list of float
        NEES of walls and cylinders with the Cramer-Rao bound for their covariance.
    class_probabilities : list of tuple of float
        Probability that the map gives to the class of each feature, and 1 if it is right, else 0.
    learned : mapping of str to tuple of float
        Error of each number of the sonar, and its standard deviation by the map.
    pings : int
        How many were made.
    seconds : float
        CPU time of the mapping.
    """

    seed: int
    evaluation: Evaluation
    bounded: Mapping[str, list[float]]
    class_probabilities: list[tuple[float, float]]
    learned: Mapping[str, tuple[float, float]]
    pings: int
    seconds: float


def main() -> None:
    """Map all rooms and print tables."""
    arguments = parse()
    with ProcessPoolExecutor() as workers:
        rooms = {
            "array": arguments.array,
            "stations": arguments.stations,
            "misset": arguments.misset,
            "recess": arguments.recess,
        }
        simulate = random_soft_room if arguments.soft else partial(random_simulation, **rooms)
        simulate = partial(random_round_room, sides=arguments.round) if arguments.round else simulate
        chosen = partial(run, simulate=simulate, poses=arguments.poses, by_hand=arguments.by_hand)
        runs = workers.map(chosen, range(arguments.rooms))
        outcomes = list(tracked(runs, total=arguments.rooms, task="mapping"))
    for table in (*tables(outcomes), duration_table(outcomes)):
        show(table)
    if arguments.save:
        arguments.save.write_text(json.dumps(document(outcomes)) + "\n", encoding="utf-8")


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="The method joint in random rooms.")
    parser.add_argument("rooms", type=int, nargs="?", default=ROOMS)
    parser.add_argument("--array", choices=rig_names(), default=ARRAY)
    parser.add_argument("--stations", type=int, default=STATIONS)
    parser.add_argument("--poses", type=PoseMode, choices=list(PoseMode), default=PoseMode.AUTO)
    parser.add_argument("--misset", action="store_true")
    parser.add_argument("--recess", action="store_true")
    parser.add_argument("--soft", action="store_true")
    parser.add_argument("--round", type=int, metavar="SIDES")
    parser.add_argument("--by-hand", type=float, default=0.0)
    parser.add_argument("--save", type=Path)
    return parser.parse_args()


def run(
    seed: int,
    *,
    simulate: Callable[[int], Simulation] = random_simulation,
    poses: PoseMode = PoseMode.AUTO,
    by_hand: float = 0.0,
) -> Outcome:
    """Simulate one room, map it and compare the map with the truth."""
    simulation = simulate(seed)
    sweeps, truth = with_mark_errors(simulation, by_hand), simulation.truth
    feature_map, seconds = map_by_joint(simulation, sweeps, poses)
    evaluation = evaluate(feature_map, truth)
    return Outcome(
        seed=seed,
        evaluation=evaluation,
        bounded=against_bound(feature_map, truth, evaluation.matches, simulation=simulation, sweeps=sweeps),
        class_probabilities=class_probabilities_of(feature_map, evaluation),
        learned=learned_of(feature_map, simulation),
        pings=sum(map(len, sweeps)),
        seconds=seconds,
    )


def with_mark_errors(simulation: Simulation, error: float) -> tuple[Sweep, ...]:
    """Add the errors of the two marks to the pose of each station."""
    rng = np.random.default_rng((simulation.seed, 7))
    turned = math.sqrt(2.0) * error / MARKS
    return tuple(
        replace(sweep, map_from_base=sweep.map_from_base + rng.normal(0.0, (error, error, turned)))
        for sweep in simulation
    )


def class_probabilities_of(feature_map: FeatureMap, evaluation: Evaluation) -> list[tuple[float, float]]:
    """Probability of the class of each detected feature, and whether the class is right."""
    found: tuple[Sequence[Wall | Corner | Cylinder], ...] = (
        feature_map.walls,
        feature_map.corners,
        feature_map.cylinders,
    )
    return [
        (getattr(feature.class_probabilities, name), float(number not in matching.spurious))
        for (name, matching), features in zip(evaluation.matches.by_class.items(), found, strict=True)
        for number, feature in enumerate(features)
        if feature.pings
    ]


def learned_of(feature_map: FeatureMap, simulation: Simulation) -> dict[str, tuple[float, float]]:
    """Errors and standard deviations of the estimated parameters of the sonar."""
    found: Any = feature_map.parameters["found"]
    true = {
        "range_scale": true_scale(simulation),
        "range_offset": simulation.settings.zero_error,
        "servo_latency": simulation.settings.servo_latency,
    }
    return {name: (found[name]["value"] - true[name], found[name]["sigma"]) for name in LEARNED if name in found}


def tables(outcomes: Sequence[Outcome]) -> list[Table]:
    """Lay out everything but time."""
    summary = summed(outcomes)
    return [
        score_table(outcomes),
        *plan_tables(outcomes),
        deviation_table(summary),
        fault_table({each.seed: each.evaluation for each in outcomes}),
        consistency_table({name: each.consistency for name, each in summary.classes.items()}),
        bound_table(outcomes),
        probability_table(outcomes),
        sonar_table(outcomes),
    ]


def summed(outcomes: Sequence[Outcome]) -> ErrorSummary:
    """Pool rooms."""
    return pool((each.evaluation for each in outcomes), rng=np.random.default_rng(0))


def score_table(outcomes: Sequence[Outcome]) -> Table:
    """Recall, precision and errors by kind of room, by whether the poses were moved, and of all rooms."""
    rows = [
        (
            f"{len(members)} {group}: {name}s",
            str(each.tally.wanted),
            percent(each.recall),
            percent(each.precision),
            f"{1000 * each.distance.median.value:.2f}",
            f"{1000 * each.distance.percentile95.value:.1f}",
        )
        for group, members in grouped(outcomes).items()
        for name, each in summed(members).classes.items()
    ]
    return Table(
        title=f"joint in {len(outcomes)} random rooms [95 % intervals over rooms]",
        columns=("rooms", "wanted", "recall (%)", "precision (%)", "median error (mm)", "95th percentile"),
        rows=tuple(rows),
    )


def plan_tables(outcomes: Sequence[Outcome]) -> tuple[Table, ...]:
    """Lay out wall lengths, wall ends and openings, by the same groups."""
    plans = {f"{len(members)} {group}": summed(members).floor_plan for group, members in grouped(outcomes).items()}
    return floor_plan_tables(plans, rows="rooms")


def grouped(outcomes: Sequence[Outcome]) -> dict[str, Sequence[Outcome]]:
    """Group rooms by their kind and by the treatment of their poses; without empty groups."""
    groups = {
        "right-angled": [each for each in outcomes if not is_oblique(each.seed)],
        "oblique": [each for each in outcomes if is_oblique(each.seed)],
        "poses kept": [each for each in outcomes if not is_moved(each)],
        "poses moved": [each for each in outcomes if is_moved(each)],
        "all": outcomes,
    }
    return {group: members for group, members in groups.items() if members}


def is_moved(outcome: Outcome) -> bool:
    """Return True if the map moved the poses, which were right."""
    trajectory = outcome.evaluation.trajectory
    return trajectory is not None and trajectory.absolute_error > 0.0


def bound_table(outcomes: Sequence[Outcome]) -> Table:
    """Errors in units of the Cramer-Rao bound: root of NEES over the number of parameters."""
    rows = []
    for name in (FeatureClass.WALL, FeatureClass.CYLINDER):
        squares = np.concatenate([each.bounded[name] for each in outcomes]) / PARAMETERS[name]
        ratios = np.sqrt(np.quantile(squares, [0.5, 0.95])) if len(squares) else np.full(2, np.nan)
        ideal = [np.sqrt(quantile(share, PARAMETERS[name]) / PARAMETERS[name]) for share in (0.5, 0.95)]
        rows.append((name, str(len(squares)), *(f"{value:.2f}" for value in (*ratios, *ideal))))
    return Table(
        title="Errors over the Cramer-Rao bound",
        columns=("class", "count", "median", "95th percentile", "ideal median", "ideal 95th"),
        rows=tuple(rows),
    )


def quantile(share: float, freedom: int) -> float:
    """Quantile of the chi-square distribution."""
    from scipy.stats import chi2  # noqa: PLC0415 - a second of import

    return float(chi2.ppf(share, freedom))


def probability_table(outcomes: Sequence[Outcome]) -> Table:
    """Share of right classes by their probability in the map."""
    pairs = np.array([pair for each in outcomes for pair in each.class_probabilities]).reshape(-1, 2)
    places = np.clip(np.digitize(pairs[:, 0], CONFIDENCES) - 1, 0, len(CONFIDENCES) - 2)
    groups = [pairs[places == place] for place in range(len(CONFIDENCES) - 1)]
    error = sum(abs(float((group[:, 0] - group[:, 1]).sum())) for group in groups) / max(len(pairs), 1)
    rows = [
        (f"{low:g} to {high:g}", str(len(group)), *(f"{value:.3f}" for value in group.mean(axis=0)))
        for low, high, group in zip(CONFIDENCES, CONFIDENCES[1:], groups, strict=False)
        if len(group)
    ]
    return Table(
        title=f"Class probabilities: expected calibration error {error:.4f}",
        columns=("probability", "count", "mean", "share right"),
        rows=tuple(rows),
    )


def sonar_table(outcomes: Sequence[Outcome]) -> Table:
    """Errors of the estimated parameters of the sonar."""
    rows = []
    for name, (unit, factor) in LEARNED.items():
        errors_and_sigmas = [each.learned[name] for each in outcomes if name in each.learned]
        if not errors_and_sigmas:
            continue
        errors, sigmas = np.array(errors_and_sigmas).T
        values = (errors.mean() * factor, np.sqrt((errors**2).mean()) * factor, np.median(sigmas) * factor)
        inside = 100 * float((np.abs(errors) < 1.96 * sigmas).mean())
        rows.append((f"{name} ({unit})", *(f"{value:.2f}" for value in values), f"{inside:.0f}"))
    return Table(
        title="Estimated parameters of the sonar",
        columns=("number", "mean error", "RMS error", "median sigma", "inside 95 % (%)"),
        rows=tuple(rows),
    )


def duration_table(outcomes: Sequence[Outcome]) -> Table:
    """CPU time of a room; the first rooms of each process also load compiled code, so medians count."""
    seconds = np.array([each.seconds for each in outcomes])
    paces = 1000 * seconds / np.array([each.pings for each in outcomes])
    values = (np.median(seconds), np.quantile(seconds, 0.95), np.median(paces))
    return Table(
        title="Seconds of the processor",
        columns=("median room", "95th percentile", "median per thousand pings"),
        rows=(tuple(f"{value:.2f}" for value in values),),
    )


def document(outcomes: Sequence[Outcome]) -> dict[str, object]:
    """Keep what pictures are made of: NEES by class, and class probabilities with whether the class is right."""
    summary = summed(outcomes)
    return {
        "rooms": len(outcomes),
        "nees": {name: rounded(each.consistency.nees) for name, each in summary.classes.items()},
        "class_probabilities": [rounded(pair, digits=6) for each in outcomes for pair in each.class_probabilities],
    }


def rounded(values: FloatArray | Sequence[float], *, digits: int = 3) -> list[float]:
    """Round numbers for a file."""
    return [round(float(value), digits) for value in values]


if __name__ == "__main__":
    main()
