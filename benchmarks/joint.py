"""The method joint in random rooms: python benchmarks/joint.py [ROOMS] [--stations N] [--poses trust] [--recess].

Draws so many rooms (100 unless told otherwise), sounds them by the simulator, maps them, and prints what is found and
how exactly, how much of the wall length and which openings are right, which rooms are not right, whether covariances
and class probabilities are true, how near the errors come to the Cramer-Rao bound, what was learned of the sonar, and
the time.  Each is sounded from 14 stations, or from as many as ``--stations`` says.  The poses are exact:
``--poses trust`` tells the method so.  ``--misset`` lets the modules of each room be off by up to half a step of their
readings, which is what the method takes them to be.  ``--recess`` lets a pier stand out from one wall of each room, or
sinks a niche into it.  ``--by-hand M`` sets the robot down on two marks 0.2 m apart, and each of them is off by so
much.  ``--save FILE`` keeps what docs/joint_pictures.py draws.
"""

import argparse
import json
import math
import time
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
    Evaluation,
    Interval,
    Summary,
    consistency_table,
    deviation_table,
    evaluate,
    floor_plan_tables,
    pool,
)
from echoplan.evaluation.consistency import PARAMETERS
from echoplan.io import rig_names
from echoplan.joint.map_extraction.segments import SegmentSettings
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.settings import PoseMode
from echoplan.methods import map_sweeps
from echoplan.model import Corner, Cylinder, FeatureClass, FeatureMap, Sweep, Table, Wall
from echoplan.simulation import Simulation
from library.error_bound import against_bound, true_scale
from library.rooms import ARRAY, STATIONS, is_oblique, random_simulation

ROOMS = 100
# The marks on which a robot is set down are so far apart [m].
MARKS = 0.2
# Borders between classes of confidence.
CONFIDENCES = (0.0, 0.5, 0.9, 0.99, 0.999, 1.0)
# Numbers of the sonar, and what turns them into units that are easily read.
LEARNED = {"range_offset": ("mm", 1e3), "range_scale": ("per mille", 1e3), "servo_latency": ("ms", 1e3)}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """What came of one room.

    Parameters
    ----------
    seed : int
        Of the room.
    evaluation : Evaluation
        The map against the truth.
    bounded : mapping of str to list of float
        NEES of walls and cylinders with the Cramer-Rao bound for their covariance.
    beliefs : list of tuple of float
        Probability that the map gives to the class of each feature, and 1 if it is right, else 0.
    learned : mapping of str to tuple of float
        Error of each number of the sonar, and its standard deviation by the map.
    pings : int
        How many were made.
    seconds : float
        Of the processor, to map the room.
    """

    seed: int
    evaluation: Evaluation
    bounded: Mapping[str, list[float]]
    beliefs: list[tuple[float, float]]
    learned: Mapping[str, tuple[float, float]]
    pings: int
    seconds: float


def main() -> None:
    """Map all rooms and print what came of them."""
    arguments = parse()
    with ProcessPoolExecutor() as workers:
        rooms = {
            "array": arguments.array,
            "stations": arguments.stations,
            "misset": arguments.misset,
            "recess": arguments.recess,
        }
        sound = partial(random_simulation, **rooms)
        chosen = partial(run, sound=sound, poses=arguments.poses, by_hand=arguments.by_hand)
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
    parser.add_argument("--by-hand", type=float, default=0.0)
    parser.add_argument("--save", type=Path)
    return parser.parse_args()


def run(
    seed: int,
    *,
    sound: Callable[[int], Simulation] = random_simulation,
    poses: PoseMode = PoseMode.AUTO,
    by_hand: float = 0.0,
) -> Outcome:
    """Sound one room, map it and hold the map against the truth."""
    simulation = sound(seed)
    sweeps, truth = set_down(simulation, by_hand), simulation.truth
    feature_map, seconds = mapped(simulation, sweeps, poses)
    evaluation = evaluate(feature_map, truth)
    return Outcome(
        seed=seed,
        evaluation=evaluation,
        bounded=against_bound(feature_map, truth, evaluation.matches, simulation=simulation, sweeps=sweeps),
        beliefs=beliefs_of(feature_map, evaluation),
        learned=learned_of(feature_map, simulation),
        pings=sum(map(len, sweeps)),
        seconds=seconds,
    )


def set_down(simulation: Simulation, error: float) -> tuple[Sweep, ...]:
    """Say of each station where the marks should have been."""
    rng = np.random.default_rng((simulation.seed, 7))
    turned = math.sqrt(2.0) * error / MARKS
    return tuple(
        replace(sweep, map_from_base=sweep.map_from_base + rng.normal(0.0, (error, error, turned)))
        for sweep in simulation
    )


def mapped(
    simulation: Simulation, sweeps: Sequence[Sweep], poses: PoseMode, *, driven: bool = False
) -> tuple[FeatureMap, float]:
    """Map sweeps of stations that lie anywhere unless the robot drove, and count the seconds of the processor."""
    settings, begun = JointSettings(poses=poses, segments=SegmentSettings(driven=driven)), time.process_time()
    feature_map = map_sweeps(JointMapper(simulation.rig, settings), sweeps)
    return feature_map, time.process_time() - begun


