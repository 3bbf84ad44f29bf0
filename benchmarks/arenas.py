"""The method joint in random arenas: python benchmarks/arenas.py [ARENAS] [--off METRES] [--turn DEGREES] [--coarse].

Draws so many arenas of boards (24 unless told otherwise), 2.1 or 2.5 m wide and with six or eight walls, as students
build them, and sounds each from five way-points with one sensor that reads centimetres and is turned all round, a
degree at a time, 12 cm ahead of the axis.  Whoever set the robot down was off by so many metres each way (1.5 cm
unless told otherwise) and so many degrees (1.5), as deviations of a normal distribution.  3 % of the readings are
missing, 3 % are strays, and each has a noise of 4 mm before it is rounded.  Prints what is found and how exactly,
whether covariances are true, and the arenas that are not right.  ``--coarse`` turns the sensor by 5 degrees at a time,
about its own centre.

``--students`` lets somebody else build the robot of each arena: the beam is wider than the rig says, the sensor turns
by 2, 3 or 5 degrees at a time, is mounted askew and a little off, and half of the robots repeat readings, take medians
of neighbours or see their own cable.  Way-points are off by 2 cm each way, headings by 3 degrees, and one by up to 15.
"""

import argparse
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from scipy.ndimage import median_filter

from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.evaluation import (
    Evaluation,
    EvaluationSettings,
    MatchingSettings,
    consistency_table,
    evaluate,
    pool,
)
from echoplan.geometry import wrap
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import Polyline, Rig, Route, Sensor, Servo, Sweep, Table, Transducer, World
from echoplan.simulation import Simulation, SimulationSettings
from joint import fault_table
from library.rooms import Floor
from recordings import COLUMNS, row

ARENAS, OFF, TURN = 24, 0.015, 1.5
# Way-points of students: 3 cm off in the mean, headings by a few degrees, and one of them by up to so many.
STUDENTS_OFF, STUDENTS_TURN, ONE_TURN = 0.02, 3.0, 15.0
# Boards are cut in multiples of this [m]; an arena is so many of them wide, and one or two of its corners lack so many.
BOARD, WIDTHS, LACKING = 0.42, (5, 6), (1, 2)
WAYPOINTS, CLEAR, APART, TRIES = 5, 0.2, 0.25, 10_000
# So many students put a free-standing board in, and so many robots see their own cable, in so many of the pings there.
FREE_BOARDS, CABLES, CABLE_SEEN = 0.5, 0.5, 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Robot:
    """What a robot does that its rig does not say.

    Parameters
    ----------
    step : float
        How far the sensor turns between pings [rad].
    piston_radius : float
        Of the transducer [m]; 4 mm hears a wall over 100 degrees.
    askew : float
        How far the sensor looks past where the servo says [rad].
    ahead : float
        How far it stands before the axis of the servo [m].
    median : int
        Each reading is the median of so many neighbours.
    repeats : int
        A new reading is made for each so many steps only, and repeated at the others.
    cable : tuple of float, optional
        Servo angle of the middle of the robot's own cable, half of its width [rad] and its range [m].
    """

    step: float
    piston_radius: float
    askew: float
    ahead: float
    median: int = 1
    repeats: int = 1
    cable: tuple[float, float, float] | None = None


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
    total = row("all", evaluations, sum(each.seconds for each in outcomes))
    title = f"joint in {len(outcomes)} random arenas: recall / precision (%), mean deviation"
    show(Table(title=title, columns=("arenas", *COLUMNS[1:]), rows=(total,)))
    summary = pool(evaluations, rng=np.random.default_rng(0))
    show(consistency_table({name: each.consistency for name, each in summary.classes.items()}))
    show(fault_table({each.seed: each.evaluation for each in outcomes}))


def run(seed: int, *, off: float, turn: float, coarse: bool, students: bool) -> Outcome:
    """Sound one arena, map it and hold the map against the truth."""
    simulation, told, sweeps = sounded(seed, off=off, turn=turn, coarse=coarse, students=students)
    begun = time.process_time()
    found = map_sweeps(JointMapper(told), sweeps)
    seconds, settings = time.process_time() - begun, EvaluationSettings(matching=MatchingSettings(min_heard=1))
    return Outcome(seed=seed, evaluation=evaluate(found, simulation.truth, settings), seconds=seconds)


