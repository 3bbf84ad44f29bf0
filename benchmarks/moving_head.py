"""A head that turns while the robot drives: python benchmarks/moving_head.py [ROOMS] [--first SEED] [--speed SPEED].

Simulates drives through random rooms (10 by default) with the built-in ``rotary-array``, whose sweep takes 2.3 s, at
0.2 m/s, and with the odometry of ``benchmarks/poses.py``: each ping has a pose of its own, and these drift within a
sweep.  Maps each drive from exact poses, from odometry, and from odometry with the robot halting for each sweep.
``--wait`` lets the robot stand for the first sweep; ``--short SHARE`` lets odometry count each way and turn too short
by this share, in addition; ``--large`` makes rooms about twice as long and wide, ``--stations`` sets the number of
legs, ``--array`` chooses another built-in rig.

The map is in the frame of odometry, which may drift before the first sweep is complete, so the errors are printed
twice: in that frame, and after the true room was moved such that the true path fits the estimated one (``aligned``).
"""

import argparse
import itertools
from collections.abc import Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import Evaluation, evaluate, pool
from echoplan.geometry import compose, invert, transform_points
from echoplan.io import rig_names
from echoplan.joint.settings import PoseMode
from echoplan.model import FeatureClass, Sweep, Table, Truth
from echoplan.simulation import OdometryNoise, Simulation
from library.mapping import map_by_joint
from library.rooms import ARRAY, LEGS, Drive, random_drive

ROOMS, SPEED = 10, 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """One map: its evaluation in the frame of odometry and after alignment, and the CPU time [s]."""

    given: Evaluation
    aligned: Evaluation
    seconds: float


def main() -> None:
    """Map all drives and print a table."""
    arguments = parse()
    how = Drive(
        array=arguments.array,
        stations=arguments.stations,
        speed=arguments.speed,
        large=arguments.large,
        waits=arguments.wait,
    )
    seeds = range(arguments.first, arguments.first + arguments.rooms)
    with ProcessPoolExecutor(arguments.workers) as workers:
        runs = workers.map(partial(mapped, how=how, short=arguments.short), seeds)
        outcomes = list(tracked(runs, total=arguments.rooms, task="mapping"))
    show(table(outcomes))


def parse() -> argparse.Namespace:
    """Read the command line."""
    parser = argparse.ArgumentParser(description="A head that turns while the robot drives.")
    parser.add_argument("rooms", type=int, nargs="?", default=ROOMS)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--speed", type=float, default=SPEED)
    parser.add_argument("--array", choices=rig_names(), default=ARRAY)
    parser.add_argument("--stations", type=int, default=LEGS)
    parser.add_argument("--large", action="store_true")
    parser.add_argument("--wait", action="store_true")
    parser.add_argument("--short", type=float, default=0.0)
    parser.add_argument("--workers", type=int)
    return parser.parse_args()


def mapped(seed: int, *, how: Drive, short: float) -> Mapping[str, Outcome]:
    """Map one drive from exact poses, from odometry, and from odometry with halts."""
    exact = random_drive(seed, replace(how, odometry=OdometryNoise()))
    moving, halting = (random_drive(seed, replace(how, speed=speed)) for speed in (how.speed, None))
    return {
        "exact poses": outcome(exact, tuple(exact), PoseMode.TRUST),
        "odometry": outcome(moving, shortened(tuple(moving), short), PoseMode.CORRECT),
        "odometry, halting": outcome(halting, shortened(tuple(halting), short), PoseMode.CORRECT),
    }


def shortened(sweeps: Sequence[Sweep], short: float) -> Sequence[Sweep]:
    """Let odometry count each way and turn too short by a share."""
    poses = np.concatenate([sweep.map_from_base for sweep in sweeps])
    steps = compose(invert(poses[:-1]), poses[1:]) * (1.0 - short)
    counted = np.array(list(itertools.accumulate(steps, compose, initial=poses[0])))
    parts = np.split(counted, np.cumsum([len(sweep) for sweep in sweeps])[:-1])
    return [replace(sweep, map_from_base=part) for sweep, part in zip(sweeps, parts, strict=True)]


def outcome(simulation: Simulation, sweeps: Sequence[Sweep], poses: PoseMode) -> Outcome:
    """Map one drive, and compare the map with the truth."""
    feature_map, seconds = map_by_joint(simulation, sweeps, poses, driven=True)
    truth = simulation.truth
    return Outcome(
        given=evaluate(feature_map, truth),
        aligned=evaluate(feature_map, aligned(truth, feature_map.poses)),
        seconds=seconds,
    )


def aligned(truth: Truth, poses: FloatArray) -> Truth:
    """Move the truth such that the squares of the distances to the estimated positions are least (Umeyama 1991)."""
    true, found = (each[:, 0] + 1j * each[:, 1] for each in (truth.poses, poses))
    turn = np.angle(np.vdot(true - true.mean(), found - found.mean()))
    shift = found.mean() - np.exp(1j * turn) * true.mean()
    pose = np.array([shift.real, shift.imag, turn])
    cylinders = truth.cylinders.copy()
    cylinders[:, :2] = transform_points(pose, cylinders[:, :2])
    walls_xy = transform_points(pose, truth.walls_xy.reshape(-1, 2)).reshape(-1, 2, 2)
    return replace(truth, walls_xy=walls_xy, cylinders=cylinders, poses=compose(pose, truth.poses))


def table(outcomes: Sequence[Mapping[str, Outcome]]) -> Table:
    """Lay out the scores by how drives were mapped."""
    columns = ("poses", "walls, recall / precision (%)", "off (mm)", "(°)", "inside 95 % (%)", "ATE (mm)", "CPU (s)")
    rows = []
    for name in outcomes[0]:
        runs = [each[name] for each in outcomes]
        seconds = f"{np.mean([run.seconds for run in runs]):.0f}"
        rows.append((name, *cells([run.given for run in runs]), seconds))
        rows.append((f"{name}, aligned", *cells([run.aligned for run in runs]), seconds))
    return Table(title=f"{len(outcomes)} drives", columns=columns, rows=tuple(rows))


def cells(evaluations: Sequence[Evaluation]) -> tuple[str, ...]:
    """Return recall and precision, median and mean errors of walls, their consistency, and the error of the poses."""
    walls = pool(evaluations, rng=np.random.default_rng(0)).classes[FeatureClass.WALL]
    matches = [match for each in evaluations for match in each.matches.walls.right]
    distances = np.array([1000.0 * match.distance for match in matches] or [np.nan])
    angles = np.degrees([match.angle for match in matches] or [np.nan])
    errors = [1000.0 * each.trajectory.absolute_error for each in evaluations if each.trajectory]
    return (
        f"{100 * walls.recall.value:.1f} / {100 * walls.precision.value:.1f}",
        f"{np.median(distances):.1f}, mean {distances.mean():.1f}",
        f"{np.median(angles):.2f}, mean {angles.mean():.2f}",
        f"{100 * walls.consistency.share_inside:.0f}",
        f"{np.mean(errors):.1f}, worst {max(errors):.1f}",
    )


if __name__ == "__main__":
    main()
