"""The room after the paper, and variants: python benchmarks/paper_room.py [SEEDS] [--variants] [--methods A,B].

Simulates the built-in ``paper-room`` with each seed (100 by default), with 2 % dropouts and 2 % stray echoes, maps it
with each method (joint, mdp-fuzzy and rcd by default), and prints what Table 5 of the paper prints, with intervals.

The paper gives no coordinates: the layout of the room and of its stations is ours.  ``--variants`` (20 seeds by
default) changes one thing at a time: it moves every station by a fixed distance in a random direction, changes the
radius of the cylinder, puts the transducers on the axis of the turret, or sweeps every station twice.
"""

import argparse
import json
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from itertools import product

import numpy as np

from echoplan.cli.terminal import show
from echoplan.evaluation import BootstrapSettings, Evaluation, evaluate
from echoplan.evaluation.bootstrap import Interval, describe
from echoplan.geometry import directions
from echoplan.io import builtin_rig, builtin_route, builtin_world
from echoplan.methods import METHODS, find_method, map_sweeps
from echoplan.model import CornerKind, FeatureClass, FeatureMap, Rig, Route, Table, World
from echoplan.simulation import Simulation, SimulationSettings

# Table 5 of the paper: mean and greatest distance deviation [mm], mean and greatest angle deviation [degrees].
PAPER = (5.2, 12.8, 1.25, 3.0)
# Eight flats, one cylinder, one concave corner.
OBJECTS = 10


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """What differs from the built-in room: lengths in metres, None where nothing does."""

    name: str = "as built in"
    moved: float = 0.0
    radius: float | None = None
    arm: float | None = None
    sweeps: int = 1


VARIANTS = (
    Variant(),
    *(Variant(name=f"stations moved by {moved} m", moved=moved) for moved in (0.1, 0.2, 0.3)),
    *(Variant(name=f"cylinder of {100 * radius:.0f} cm radius", radius=radius) for radius in (0.05, 0.2, 0.3)),
    Variant(name="arm of 0", arm=0.0),
    Variant(name="each station swept twice", sweeps=2),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Score:
    """Result of one seed: objects found in their own class, deviations of the walls, covariance checks.

    Distances in mm, angles in degrees, nan where no wall is right.  ``spurious`` counts walls and cylinders that are
    not in the room or are in the map twice.  ``inside`` holds for walls, corners and cylinders how many right ones have
    the truth inside their 95 % ellipse, ``checked`` how many there are.
    """

    objects: int
    spurious: int
    distance_mean: float
    distance_max: float
    angle_mean: float
    angle_max: float
    inside: tuple[int, ...]
    checked: tuple[int, ...]


def main() -> None:
    """Score all seeds of all variants with each method and print them beside the figures of the paper."""
    arguments = parse()
    variants = VARIANTS if arguments.variants else VARIANTS[:1]
    seeds = range(arguments.seeds or (20 if arguments.variants else 100))
    methods = arguments.methods.split(",")
    cases = list(product(variants, methods, seeds))
    with ProcessPoolExecutor() as workers:
        scored = workers.map(partial(score, settings=json.loads(arguments.settings)), cases)
        scores = dict(zip(cases, scored, strict=True))
    rows = {
        (method if len(variants) == 1 else f"{method}, {variant.name}"): [
            scores[variant, method, seed] for seed in seeds
        ]
        for method, variant in product(methods, variants)
    }
    show(table(rows))
    show(ellipses(rows))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="The room after the paper, and variants of it.")
    parser.add_argument("seeds", type=int, nargs="?", help="100, or 20 with --variants")
    parser.add_argument("--variants", action="store_true", help="change stations, cylinder, arm or sweeps")
    parser.add_argument("--methods", default="joint,mdp-fuzzy,rcd", help=f"of {', '.join(METHODS)}")
    parser.add_argument("--settings", default="{}", help="of the methods, as JSON")
    return parser.parse_args()


def simulation_of(variant: Variant, seed: int) -> Simulation:
    """Simulate one seed of a variant."""
    return Simulation(
        world=world_of(variant),
        rig=rig_of(variant),
        route=route_of(variant, seed),
        settings=SimulationSettings(dropout=0.02, stray=0.02),
        seed=seed,
    )


def world_of(variant: Variant) -> World:
    """Build the room with the cylinder of a variant."""
    world = builtin_world("paper-room")
    if variant.radius is None:
        return world
    return replace(world, pillars=tuple(replace(each, radius=variant.radius) for each in world.pillars))


