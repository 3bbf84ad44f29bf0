"""Home-made heads in random rooms: python benchmarks/heads.py [ROOMS] [--first SEED] [--gain G] [--offset DEGREES].

Simulates random rooms (20 by default) from eight stations.  The servo of each head turns 0.9 to 1.1 times the commanded
angle, with an offset of up to 10 degrees.  Maps each room twice: from exact poses, and from poses that are off by 1.5
cm and 3 degrees and rounded to whole centimetres and degrees, as the sketch in docs/formats.md writes them.  Four heads
of five have one HC-SR04, the fifth has four modules 90 degrees apart.
Prints the scores of walls, the consistency of the covariances, and the errors of the estimated gain and offset.
``--gain`` and ``--offset`` set the largest errors of the servos: both 0 for heads without a fault.
"""

import argparse
import math
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import Evaluation, evaluate
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import FeatureClass, FeatureMap, Table
from library.heads import measured_by_hand, simulate_head

ROOMS, STATIONS = 20, 8
KINDS = ("exact", "by hand")
# Largest errors of gains, and of offsets [degrees].
GAIN, OFFSET = 0.1, 10.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """One room with one kind of poses: true gain and offset, the map and its evaluation."""

    seed: int
    poses: str
    array: str
    true: tuple[float, float]
    feature_map: FeatureMap
    evaluation: Evaluation


def main() -> None:
    """Map all rooms and print tables."""
    arguments = parse()
    seeds = range(arguments.first, arguments.first + arguments.rooms)
    with ProcessPoolExecutor(arguments.jobs) as workers:
        run = partial(mapped, gain=arguments.gain, offset=arguments.offset, kinds=arguments.poses or KINDS)
        pairs = list(tracked(workers.map(run, seeds), total=arguments.rooms, task="mapping"))
    outcomes = [each for pair in pairs for each in pair]
    for table in (score_table(outcomes), servo_table(outcomes)):
        show(table)
    if arguments.each:
        show(each_table(outcomes))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="Home-made heads in random rooms.")
    parser.add_argument("rooms", type=int, nargs="?", default=ROOMS)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--gain", type=float, default=GAIN)
    parser.add_argument("--offset", type=float, default=OFFSET)
    parser.add_argument("--poses", choices=KINDS, action="append")
    parser.add_argument("--each", action="store_true", help="list the rooms one by one")
    parser.add_argument("--jobs", type=int)
    return parser.parse_args()


def mapped(seed: int, *, gain: float, offset: float, kinds: Sequence[str]) -> list[Outcome]:
    """Map a room from exact poses, and from those of a hand."""
    array, simulation = simulate_head(seed, gain=gain, offset=offset)
    exact, truth = list(simulation), simulation.truth
    outcomes = []
    for poses in kinds:
        sweeps = exact if poses == KINDS[0] else measured_by_hand(exact, seed)
        feature_map = map_sweeps(JointMapper(simulation.rig), sweeps)
        outcomes.append(
            Outcome(
                seed=seed,
                poses=poses,
                array=array,
                true=(simulation.settings.servo_gain, simulation.settings.servo_offset),
                feature_map=feature_map,
                evaluation=evaluate(feature_map, truth),
            )
        )
    return outcomes


def grouped(outcomes: Sequence[Outcome]) -> dict[str, list[Outcome]]:
    """Group maps by poses and by head."""
    groups = {
        f"{name}, poses {poses}": [each for each in outcomes if each.poses == poses and each.array == array]
        for poses in KINDS
        for name, array in (("one sensor", "hc-sr04-servo"), ("four sensors", "rotary-array"))
    }
    groups |= {f"all, poses {poses}": [e for e in outcomes if e.poses == poses] for poses in KINDS}
    return {name: members for name, members in groups.items() if members}


