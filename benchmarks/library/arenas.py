"""Random arenas of boards, as students build them for a robot with one sensor on a servo."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import median_filter

from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.model import Polyline, Rig, Route, Sensor, Servo, Sweep, Transducer, World
from echoplan.simulation import Simulation, SimulationSettings
from library.rooms import Floor

__all__ = ["STUDENTS_OFF", "STUDENTS_TURN", "at_marks", "simulate_arena"]

# Arenas of students: errors of the marks [m], of the headings [degrees], and of one heading at most [degrees].
STUDENTS_OFF, STUDENTS_TURN, _ONE_TURN = 0.02, 3.0, 15.0
# Length of a board [m]; sides of an arena and of the parts cut from its corners, in boards.
_BOARD, _WIDTHS, _CUTS = 0.42, (5, 6), (1, 2)
# Number of waypoints, their distance from boards and from each other [m], and how many positions are tried.
_WAYPOINTS, _CLEAR, _APART, _TRIES = 5, 0.2, 0.25, 10_000
# Share of arenas with a free-standing board; share of robots that detect their own cable, and of pings that do.
_FREE_BOARDS, _CABLES, _CABLE_DETECTED = 0.5, 0.5, 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Robot:
    """What a robot does that its rig file does not say.

    Parameters
    ----------
    step : float
        Servo step between pings [rad].
    piston_radius : float
        Of the transducer [m]; one of 4 mm detects a wall over 100 degrees.
    askew : float
        Yaw of the sensor relative to the servo angle [rad].
    ahead : float
        Distance of the sensor in front of the servo axis [m].
    median : int
        Each reading is the median of this many neighbours.
    repeats : int
        Every reading is repeated at this many steps.
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


def simulate_arena(
    seed: int, *, off: float, turn: float, coarse: bool, students: bool
) -> tuple[Simulation, Rig, list[Sweep]]:
    """Simulate one arena: the simulation, the rig as specified, and the sweeps as recorded."""
    rng = np.random.default_rng(seed)
    outline_xy = _outline(rng)
    robot = _random_robot(rng) if students else None
    boards = (_free_board(outline_xy, rng),) if students and rng.random() < _FREE_BOARDS else ()
    marks = np.column_stack([_waypoints(outline_xy, boards, rng), np.zeros(_WAYPOINTS)])
    errors = rng.normal(0.0, (off, off, np.radians(turn)), marks.shape)
    specified = _turned_sensor(step=5.0 if coarse else 1.0, ahead=0.0 if coarse else 0.12)
    rig = specified
    if robot:
        errors[rng.integers(_WAYPOINTS), 2] = np.radians(rng.uniform(-_ONE_TURN, _ONE_TURN))
        errors[:, 2] += robot.askew
        specified = _turned_sensor(step=robot.step, ahead=0.0)
        rig = replace(
            _turned_sensor(step=robot.step, ahead=robot.ahead),
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
    sweeps = [at_marks(sweep, marks) for sweep in simulation]
    return simulation, specified, [_as_recorded(sweep, robot, rng) for sweep in sweeps] if robot else sweeps


def at_marks(sweep: Sweep, marks: FloatArray) -> Sweep:
    """Replace the true poses of a sweep by its mark."""
    return replace(sweep, map_from_base=np.broadcast_to(marks[sweep.index], (len(sweep), 3)))


def _random_robot(rng: np.random.Generator) -> Robot:
    """Draw a robot such as students build."""
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
        cable=(middle, half_width, distance) if rng.random() < _CABLES else None,
    )


def _as_recorded(sweep: Sweep, robot: Robot, rng: np.random.Generator) -> Sweep:
    """Apply cable, repeats and median filter to the simulated ranges."""
    ranges = sweep.ranges.copy()
    if robot.cable:
        middle, half_width, distance = robot.cable
        beside = np.abs(wrap(sweep.servo_angles - middle)) < half_width
        seen = np.round(distance + rng.normal(0.0, 0.007, len(ranges)), 2)
        ranges = np.where(beside & (rng.random(len(ranges)) < _CABLE_DETECTED), np.minimum(ranges, seen), ranges)
    if robot.repeats > 1:
        ranges = np.repeat(ranges[:: robot.repeats], robot.repeats)[: len(ranges)]
    if robot.median > 1:
        ranges = median_filter(ranges, robot.median, mode="nearest")
    return replace(sweep, ranges=ranges)


def _outline(rng: np.random.Generator) -> FloatArray:
    """Draw a rectangle from which one or two corners are cut."""
    x, y = _BOARD * rng.choice(_WIDTHS, 2)
    vertices = list[list[float]]()
    is_cut = rng.permutation(4) < rng.integers(1, 3)
    for number, (corner, cut) in enumerate(zip([[0, 0], [x, 0], [x, y], [0, y]], is_cut, strict=True)):
        if not cut:
            vertices.append(corner)
            continue
        inward = np.sign([x / 2 - corner[0], y / 2 - corner[1]]) * _BOARD * rng.choice(_CUTS, 2)
        along = [inward * [0.0, 1.0], inward * [1.0, 0.0]]
        before, after = along if number % 2 == 0 else along[::-1]
        vertices += [list(corner + each) for each in (before, inward, after)]
    return np.array(vertices, dtype=np.float64)


def _free_board(outline_xy: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Extend one wall into the room beyond a cut corner."""
    before, after = outline_xy - np.roll(outline_xy, 1, axis=0), np.roll(outline_xy, -1, axis=0) - outline_xy
    inner = np.flatnonzero(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0] < 0.0)
    corner = rng.choice(inner)
    way = rng.choice([before[corner], -after[corner]])
    board: FloatArray = outline_xy[corner] + np.array([[0.0, 0.0], way / np.hypot(*way) * _BOARD])
    return board


def _waypoints(outline_xy: FloatArray, boards: tuple[FloatArray, ...], rng: np.random.Generator) -> FloatArray:
    """Draw positions at a distance from the boards and from each other."""
    floor = Floor(outline_xy=outline_xy)
    for board in boards:
        for place in np.linspace(board[0], board[1], 4):
            floor = floor.beside(place, 0.0)
    for _ in range(_WAYPOINTS):
        place = next(floor.places(rng, clearance=_CLEAR, tries=_TRIES))
        floor = floor.beside(place, _APART - _CLEAR)
    places: FloatArray = floor.discs[-_WAYPOINTS:, :2]
    return places


def _turned_sensor(*, step: float, ahead: float) -> Rig:
    """Rig of one sensor with a wide beam on a servo: step [degrees], distance before the axis [m]."""
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
