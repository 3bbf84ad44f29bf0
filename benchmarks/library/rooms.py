"""Random rooms: one for each seed."""

import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from echoplan.acoustics import Air
from echoplan.arrays import FloatArray
from echoplan.geometry import directions, distances_to_segments, wrap
from echoplan.io import builtin_rig
from echoplan.model import Odometry, Pillar, Polyline, Rig, Route, World
from echoplan.simulation import OdometryNoise, Simulation, SimulationSettings
from echoplan.simulation.schedule import default_firing

__all__ = [
    "ARRAY",
    "DRIFT",
    "LEGS",
    "STATIONS",
    "Drive",
    "Floor",
    "is_oblique",
    "random_drive",
    "random_simulation",
    "sweep_time",
]

ARRAY, STATIONS = "rotary-array", 14
# Stations of a drive, and the odometry of its robot: 2 % of the way, 2 degrees a metre and 2 degrees a turn of 1 rad.
LEGS = 22
DRIFT = OdometryNoise(along=0.02, yaw_per_metre=math.radians(2.0), yaw_per_radian=math.radians(2.0))

# Sides of a room, of a box [m]; of the part that an L lacks, as a share of the room's; radii of cylinders [m].
_SIDES, _BOX, _CUT, _RADII = (3.0, 5.5), (0.35, 0.9), (0.3, 0.45), (0.05, 0.2)
# How wide and deep a pier that stands out from a wall, or a niche in it, is [m], and what is left beside it.
_WIDTHS, _DEPTHS, _BESIDE = (0.5, 1.5), (0.2, 0.8), 0.5
# How far the vertices of an oblique room are moved each way [m], and how far its boxes are turned [rad].
_ASKEW, _TURNED = 0.35, 0.6
# What must be free about a box, a cylinder, a station; least way between two of 14 stations [m].
_PASSAGE, _GAP, _BODY, _STRIDE = 0.6, 0.5, 0.33, 0.35
# Temperature that modules assume, and temperatures of rooms whose poses fix the scale [degrees Celsius].
_TEMPERATURE, _TEMPERATURES = 20.0, (10.0, 30.0)
# How far a robot drives from one station to the next [m].
_NEAREST, _FARTHEST = 0.4, 1.1
# Sides of a large room [m], and how fast a robot turns on the spot before each leg if it never halts [rad/s].
_LARGE, _TURNING = (7.0, 11.0), 0.6
# Points of a leg that must be free, this far apart [m].
_FOOT = 0.05
# Places that are tried before a thing is left out, and for all stations together.
_TRIES, _STATION_TRIES = 50, 4000


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Floor:
    """Where there is room: inside an outline, outside of discs.

    Parameters
    ----------
    outline_xy : ndarray, shape (n, 2)
        Vertices [m].
    discs : ndarray, shape (k, 3), optional
        About what stands there: x, y, radius [m].
    """

    outline_xy: FloatArray
    discs: FloatArray = field(default_factory=lambda: np.zeros((0, 3)))

    def is_free(self, point_xy: FloatArray, clearance: float) -> bool:
        """Return True if a disc about a point fits."""
        bearings = np.arctan2(*(self.outline_xy - point_xy).T[::-1])
        is_inside = abs(float(wrap(np.roll(bearings, -1) - bearings).sum())) > np.pi
        sides = np.stack([self.outline_xy, np.roll(self.outline_xy, -1, axis=0)], axis=1)
        apart = np.hypot(*(self.discs[:, :2] - point_xy).T) - self.discs[:, 2]
        nearest = min(float(distances_to_segments(point_xy[None], sides).min()), float(apart.min(initial=np.inf)))
        return is_inside and nearest > clearance

    def places(self, rng: np.random.Generator, *, clearance: float, tries: int = _TRIES) -> Iterator[FloatArray]:
        """Draw points about which a disc fits."""
        low, high = self.outline_xy.min(axis=0), self.outline_xy.max(axis=0)
        points = (rng.uniform(low, high) for _ in range(tries))
        return (point for point in points if self.is_free(point, clearance))

    def beside(self, center_xy: FloatArray, radius: float) -> "Floor":
        """Return what is left of the floor beside one more disc."""
        return Floor(outline_xy=self.outline_xy, discs=np.vstack([self.discs, [*center_xy, radius]]))


def is_oblique(seed: int) -> bool:
    """Return True if the room of a seed has oblique walls: every other one has."""
    return seed % 2 == 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Drive:
    """How a robot drives through a random room, and its sensors.

    Parameters
    ----------
    array : str, optional
        Name of a built-in rig.
    stations : int, optional
        Where it halts; one that got stuck halts less often.
    odometry : OdometryNoise, optional
        Errors of the odometry.
    dropout, stray : float, optional
        Shares of dropouts and of stray echoes.
    air : float, optional
        By how much the air may be warmer or colder than the modules take it to be [degrees Celsius].
    lag : float, optional
        Largest lag of the servo behind the commanded angle [s].
    thermometer : float, optional
        Deviation of a thermometer [degrees]; infinite without one.
    specified : float, optional
        Share of these errors that the rig specifies; None if it specifies none.
    speed : float, optional
        How fast the robot drives while the head turns [m/s]; None if it halts at each station to sweep.
    large : bool, optional
        Whether rooms are about twice as long and wide.
    waits : bool, optional
        Whether the robot stands for the first sweep before it drives without halts.
    """

    array: str = ARRAY
    stations: int = LEGS
    odometry: OdometryNoise = DRIFT
    dropout: float = 0.02
    stray: float = 0.02
    air: float = 0.0
    lag: float = 0.0
    thermometer: float = math.inf
    specified: float | None = None
    speed: float | None = None
    large: bool = False
    waits: bool = False


