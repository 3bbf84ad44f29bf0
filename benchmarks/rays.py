"""The method joint on ray-cone readings: python benchmarks/rays.py [ROOMS] [--noise M] [--as-sound].

Gazebo, Webots, Stage and MRPT simulate no sound: a reading is the least range of the rays of a cone.  Simulates random
rooms (24 by default) with such cones of 15, 30 and 60 degrees from 14 stations, maps the readings, and prints scores.
Readings have a standard deviation of ``--noise`` (2 mm by default).  The method has to recognise by itself that there
was no sound; ``--as-sound`` makes it assume sound, to show the difference.
"""

import argparse
import math
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import partial

import numpy as np

from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import Evaluation, evaluate
from echoplan.joint.settings import PoseMode
from echoplan.model import Table
from library.mapping import map_by_joint
from library.ray_cones import cast, with_cones
from library.rooms import random_simulation
from library.score_tables import SCORE_COLUMNS, score_row

ROOMS = 24
HALF_ANGLES = (7.5, 15.0, 30.0)
NOISE, RAYS = 0.002, 31


def main() -> None:
    """Simulate ray cones in rooms, map the readings and print tables."""
    arguments = parse()
    jobs = [(half, seed) for half in HALF_ANGLES for seed in range(arguments.rooms)]
    with ProcessPoolExecutor() as workers:
        chosen = partial(run, noise=arguments.noise, as_sound=arguments.as_sound)
        runs = workers.map(chosen, *zip(*jobs, strict=True))
        outcomes = list(tracked(runs, total=len(jobs), task="mapping"))
    rows = []
    for half in HALF_ANGLES:
        own = [outcome for (each, _), outcome in zip(jobs, outcomes, strict=True) if each == half]
        rows.append(score_row(f"{2 * half:.0f} degrees", [one for one, _ in own], sum(seconds for _, seconds in own)))
    show(
        Table(
            title="joint, by cones of rays: recall / precision (%), mean deviation",
            columns=SCORE_COLUMNS,
            rows=(*rows,),
        )
    )


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="The method joint on ray-cone readings.")
    parser.add_argument("rooms", type=int, nargs="?", default=ROOMS)
    parser.add_argument("--noise", type=float, default=NOISE)
    parser.add_argument("--as-sound", action="store_true")
    return parser.parse_args()


def run(half_angle: float, seed: int, *, noise: float, as_sound: bool) -> tuple[Evaluation, float]:
    """Cast rays in one room [degrees], map it and compare the map with the truth; measure the CPU time."""
    simulation, rng = random_simulation(seed), np.random.default_rng(seed)
    rig = with_cones(simulation.rig, math.radians(half_angle))
    sweeps = cast(tuple(simulation), simulation.world, rig, rays=RAYS, noise=noise, rng=rng)
    simulation = replace(simulation, rig=replace(rig, rays=False) if as_sound else rig)
    found, seconds = map_by_joint(simulation, sweeps, PoseMode.AUTO)
    return evaluate(found, simulation.truth), seconds


if __name__ == "__main__":
    main()