def beliefs_of(feature_map: FeatureMap, evaluation: Evaluation) -> list[tuple[float, float]]:
    """Say of all features that were heard how sure their class is, and whether it is right."""
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
    """Hold what was learned of the sonar against what the simulator put in."""
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
        belief_table(outcomes),
        sonar_table(outcomes),
    ]


def summed(outcomes: Sequence[Outcome]) -> Summary:
    """Pool rooms."""
    return pool((each.evaluation for each in outcomes), rng=np.random.default_rng(0))


def score_table(outcomes: Sequence[Outcome]) -> Table:
    """Tell how complete, right and exact the maps are, by kind of room, by what became of the poses, and in all."""
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
    """Group rooms by their kind and by what became of the poses; without empty groups."""
    groups = {
        "right-angled": [each for each in outcomes if not is_oblique(each.seed)],
        "oblique": [each for each in outcomes if is_oblique(each.seed)],
        "poses kept": [each for each in outcomes if not is_moved(each)],
        "poses moved": [each for each in outcomes if is_moved(each)],
        "all": outcomes,
    }
    return {group: members for group, members in groups.items() if members}


def is_moved(outcome: Outcome) -> bool:
    """Tell whether the map moved the poses, which were right."""
    trajectory = outcome.evaluation.trajectory
    return trajectory is not None and trajectory.absolute_error > 0.0


def fault_table(outcomes: Mapping[int, Evaluation]) -> Table:
    """List the rooms in which something is missing or false: true objects by number and estimates by number."""
    rows = []
    for seed, evaluation in outcomes.items():
        matchings = evaluation.matches.by_class
        missed = [f"{name} {k}" for name, m in matchings.items() for k in sorted(set(m.wanted) - set(m.found))]
        false = [f"{name} {k}" for name, m in matchings.items() for k in m.spurious]
        twice = [f"{name} {match.truth}" for name, m in matchings.items() for match in m.duplicate]
        if missed or false or twice:
            rows.append((str(seed), *(", ".join(names) or "-" for names in (missed, false, twice))))
    return Table(
        title=f"Rooms with faults: {len(rows)} of {len(outcomes)}",
        columns=("seed", "missed", "false", "twice"),
        rows=tuple(rows),
    )


def bound_table(outcomes: Sequence[Outcome]) -> Table:
    """Tell how many times the Cramer-Rao bound the errors are: root of NEES over the number of parameters."""
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


def belief_table(outcomes: Sequence[Outcome]) -> Table:
    """Tell how often a class is right that the map holds so likely."""
    beliefs = np.array([pair for each in outcomes for pair in each.beliefs]).reshape(-1, 2)
    places = np.clip(np.digitize(beliefs[:, 0], CONFIDENCES) - 1, 0, len(CONFIDENCES) - 2)
    groups = [beliefs[places == place] for place in range(len(CONFIDENCES) - 1)]
    error = sum(abs(float((group[:, 0] - group[:, 1]).sum())) for group in groups) / max(len(beliefs), 1)
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
    """Tell how well the numbers of the sonar were learned."""
    rows = []
    for name, (unit, factor) in LEARNED.items():
        told = [each.learned[name] for each in outcomes if name in each.learned]
        if not told:
            continue
        errors, sigmas = np.array(told).T
        values = (errors.mean() * factor, np.sqrt((errors**2).mean()) * factor, np.median(sigmas) * factor)
        inside = 100 * float((np.abs(errors) < 1.96 * sigmas).mean())
        rows.append((f"{name} ({unit})", *(f"{value:.2f}" for value in values), f"{inside:.0f}"))
    return Table(
        title="What was learned of the sonar",
        columns=("number", "mean error", "RMS error", "median sigma", "inside 95 % (%)"),
        rows=tuple(rows),
    )


def duration_table(outcomes: Sequence[Outcome]) -> Table:
    """Tell how long a room takes; the first rooms of each process also load compiled code, so medians count."""
    seconds = np.array([each.seconds for each in outcomes])
    paces = 1000 * seconds / np.array([each.pings for each in outcomes])
    values = (np.median(seconds), np.quantile(seconds, 0.95), np.median(paces))
    return Table(
        title="Seconds of the processor",
        columns=("median room", "95th percentile", "median per thousand pings"),
        rows=(tuple(f"{value:.2f}" for value in values),),
    )


def percent(interval: Interval) -> str:
    """Write a share with its interval."""
    return f"{100 * interval.value:.1f} [{100 * interval.low:.1f}, {100 * interval.high:.1f}]"


def document(outcomes: Sequence[Outcome]) -> dict[str, object]:
    """Keep what pictures are made of: NEES by class, and beliefs with whether they are right."""
    summary = summed(outcomes)
    return {
        "rooms": len(outcomes),
        "nees": {name: rounded(each.consistency.nees) for name, each in summary.classes.items()},
        "beliefs": [rounded(pair, digits=6) for each in outcomes for pair in each.beliefs],
    }


def rounded(values: FloatArray | Sequence[float], *, digits: int = 3) -> list[float]:
    """Round numbers for a file."""
    return [round(float(value), digits) for value in values]


if __name__ == "__main__":
    main()
