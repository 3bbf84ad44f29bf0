"""Kinds of simulated recordings on which two versions of the estimator are compared."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from shapely import LineString, Polygon

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, directions, invert
from echoplan.model import Polyline, Rig, Route, Sweep, Truth, World
from echoplan.simulation import Simulation
from library.flats import random_flat
from library.heads import measured_by_hand, simulate_head
from library.ray_cones import cast, with_cones
from library.rooms import STATIONS, Drive, random_drive, random_simulation

__all__ = [
    "POPULATIONS",
    "Population",
    "Recording",
    "bent_room",
    "by_hand",
    "faulty_drive",
    "random_round_room",
    "random_soft_room",
    "rays",
    "soft_room",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """Sweeps with the rig that made them and the truth: what ``write_recording`` and ``write_truth`` write."""

    name: str
    rig: Rig
    sweeps: tuple[Sweep, ...]
    truth: Truth

    def __len__(self) -> int:
        """Count the sweeps."""
        return len(self.sweeps)

    def __iter__(self) -> Iterator[Sweep]:
        """Yield the sweeps."""
        return iter(self.sweeps)


def by_hand(seed: int) -> Recording:
    """Measure places with tape and eye, with a head whose servo is off."""
    _, simulation = simulate_head(seed, gain=0.1, offset=10.0)
    return _recorded(simulation, measured_by_hand(list(simulation), seed))


def rays(seed: int) -> Recording:
    """Cast fans of rays instead of sound."""
    simulation = random_simulation(seed)
    rig = with_cones(simulation.rig, math.radians(15.0))
    sweeps = cast(tuple(simulation), simulation.world, rig, rays=31, noise=0.002, rng=np.random.default_rng(seed))
    return _recorded(simulation, sweeps, rig)


def drive_with_specified_odometry(seed: int) -> Simulation:
    """Drive with a rig file that specifies half of the errors of the odometry."""
    return random_drive(seed, Drive(specified=0.5))


def faulty_drive(seed: int) -> Recording:
    """Drive with five times the errors that the rig file specifies; a wheel slips once, and one pose is wrong."""
    simulation, rng = random_drive(seed, Drive(specified=0.2)), np.random.default_rng((seed, 23))
    sweeps = list(simulation)
    slipped, pushed = (int(each) for each in rng.choice(np.arange(2, len(sweeps) - 1), 2, replace=False))
    sweeps[slipped:] = _displaced(sweeps[slipped:], rng)
    sweeps[pushed : pushed + 1] = _displaced(sweeps[pushed : pushed + 1], rng)
    return _recorded(simulation, sweeps)


def _displaced(sweeps: Sequence[Sweep], rng: np.random.Generator) -> list[Sweep]:
    """Record other poses: the first one is off by 5 to 20 cm and up to 15 degrees, all others with it."""
    first, bearing = sweeps[0].station, rng.uniform(0.0, math.tau)
    off = [*(rng.uniform(0.05, 0.2) * directions(bearing)), rng.uniform(-1.0, 1.0) * math.radians(15.0)]
    error = compose(compose(first, off), invert(first))
    return [replace(sweep, map_from_base=compose(error, sweep.map_from_base)) for sweep in sweeps]


def bent_room(seed: int) -> Recording:
    """Place a robot by hand in a room with a wall that bends by 4 to 8 degrees, and with a board of 2 cm."""
    simulation, rng = random_simulation(seed), np.random.default_rng((seed, 29))
    room, *others = simulation.world.polylines
    points, side = room.points_xy, int(rng.integers(len(room.points_xy)))
    ends = points[[side, (side + 1) % len(points)]]
    bend = ends.mean(axis=0) + _outward(ends, points.mean(axis=0)) * math.tan(math.radians(rng.uniform(2.0, 4.0)))
    bent = Polyline(points_xy=np.insert(points, side + 1, bend, axis=0), closed=True)
    board = _board(points, simulation.route.map_from_base[:, :2], rng)
    simulation = replace(simulation, world=replace(simulation.world, polylines=(bent, *others, board)))
    return _recorded(simulation, measured_by_hand(list(simulation), seed))


def _outward(ends: FloatArray, center_xy: FloatArray) -> FloatArray:
    """Return the normal of a side away from the centre, half as long as the side."""
    half = 0.5 * (ends[1] - ends[0])
    normal: FloatArray = np.array([half[1], -half[0]])
    return normal if normal @ (ends[0] - center_xy) > 0.0 else -normal


def _board(outline: FloatArray, path_xy: FloatArray, rng: np.random.Generator) -> Polyline:
    """Return a board of 0.6 m by 2 cm in a room, away from its walls and from the path of the robot."""
    free = Polygon(outline).buffer(-0.1).difference(LineString(path_xy).buffer(0.2))
    low, high = outline.min(axis=0), outline.max(axis=0)
    while True:
        along = directions(rng.uniform(0.0, math.tau))
        across = np.array([-along[1], along[0]])
        corners = [0.3 * u * along + 0.01 * v * across for u, v in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        board = rng.uniform(low, high) + np.array(corners)
        if free.contains(Polygon(board)):
            return Polyline(points_xy=board, closed=True)


def random_soft_room(seed: int) -> Simulation:
    """Let one wall of a random room be a curtain, a sofa or foam."""
    rng = np.random.default_rng((seed, 13))
    side, material = int(rng.integers(4)), str(rng.choice(["curtain", "upholstery", "foam"]))
    return soft_room(random_simulation(seed), side=side, material=material)


def soft_room(simulation: Simulation, *, side: int, material: str) -> Simulation:
    """Make one side of the first outline of a room of a material."""
    room, *others = simulation.world.polylines
    points = np.roll(room.points_xy, -side, axis=0)
    wall = Polyline(points_xy=points[:2], material=material)
    rest = Polyline(points_xy=np.vstack([points[1:], points[:1]]))
    return replace(simulation, world=replace(simulation.world, polylines=(rest, wall, *others)))


def random_round_room(seed: int, *, sides: int) -> Simulation:
    """Walk through a round room, whose wall is a polygon of many sides about a circle of 1.5 to 2.5 m."""
    rng = np.random.default_rng((seed, 17))
    radius = float(rng.uniform(1.5, 2.5))
    outline = radius * directions(math.tau * np.arange(sides) / sides)
    bearings, away = rng.uniform(0.0, math.tau, STATIONS), 0.75 * radius * np.sqrt(rng.uniform(0.0, 1.0, STATIONS))
    poses = np.column_stack([away[:, None] * directions(bearings), rng.uniform(-math.pi, math.pi, STATIONS)])
    world = World(name=f"round {seed}", polylines=(Polyline(points_xy=outline, closed=True),))
    return replace(random_simulation(seed), world=world, route=Route(map_from_base=poses))


def _recorded(simulation: Simulation, sweeps: list[Sweep], rig: Rig | None = None) -> Recording:
    return Recording(name=simulation.name, rig=rig or simulation.rig, sweeps=tuple(sweeps), truth=simulation.truth)


@dataclass(frozen=True, slots=True, kw_only=True)
class Population:
    """Recordings of one kind: how one is made from its seed, how many there are, and how poses are treated."""

    make: Callable[[int], Simulation | Recording]
    size: int
    poses: str = "auto"

    def seeds(self, *, hold_out: bool) -> range:
        """Return the seeds; those of the hold-out are not looked at while a number or a rule is chosen."""
        first = 1000 if hold_out else 0
        return range(first, first + self.size)


POPULATIONS: Mapping[str, Population] = {
    "rooms": Population(make=random_simulation, size=100),
    "drives": Population(make=random_drive, size=50, poses="correct"),
    "drives with specified odometry": Population(make=drive_with_specified_odometry, size=24),
    "by hand": Population(make=by_hand, size=24),
    "rays": Population(make=rays, size=24),
    "soft walls": Population(make=random_soft_room, size=24),
    "flats": Population(make=random_flat, size=12),
    "faulty drives": Population(make=faulty_drive, size=24),
    "bent walls": Population(make=bent_room, size=24),
}