def random_drive(seed: int, drive: Drive | None = None) -> Simulation:
    """Drive through a random room by odometry.

    The rooms are those of ``random_simulation``, in air that the modules know: odometry with errors of 2 % cannot
    show the scale error of 1.7 per mille a degree.  From each station the robot
    turns to a place nearby to which the way is free, and drives there.

    Parameters
    ----------
    seed : int
        Of the room, the way through it and the noise.
    drive : Drive, optional
        How.

    Returns
    -------
    Simulation
        With the true poses beside it.
    """
    rng, how = np.random.default_rng(seed), drive or Drive()
    floor = Floor(outline_xy=_outline(rng, oblique=is_oblique(seed), sides=_LARGE if how.large else _SIDES))
    floor, boxes = _boxes(floor, rng, oblique=is_oblique(seed))
    floor, pillars = _pillars(floor, rng)
    room = Polyline(points_xy=floor.outline_xy, closed=True)
    route = _drive(floor, rng, how.stations)
    rig = _with_specified_odometry(builtin_rig(how.array), how)
    if how.speed is not None:
        route = _without_halts(route, how.speed, wait=sweep_time(rig) if how.waits else 0.0)
    temperature = _TEMPERATURE + float(rng.uniform(-how.air, how.air))
    latency = float(rng.uniform(0.0, how.lag))
    return Simulation(
        world=World(name=f"drive {seed}", polylines=(room, *boxes), pillars=pillars),
        rig=rig,
        route=route,
        settings=SimulationSettings(
            dropout=how.dropout,
            stray=how.stray,
            odometry=how.odometry,
            air=Air(temperature=temperature),
            servo_latency=latency,
            thermometer=how.thermometer,
        ),
        seed=seed,
    )


def _with_specified_odometry(rig: Rig, how: Drive) -> Rig:
    if how.specified is None:
        return rig
    return replace(rig, odometry=Odometry(**{name: how.specified * sigma for name, sigma in how.odometry}))


def random_simulation(
    seed: int, *, array: str = ARRAY, stations: int = STATIONS, misset: bool = False, recess: bool = False
) -> Simulation:
    """Simulate a random room with a built-in array.

    A rectangle or an L with up to two boxes and three cylinders, at right angles for even seeds and oblique for odd
    ones.  Everything that the simulator knows takes part, with 2 % dropouts, 2 % stray echoes and air of 10 to 30
    degrees Celsius that the modules take to be of 20.

    Parameters
    ----------
    seed : int
        Of the room, the way through it and the noise.
    array : str, optional
        Its name; the rooms and the way through them are the same for all.
    stations : int, optional
        From how many stations; more of them stand closer together.
    misset : bool, optional
        Whether modules were set right only to within a step of their readings.
    recess : bool, optional
        Whether a pier stands out from one wall, or there is a niche in it.

    Returns
    -------
    Simulation
        With the truth beside it.
    """
    rng = np.random.default_rng(seed)
    outline_xy = _outline(rng, oblique=is_oblique(seed))
    floor = Floor(outline_xy=_with_recess(outline_xy, rng) if recess else outline_xy)
    floor, boxes = _boxes(floor, rng, oblique=is_oblique(seed))
    floor, pillars = _pillars(floor, rng)
    room = Polyline(points_xy=floor.outline_xy, closed=True)
    air, rig = Air(temperature=float(rng.uniform(*_TEMPERATURES))), builtin_rig(array)
    route = _route(floor, rng, stations)
    error = float(rng.uniform(-0.5, 0.5)) * rig.sensors[0].resolution if misset else 0.0
    return Simulation(
        world=World(name=f"random room {seed}", polylines=(room, *boxes), pillars=pillars),
        rig=rig,
        route=route,
        settings=SimulationSettings(dropout=0.02, stray=0.02, air=air, zero_error=error),
        seed=seed,
    )


def _outline(rng: np.random.Generator, *, oblique: bool, sides: tuple[float, float] = _SIDES) -> FloatArray:
    """Draw a rectangle or an L, and move its vertices if it is to be oblique."""
    x, y = rng.uniform(*sides, 2)
    lacking_x, lacking_y = rng.uniform(*_CUT, 2) * (x, y)
    notch = [[x, y - lacking_y], [x - lacking_x, y - lacking_y], [x - lacking_x, y]]
    vertices = np.array([[0.0, 0.0], [x, 0.0], *(notch if rng.random() < 0.5 else [[x, y]]), [0.0, y]])
    moved: FloatArray = vertices + oblique * rng.uniform(-_ASKEW, _ASKEW, vertices.shape)
    return moved


