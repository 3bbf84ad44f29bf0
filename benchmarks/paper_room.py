"""The paper's room, many times over: python benchmarks/paper_room.py [SEEDS].

Simulates the built-in paper room with each seed (100 unless told otherwise), with 2 % dropouts and 2 % stray echoes,
maps it by joint, the paper's method and the conventional one, and prints what Table 5 of the paper prints, with
intervals.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from echoplan.cli.terminal import show
from echoplan.evaluation import BootstrapSettings, Evaluation, evaluate
from echoplan.evaluation.bootstrap import Interval, describe
from echoplan.io import builtin_rig, builtin_route, builtin_world
from echoplan.methods import find_method, map_sweeps
from echoplan.model import CornerKind, FeatureMap, Table
from echoplan.simulation import Simulation, SimulationSettings

METHODS = ("joint", "mdp-fuzzy", "rcd")
# Table 5 of the paper: mean and greatest distance deviation [mm], mean and greatest angle deviation [degrees].
PAPER = (5.2, 12.8, 1.25, 3.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """What came of one seed: whether all objects were found and rightly classified, and the walls' deviations."""

    complete: bool
    distance_mean: float
    distance_max: float
    angle_mean: float
    angle_max: float


def main(arguments: list[str]) -> None:
    """Score all seeds with each method and print them beside the paper's figures."""
    seeds = range(int(arguments[0]) if arguments else 100)
    with ProcessPoolExecutor() as pool:
        scores = {name: list(pool.map(partial(score, method=name), seeds)) for name in METHODS}
    show(table(scores, len(seeds)))


def score(seed: int, *, method: str) -> Score:
    """Simulate, map and evaluate one seed."""
    simulation = Simulation(
        world=builtin_world("paper-room"),
        rig=builtin_rig("rotary-array"),
        route=builtin_route("paper-room"),
        settings=SimulationSettings(dropout=0.02, stray=0.02),
        seed=seed,
    )
    feature_map = map_sweeps(find_method(method).build(simulation.rig), simulation)
    evaluation = evaluate(feature_map, simulation.truth)
    walls = evaluation.matches.walls.right
    distances, angles = ([getattr(wall, name) for wall in walls] for name in ("distance", "angle"))
    return Score(
        complete=is_complete(feature_map, evaluation),
        distance_mean=1000 * float(np.mean(distances)),
        distance_max=1000 * float(np.max(distances)),
        angle_mean=float(np.degrees(np.mean(angles))),
        angle_max=float(np.degrees(np.max(angles))),
    )


def is_complete(feature_map: FeatureMap, evaluation: Evaluation) -> bool:
    """Tell whether the eight flats, the cylinder and the heard corner are all there, each in its own class."""
    matches = evaluation.matches
    right = {match.estimate for match in matches.corners.right}
    heard = [
        corner
        for number, corner in enumerate(feature_map.corners)
        if number in right and corner.pings and corner.kind is CornerKind.CONCAVE
    ]
    return len(matches.walls.found) == 8 and len(matches.cylinders.found) == 1 and len(heard) == 1


def table(scores: dict[str, list[Score]], seeds: int) -> Table:
    """Lay out the scores, each the median over the seeds with its 95 % interval."""
    heads = ("distance mean (mm)", "distance max (mm)", "angle mean (°)", "angle max (°)")
    names = ("distance_mean", "distance_max", "angle_mean", "angle_max")
    rows = [
        (
            method,
            f"{sum(each.complete for each in found)} of {seeds}",
            *(cell(median([getattr(each, name) for each in found])) for name in names),
        )
        for method, found in scores.items()
    ]
    paper = ("the paper", "1 of 1", *(f"{value:.2f}" for value in PAPER))
    return Table(
        title=f"The paper's room over {seeds} seeds: medians over the seeds [95 % interval]",
        columns=("method", "all objects right", *heads),
        rows=(*rows, paper),
    )


def median(values: list[float]) -> Interval:
    """Median over the seeds with its bootstrap interval."""
    rng = np.random.default_rng(0)
    return describe(([value] for value in values), rng=rng, settings=BootstrapSettings()).median


def cell(interval: Interval) -> str:
    """Write an interval."""
    return f"{interval.value:.2f} [{interval.low:.2f}, {interval.high:.2f}]"


if __name__ == "__main__":
    main(sys.argv[1:])
