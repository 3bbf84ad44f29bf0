"""The method joint in random arenas: python benchmarks/arenas.py [ARENAS] [--off METRES] [--turn DEGREES] [--coarse].

Draws so many arenas of boards (24 unless told otherwise), 2.1 or 2.5 m wide and with six or eight walls, as students
build them, and sounds each from five way-points with one sensor that reads centimetres and is turned all round, a
degree at a time, 12 cm ahead of the axis.  Whoever set the robot down was off by so many metres each way (1.5 cm
unless told otherwise) and so many degrees (1.5), as deviations of a normal distribution.  3 % of the readings are
missing, 3 % are strays, and each has a noise of 4 mm before it is rounded.  Prints what is found and how exactly, and
the arenas that are not right.  ``--coarse`` turns the sensor by 5 degrees at a time, about its own centre.
"""

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import Evaluation, EvaluationSettings, MatchingSettings, evaluate
from echoplan.methods import map_sweeps
from echoplan.methods.joint import JointMapper
from echoplan.model import Polyline, Rig, Route, Sensor, Servo, Sweep, Table, World
from echoplan.simulation import Simulation, SimulationSettings
from joint import fault_table  # type: ignore[import-not-found]  # beside this file
from recordings import COLUMNS, row  # type: ignore[import-not-found]  # likewise
from rooms import Floor  # type: ignore[import-not-found]  # likewise

ARENAS, OFF, TURN = 24, 0.015, 1.5
# Boards are cut in multiples of this [m]; an arena is so many of them wide, and one or two of its corners lack so many.
BOARD, WIDTHS, LACKING = 0.42, (5, 6), (1, 2)
WAYPOINTS, CLEAR, APART, TRIES = 5, 0.2, 0.25, 10_000


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Outcome:
    """What came of one arena."""

    seed: int
    evaluation: Evaluation
    seconds: float


def main() -> None:
    """Sound arenas, map them and print tables."""
    parser = argparse.ArgumentParser(description="The method joint in random arenas.")
    parser.add_argument("arenas", type=int, nargs="?", default=ARENAS)
    parser.add_argument("--off", type=float, default=OFF)
    parser.add_argument("--turn", type=float, default=TURN)
    parser.add_argument("--coarse", action="store_true")
    arguments = parser.parse_args()
    with ProcessPoolExecutor() as workers:
        runs = workers.map(
            partial(run, off=arguments.off, turn=arguments.turn, coarse=arguments.coarse), range(arguments.arenas)
        )
        outcomes = list(tracked(runs, total=arguments.arenas, task="mapping"))
    total = row("all", [each.evaluation for each in outcomes], sum(each.seconds for each in outcomes))
    title = f"joint in {len(outcomes)} random arenas: recall / precision (%), mean deviation"
    show(Table(title=title, columns=("arenas", *COLUMNS[1:]), rows=(total,)))
    show(fault_table(outcomes))


def run(seed: int, *, off: float, turn: float, coarse: bool) -> Outcome:
    """Sound one arena, map it and hold the map against the truth."""
    rng = np.random.default_rng(seed)
    outline_xy = outline(rng)
    marks = np.column_stack([waypoints(outline_xy, rng), np.zeros(WAYPOINTS)])
    errors = rng.normal(0.0, (off, off, np.radians(turn)), marks.shape)
    simulation = Simulation(
        world=World(name=f"arena {seed}", polylines=(Polyline(points_xy=outline_xy, closed=True),)),
        rig=turned_sensor(coarse=coarse),
        route=Route(map_from_base=marks + errors),
        settings=SimulationSettings(dropout=0.03, stray=0.03, jitter=0.004),
        seed=seed,
    )
    sweeps, begun = [set_down(sweep, marks) for sweep in simulation], time.process_time()
    found = map_sweeps(JointMapper(simulation.rig), sweeps)
    seconds, settings = time.process_time() - begun, EvaluationSettings(matching=MatchingSettings(min_heard=1))
    return Outcome(seed=seed, evaluation=evaluate(found, simulation.truth, settings), seconds=seconds)


def outline(rng: np.random.Generator) -> FloatArray:
    """Draw a rectangle that lacks one or two of its corners."""
    x, y = BOARD * rng.choice(WIDTHS, 2)
    vertices = list[list[float]]()
    lacking = rng.permutation(4) < rng.integers(1, 3)
    for number, (corner, lacks) in enumerate(zip([[0, 0], [x, 0], [x, y], [0, y]], lacking, strict=True)):
        if not lacks:
            vertices.append(corner)
            continue
        inward = np.sign([x / 2 - corner[0], y / 2 - corner[1]]) * BOARD * rng.choice(LACKING, 2)
        along = [inward * [0.0, 1.0], inward * [1.0, 0.0]]
        before, after = along if number % 2 == 0 else along[::-1]
        vertices += [list(corner + each) for each in (before, inward, after)]
    return np.array(vertices, dtype=np.float64)


def waypoints(outline_xy: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Draw places that are clear of the boards and of each other."""
    floor = Floor(outline_xy=outline_xy)
    for _ in range(WAYPOINTS):
        place = next(floor.places(rng, clearance=CLEAR, tries=TRIES))
        floor = floor.beside(place, APART - CLEAR)
    places: FloatArray = floor.discs[:, :2]
    return places


def turned_sensor(*, coarse: bool) -> Rig:
    """One sensor with a wide beam that is turned all round."""
    step = np.radians(5.0 if coarse else 1.0)
    sensor = Sensor(
        sensor_id=0,
        x=0.0 if coarse else 0.12,
        half_aperture=np.radians(20.0),
        min_range=0.05,
        max_range=2.5,
        resolution=0.01,
    )
    return Rig(name="turned sensor", sensors=(sensor,), servo=Servo(start=0.0, stop=2 * np.pi - 0.5 * step, step=step))


def set_down(sweep: Sweep, marks: FloatArray) -> Sweep:
    """Say of a sweep that it was made on its mark."""
    return replace(sweep, map_from_base=np.broadcast_to(marks[sweep.index], (len(sweep), 3)))


if __name__ == "__main__":
    main()