def _with_recess(outline_xy: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Let a pier stand out from the first wall, or sink a niche into it."""
    side = outline_xy[1] - outline_xy[0]
    length = float(np.hypot(*side))
    along = side / length
    width = min(float(rng.uniform(*_WIDTHS)), length - 2.0 * _BESIDE)
    begin, depth = rng.uniform(_BESIDE, length - _BESIDE - width), rng.choice([-1.0, 1.0]) * rng.uniform(*_DEPTHS)
    start, stop = outline_xy[0] + begin * along, outline_xy[0] + (begin + width) * along
    inward = depth * np.array([-along[1], along[0]])
    return np.vstack([outline_xy[:1], start, start + inward, stop + inward, stop, outline_xy[1:]])


def _boxes(floor: Floor, rng: np.random.Generator, *, oblique: bool) -> tuple[Floor, tuple[Polyline, ...]]:
    """Put up to two boxes on the floor."""
    boxes = []
    for _ in range(rng.integers(0, 3)):
        sides, turn = rng.uniform(*_BOX, 2), oblique * rng.uniform(-_TURNED, _TURNED)
        reach = 0.5 * float(np.hypot(*sides))
        for center in floor.places(rng, clearance=reach + _PASSAGE):
            axes = directions(np.array([turn, turn + np.pi / 2]))
            corners = center + 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * sides @ axes
            boxes.append(Polyline(points_xy=corners, closed=True))
            floor = floor.beside(center, reach)
            break
    return floor, tuple(boxes)


def _pillars(floor: Floor, rng: np.random.Generator) -> tuple[Floor, tuple[Pillar, ...]]:
    """Put one to three cylinders on the floor."""
    pillars = []
    for _ in range(rng.integers(1, 4)):
        radius = float(rng.uniform(*_RADII))
        for center in floor.places(rng, clearance=radius + _GAP):
            pillars.append(Pillar(center_xy=center, radius=radius))
            floor = floor.beside(center, radius)
            break
    return floor, tuple(pillars)


def _route(floor: Floor, rng: np.random.Generator, stations: int) -> Route:
    """Choose stations with any heading; the more there are the closer they stand."""
    stride, chosen = _STRIDE * min(1.0, float(np.sqrt(STATIONS / stations))), np.zeros((0, 2))
    for place in floor.places(rng, clearance=_BODY, tries=_STATION_TRIES):
        if len(chosen) < stations and np.hypot(*(chosen - place).T).min(initial=np.inf) > stride:
            chosen = np.vstack([chosen, place])
    return Route(map_from_base=np.column_stack([chosen, rng.uniform(-np.pi, np.pi, len(chosen))]))


def _drive(floor: Floor, rng: np.random.Generator, stations: int) -> Route:
    """Drive from place to place."""
    way = [next(floor.places(rng, clearance=_BODY, tries=_STATION_TRIES))]
    while len(way) < stations:
        choices = floor.places(rng, clearance=_BODY, tries=_STATION_TRIES)
        place = next((place for place in choices if _is_free(floor, way[-1], place)), None)
        if place is None:
            break
        way.append(place)
    legs = np.diff(way, axis=0)
    yaws = np.arctan2(legs[:, 1], legs[:, 0])
    return Route(map_from_base=np.column_stack([way, np.append(yaws, yaws[-1])]))


def sweep_time(rig: Rig) -> float:
    """Return how long one sweep takes [s]."""
    firing = default_firing(rig)
    return firing.period * len(firing.groups) * (len(rig.servo.angles) if rig.servo else 1)


def _without_halts(route: Route, speed: float, *, wait: float) -> Route:
    """Let the robot wait [s], then drive each leg straight at a speed [m/s], and turn on the spot between legs."""
    poses, seconds = [route.map_from_base[0]], [0.0]
    if wait:
        poses.append(poses[0])
        seconds.append(wait)
    for before, after in itertools.pairwise(route.map_from_base):
        poses.append(np.append(after[:2], before[2]))
        seconds.append(seconds[-1] + math.dist(before[:2], after[:2]) / speed)
        if turn := abs(float(wrap(after[2] - before[2]))):
            poses.append(after)
            seconds.append(seconds[-1] + turn / _TURNING)
    return Route(map_from_base=np.array(poses), stamps_ns=np.round(1e9 * np.array(seconds)).astype(np.int64))


def _is_free(floor: Floor, start: FloatArray, stop: FloatArray) -> bool:
    """Return True if a leg is neither short nor long, and a robot fits all along it."""
    length = math.dist(start, stop)
    if not _NEAREST < length < _FARTHEST:
        return False
    shares = np.linspace(0.0, 1.0, max(2, int(length / _FOOT)))
    return all(floor.is_free(point, _BODY) for point in start + shares[:, None] * (stop - start))