def rig_of(variant: Variant) -> Rig:
    """Build the array with the arm of a variant."""
    rig = builtin_rig("rotary-array")
    if variant.arm is None:
        return rig
    sensors = (
        replace(each, x=variant.arm * float(np.cos(each.yaw)), y=variant.arm * float(np.sin(each.yaw)))
        for each in rig.sensors
    )
    return replace(rig, sensors=tuple(sensors))


def route_of(variant: Variant, seed: int) -> Route:
    """Move the stations by the same length in directions drawn from the seed, and repeat each."""
    poses = builtin_route("paper-room").map_from_base.copy()
    poses[:, :2] += variant.moved * directions(np.random.default_rng(seed).uniform(-np.pi, np.pi, len(poses)))
    return Route(map_from_base=np.repeat(poses, variant.sweeps, axis=0))


def score(case: tuple[Variant, str, int], settings: dict[str, object]) -> Score:
    """Simulate, map and evaluate one seed."""
    variant, method, seed = case
    simulation = simulation_of(variant, seed)
    found = find_method(method)
    mapper = found.build(simulation.rig, found.settings_type.model_validate(settings))
    feature_map = map_sweeps(mapper, simulation)
    return score_of(feature_map, evaluate(feature_map, simulation.truth))


def score_of(feature_map: FeatureMap, evaluation: Evaluation) -> Score:
    """Take the figures of one map."""
    matches = evaluation.matches
    walls = matches.walls.right
    distances = 1000 * np.array([wall.distance for wall in walls] or [np.nan])
    angles = np.degrees([wall.angle for wall in walls] or [np.nan])
    checks = [evaluation.consistency[each] for each in (FeatureClass.WALL, FeatureClass.CORNER, FeatureClass.CYLINDER)]
    return Score(
        objects=objects_right(feature_map, evaluation),
        spurious=sum(len(each.spurious) + len(each.duplicate) for each in (matches.walls, matches.cylinders)),
        distance_mean=float(distances.mean()),
        distance_max=float(distances.max()),
        angle_mean=float(angles.mean()),
        angle_max=float(angles.max()),
        inside=tuple(each.inside for each in checks),
        checked=tuple(len(each.nees) for each in checks),
    )


def objects_right(feature_map: FeatureMap, evaluation: Evaluation) -> int:
    """Count the flats (8), the cylinder (1) and the detected concave corner (1) that are found in their own class."""
    matches = evaluation.matches
    right = {match.estimate for match in matches.corners.right}
    detected = [
        corner
        for number, corner in enumerate(feature_map.corners)
        if number in right and corner.pings and corner.kind is CornerKind.CONCAVE
    ]
    return len(matches.walls.found) + len(matches.cylinders.found) + (len(detected) == 1)


def table(rows: dict[str, list[Score]]) -> Table:
    """Lay out the scores: medians over the seeds with 95 % intervals, means of counts."""
    heads = ("distance mean (mm)", "distance max (mm)", "angle mean (°)", "angle max (°)")
    names = ("distance_mean", "distance_max", "angle_mean", "angle_max")
    lines = [
        (
            name,
            f"{sum(each.objects == OBJECTS for each in found)} of {len(found)}",
            f"{np.mean([each.objects for each in found]):.1f}",
            f"{np.mean([each.spurious for each in found]):.1f}",
            *(cell(median([getattr(each, key) for each in found])) for key in names),
        )
        for name, found in rows.items()
    ]
    paper = ("the paper", "1 of 1", f"{OBJECTS}", "0", *(f"{value:.2f}" for value in PAPER))
    return Table(
        title="The room after the paper: medians over the seeds [95 % interval]",
        columns=("method", "all objects right", "objects right", "spurious", *heads),
        rows=(*lines, paper),
    )


def ellipses(rows: dict[str, list[Score]]) -> Table:
    """Lay out how many of the right features have the truth inside their 95 % ellipse."""
    lines = [
        (
            name,
            *(
                f"{sum(inside)} of {sum(checked)}"
                for inside, checked in zip(
                    zip(*(each.inside for each in found), strict=True),
                    zip(*(each.checked for each in found), strict=True),
                    strict=True,
                )
            ),
        )
        for name, found in rows.items()
    ]
    return Table(
        title="Features with the truth inside their 95 % ellipse",
        columns=("method", "walls", "corners", "cylinders"),
        rows=tuple(lines),
    )


def median(values: Sequence[float]) -> Interval:
    """Median over the seeds with its bootstrap interval."""
    rng = np.random.default_rng(0)
    finite = [value for value in values if np.isfinite(value)]
    return describe(([value] for value in finite), rng=rng, settings=BootstrapSettings()).median


def cell(interval: Interval) -> str:
    """Write an interval."""
    return f"{interval.value:.2f} [{interval.low:.2f}, {interval.high:.2f}]"


if __name__ == "__main__":
    main()