def sounded(seed: int, *, off: float, turn: float, coarse: bool, students: bool) -> tuple[Simulation, Rig, list[Sweep]]:
    """Sound one arena: what there is, what the rig says, and what was recorded."""
    rng = np.random.default_rng(seed)
    outline_xy = outline(rng)
    robot = some_robot(rng) if students else None
    boards = (free_board(outline_xy, rng),) if students and rng.random() < FREE_BOARDS else ()
    marks = np.column_stack([waypoints(outline_xy, boards, rng), np.zeros(WAYPOINTS)])
    errors = rng.normal(0.0, (off, off, np.radians(turn)), marks.shape)
    told = turned_sensor(step=5.0 if coarse else 1.0, ahead=0.0 if coarse else 0.12)
    rig = told
    if robot:
        errors[rng.integers(WAYPOINTS), 2] = np.radians(rng.uniform(-ONE_TURN, ONE_TURN))
        errors[:, 2] += robot.askew
        told = turned_sensor(step=robot.step, ahead=0.0)
        rig = replace(
            turned_sensor(step=robot.step, ahead=robot.ahead),
            transducer=Transducer(piston_radius=robot.piston_radius),
        )
    simulation = Simulation(
        world=World(
            name=f"arena {seed}",
            polylines=(
                Polyline(points_xy=outline_xy, closed=True),
                *(Polyline(points_xy=board) for board in boards),
            ),
        ),
        rig=rig,
        route=Route(map_from_base=marks + errors),
        settings=SimulationSettings(dropout=0.03, stray=0.03, jitter=0.004),
        seed=seed,
    )
    sweeps = [set_down(sweep, marks) for sweep in simulation]
    return simulation, told, [as_read(sweep, robot, rng) for sweep in sweeps] if robot else sweeps


def some_robot(rng: np.random.Generator) -> Robot:
    """Draw a robot as students build them."""
    habit = rng.choice(["plain", "plain", "median", "repeats"])
    middle, half_width, distance = (
        rng.uniform(0.0, 2 * np.pi),
        np.radians(rng.uniform(6.0, 18.0)),
        rng.uniform(0.1, 0.25),
    )
    return Robot(
        step=float(rng.choice([2.0, 3.0, 5.0])),
        piston_radius=float(rng.uniform(0.004, 0.008)),
        askew=np.radians(rng.normal(0.0, 3.0)),
        ahead=float(rng.normal(0.0, 0.01)),
        median=int(rng.choice([3, 5])) if habit == "median" else 1,
        repeats=int(rng.choice([2, 3])) if habit == "repeats" else 1,
        cable=(middle, half_width, distance) if rng.random() < CABLES else None,
    )


def as_read(sweep: Sweep, robot: Robot, rng: np.random.Generator) -> Sweep:
    """Turn what the sonar heard into what the robot recorded."""
    ranges = sweep.ranges.copy()
    if robot.cable:
        middle, half_width, distance = robot.cable
        beside = np.abs(wrap(sweep.servo_angles - middle)) < half_width
        seen = np.round(distance + rng.normal(0.0, 0.007, len(ranges)), 2)
        ranges = np.where(beside & (rng.random(len(ranges)) < CABLE_SEEN), np.minimum(ranges, seen), ranges)
    if robot.repeats > 1:
        ranges = np.repeat(ranges[:: robot.repeats], robot.repeats)[: len(ranges)]
    if robot.median > 1:
        ranges = median_filter(ranges, robot.median, mode="nearest")
    return replace(sweep, ranges=ranges)


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


def free_board(outline_xy: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Let one wall go on beyond a corner that is lacking, into the room."""
    before, after = outline_xy - np.roll(outline_xy, 1, axis=0), np.roll(outline_xy, -1, axis=0) - outline_xy
    inner = np.flatnonzero(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] < 0.0)
    corner = rng.choice(inner)
    way = rng.choice([before[corner], -after[corner]])
    board: FloatArray = outline_xy[corner] + np.array([[0.0, 0.0], way / np.hypot(*way) * BOARD])
    return board


def waypoints(outline_xy: FloatArray, boards: tuple[FloatArray, ...], rng: np.random.Generator) -> FloatArray:
    """Draw places that are clear of the boards and of each other."""
    floor = Floor(outline_xy=outline_xy)
    for board in boards:
        for place in np.linspace(board[0], board[1], 4):
            floor = floor.beside(place, 0.0)
    for _ in range(WAYPOINTS):
        place = next(floor.places(rng, clearance=CLEAR, tries=TRIES))
        floor = floor.beside(place, APART - CLEAR)
    places: FloatArray = floor.discs[-WAYPOINTS:, :2]
    return places


def turned_sensor(*, step: float, ahead: float) -> Rig:
    """One sensor with a wide beam that is turned all round, by so many degrees at a time, ahead of its axis [m]."""
    turn = np.radians(step)
    sensor = Sensor(
        sensor_id=0,
        x=ahead,
        half_aperture=np.radians(20.0),
        min_range=0.05,
        max_range=2.5,
        resolution=0.01,
    )
    return Rig(name="turned sensor", sensors=(sensor,), servo=Servo(start=0.0, stop=2 * np.pi - 0.5 * turn, step=turn))


def set_down(sweep: Sweep, marks: FloatArray) -> Sweep:
    """Say of a sweep that it was made on its mark."""
    return replace(sweep, map_from_base=np.broadcast_to(marks[sweep.index], (len(sweep), 3)))


if __name__ == "__main__":
    main()
