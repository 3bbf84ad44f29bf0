"""The method joint in random arenas: python benchmarks/arenas.py [ARENAS] [--off METRES] [--turn DEGREES] [--coarse].

Simulates random arenas of boards (24 by default), 2.1 or 2.5 m wide, with six or eight walls, such as students build
them.  One sensor with a resolution of 1 cm records from five waypoints; it turns all round by one degree at a time, 12
cm in front of the servo axis.  The true poses differ from the waypoints by normal errors (standard deviations: 1.5 cm
along each axis and 1.5 degrees by default).  3 % of the readings are missing, 3 % are strays, and each has a noise of
4 mm before it is rounded.  Prints scores, the consistency of the covariances, and the arenas with faults.  ``--coarse``
turns the sensor by 5 degrees at a time, about its own centre.

``--students`` builds a different robot for each arena: the beam is wider than the rig specifies, the sensor turns by 2,
3 or 5 degrees at a time, its mounting has small errors of angle and position, and half of the robots repeat readings,
take medians of neighbours or detect their own cable.  Waypoints are off by 2 cm along each axis, headings by 3
degrees, and one heading by up to 15.
"""

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import partial

import numpy as np

from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import (
    Evaluation,
    EvaluationSettings,
    MatchingSettings,
    consistency_table,
    evaluate,
    pool,
)
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import Table
from library.arenas import STUDENTS_OFF, STUDENTS_TURN, simulate_arena
from library.score_tables import SCORE_COLUMNS, fault_table, score_row

ARENAS, OFF, TURN = 24, 0.015, 1.5


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """One arena and its evaluation."""

    seed: int
    evaluation: Evaluation
    seconds: float


def main() -> None:
    """Simulate arenas, map them and print tables."""
    parser = argparse.ArgumentParser(description="The method joint in random arenas.")
    parser.add_argument("arenas", type=int, nargs="?", default=ARENAS)
    parser.add_argument("--first", type=int, default=0, help="seed of the first arena")
    parser.add_argument("--off", type=float)
    parser.add_argument("--turn", type=float)
    parser.add_argument("--coarse", action="store_true")
    parser.add_argument("--students", action="store_true")
    arguments = parser.parse_args()
    off, turn = (STUDENTS_OFF, STUDENTS_TURN) if arguments.students else (OFF, TURN)
    case = partial(
        run,
        off=off if arguments.off is None else arguments.off,
        turn=turn if arguments.turn is None else arguments.turn,
        coarse=arguments.coarse,
        students=arguments.students,
    )
    with ProcessPoolExecutor() as workers:
        runs = workers.map(case, range(arguments.first, arguments.first + arguments.arenas))
        outcomes = list(tracked(runs, total=arguments.arenas, task="mapping"))
    evaluations = [each.evaluation for each in outcomes]
    total = score_row("all", evaluations, sum(each.seconds for each in outcomes))
    title = f"joint in {len(outcomes)} random arenas: recall / precision (%), mean deviation"
    show(Table(title=title, columns=("arenas", *SCORE_COLUMNS[1:]), rows=(total,)))
    summary = pool(evaluations, rng=np.random.default_rng(0))
    show(consistency_table({name: each.consistency for name, each in summary.classes.items()}))
    show(fault_table({each.seed: each.evaluation for each in outcomes}))


def run(seed: int, *, off: float, turn: float, coarse: bool, students: bool) -> Outcome:
    """Simulate one arena, map it and compare the map with the truth."""
    simulation, specified, sweeps = simulate_arena(seed, off=off, turn=turn, coarse=coarse, students=students)
    begun = time.process_time()
    found = map_sweeps(JointMapper(specified), sweeps)
    seconds, settings = time.process_time() - begun, EvaluationSettings(matching=MatchingSettings(min_stations=1))
    return Outcome(seed=seed, evaluation=evaluate(found, simulation.truth, settings), seconds=seconds)


if __name__ == "__main__":
    main()