def score_table(outcomes: Sequence[Outcome]) -> Table:
    """Recall, precision and errors of walls, and the share of true features inside the 95 % ellipses."""
    rows = []
    for name, members in grouped(outcomes).items():
        tallies = [each.evaluation.matches.walls.tally for each in members]
        tally = sum(tallies[1:], start=tallies[0])
        right = [match for each in members for match in each.evaluation.matches.walls.right]
        places, turns = np.array([(1000 * each.distance, math.degrees(each.angle)) for each in right]).reshape(-1, 2).T
        inside = [
            np.concatenate([each.evaluation.consistency[kind].nees for each in members]) < limit
            for kind, limit in ((FeatureClass.WALL, 5.991), (FeatureClass.CYLINDER, 7.815))
        ]
        rows.append(
            (
                f"{len(members)} rooms, {name}",
                f"{100 * tally.found / max(tally.wanted, 1):.0f} / {100 * tally.right / max(tally.estimates, 1):.0f}",
                f"{places.mean():.1f}, {places.max():.0f}",
                f"{turns.mean():.2f}, {turns.max():.1f}",
                *(f"{100 * each.mean():.0f} of {len(each)}" if len(each) else "-" for each in inside),
            )
        )
    columns = ("rooms", "walls, recall / precision (%)", "mean, worst (mm)", "(deg)", "inside 95 % (%)", "cylinders")
    return Table(title="Walls by home-made heads", columns=columns, rows=tuple(rows))


def learned(outcome: Outcome) -> list[tuple[float, float]]:
    """Errors of gain and offset, and the standard deviations that the map gives them."""
    found: Any = outcome.feature_map.parameters["found"]
    names = zip(("servo_gain", "servo_offset"), outcome.true, strict=True)
    return [(found[name]["value"] - true, found[name]["sigma"]) for name, true in names if name in found]


def servo_table(outcomes: Sequence[Outcome]) -> Table:
    """Errors of the estimated gain and offset."""
    rows = []
    for group, members in grouped(outcomes).items():
        pairs = np.array([each for each in map(learned, members) if len(each) == 2]).reshape(-1, 2, 2)
        for number, (name, factor) in enumerate((("gain (%)", 100.0), ("offset (deg)", math.degrees(1.0)))):
            errors, sigmas = factor * pairs[:, number].T if len(pairs) else np.full((2, 1), np.nan)
            values = (np.sqrt((errors**2).mean()), np.abs(errors).max(), np.median(sigmas))
            inside = 100 * float((np.abs(errors) < 1.96 * sigmas).mean())
            rows.append((f"{group}: {name}", *(f"{value:.2f}" for value in values), f"{inside:.0f}"))
    columns = ("number", "RMS error", "worst", "median sigma", "inside 95 % (%)")
    return Table(title="Gain and offset of the servo", columns=columns, rows=tuple(rows))


def each_table(outcomes: Sequence[Outcome]) -> Table:
    """List the rooms one by one."""
    rows = []
    for each in outcomes:
        walls = each.evaluation.matches.walls
        worst = [max([0.0, *values]) for values in zip(*((m.distance, m.angle) for m in walls.right), strict=True)]
        (gain, offset) = each.true
        found: Any = each.feature_map.parameters["found"]
        estimates = [
            (factor * v["value"], factor * v["sigma"])
            for name, factor in (("servo_gain", 1.0), ("servo_offset", math.degrees(1.0)))
            if (v := found.get(name))
        ]
        rows.append(
            (
                f"{each.seed} {each.poses}",
                f"{walls.tally.found} of {walls.tally.wanted}, {walls.tally.estimates}",
                f"{1000 * worst[0]:.0f} mm, {math.degrees(worst[1]):.1f} deg" if worst else "-",
                f"{gain:.3f}, {math.degrees(offset):.1f} deg",
                "; ".join(f"{value:.3f} +- {sigma:.3f}" for value, sigma in estimates),
                str(found["poses"])[:60],
            )
        )
    columns = ("room", "walls found, drawn", "worst", "true", "learned", "poses")
    return Table(title="Rooms", columns=columns, rows=tuple(rows))


if __name__ == "__main__":
    main()
