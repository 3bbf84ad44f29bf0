"""Random flats: rooms with doors and furniture, and a route through all of them, another one for each seed.

A flat is a rectangle that inner walls divide into rooms.  A wall has a face on either side; a door is a gap in it with
two jambs.  The outline of a flat is the boundary of its free space: a chain of wall faces, jambs and the faces of boxes
that stand against a wall.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

import numpy as np

from echoplan.acoustics import Air
from echoplan.arrays import FloatArray
from echoplan.geometry import directions, distances_to_segments
from echoplan.io import builtin_rig
from echoplan.model import Pillar, Polyline, World
from echoplan.simulation import OdometryNoise, Simulation, SimulationSettings
from library.rooms import ARRAY, DRIFT
from library.tours import BODY, find_route

__all__ = [
    "Door",
    "Flat",
    "Room",
    "is_drifting",
    "is_oblique_flat",
    "random_flat",
    "random_plan",
    "thresholds_of",
    "with_box",
]

# Area of a room [m2], length of a flat over its width, share at which a wall divides, shortest side of a room [m].
_AREA, _ASPECT, _SHARE, _SHORTEST = (8.0, 13.0), (1.0, 1.5), (0.42, 0.58), 2.2
# Thickness of inner walls and width of doors [m], and how far the corners of an oblique flat are moved [m]: that
# changes both by up to 7 %, so the limits of 0.08 to 0.16 m and 0.7 to 1.4 m are kept.
_THICKNESS, _DOOR, _ASKEW = (0.087, 0.149), (0.76, 1.3), 0.12
# A door is so far from the corners of its wall, and so much is free before it [m].
_JAMB, _THRESHOLD = 0.33, 0.55
# Sides of a box, depth of one against a wall, its distance from corners, radius of a cylinder [m].
_BOX, _DEPTH, _BESIDE, _RADII = (0.35, 0.9), (0.35, 0.6), 0.4, (0.05, 0.2)
# What is free about a box and a cylinder in the open [m]; how far boxes of an oblique flat are turned [rad].
_PASSAGE, _GAP, _TURNED = 2.1 * BODY, 0.5, 0.6
# Share of the boxes that stand against a wall; places tried for a piece of furniture; flats tried for a seed.
_AGAINST, _TRIES, _FLATS = 0.5, 40, 100
_TEMPERATURES = (10.0, 30.0)
# Where a piece of the outline begins: a door, and the room from which it is seen.
_End: TypeAlias = tuple[int, int]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Door:
    """A gap in the wall between two rooms.

    Parameters
    ----------
    rooms : tuple of int
        The rooms it joins.
    jambs_xy : ndarray, shape (2, 2, 2)
        Item: room in the order of ``rooms``; end of the gap in the face of that room, counter-clockwise about the room;
        x or y [m].
    """

    rooms: tuple[int, int]
    jambs_xy: FloatArray

    @property
    def width(self) -> float:
        """Clear width [m]."""
        return float(np.hypot(*(self.jambs_xy[:, 1] - self.jambs_xy[:, 0]).T).min())

    @property
    def center_xy(self) -> FloatArray:
        """Middle of the gap, shape (2,) [m]."""
        center: FloatArray = self.jambs_xy.mean(axis=(0, 1))
        return center


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Room:
    """A room: its four corners, counter-clockwise, and its furniture.

    Parameters
    ----------
    corners_xy : ndarray, shape (4, 2)
        Corners [m].
    boxes : tuple of Polyline, optional
        Boxes in the open.
    against : mapping of int to ndarray, optional
        Boxes against a wall, by the number of the side: corners in the order of the outline, shape (4, 2) [m].
    pillars : tuple of Pillar, optional
        Cylinders.
    """

    corners_xy: FloatArray
    boxes: tuple[Polyline, ...] = ()
    against: Mapping[int, FloatArray] = field(default_factory=dict)
    pillars: tuple[Pillar, ...] = ()

    @property
    def sides_xy(self) -> FloatArray:
        """Sides of the room, shape (4, 2, 2) [m]."""
        return np.stack([self.corners_xy, np.roll(self.corners_xy, -1, axis=0)], axis=1)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Flat:
    """Rooms and the doors between them."""

    rooms: tuple[Room, ...]
    doors: tuple[Door, ...]

    def world(self, name: str) -> World:
        """Return what stands in the flat: outlines of the free space, boxes and cylinders."""
        outlines = tuple(Polyline(points_xy=points, closed=True) for points in _outlines(self))
        boxes = (box for room in self.rooms for box in room.boxes)
        pillars = (pillar for room in self.rooms for pillar in room.pillars)
        return World(name=name, polylines=(*outlines, *boxes), pillars=tuple(pillars))


def is_drifting(seed: int) -> bool:
    """Return True if the odometry of this flat drifts: every other one."""
    return seed % 2 == 1


def is_oblique_flat(seed: int) -> bool:
    """Return True if the walls of this flat are not at right angles: two of four."""
    return seed // 2 % 2 == 1


def random_flat(seed: int, *, array: str = ARRAY) -> Simulation:
    """Simulate a drive through a random flat of two to four rooms.

    The noise is that of ``random_simulation``: 2 % dropouts, 2 % stray echoes.  Where the poses are exact the air has
    10 to 30 degrees Celsius while the modules assume 20; where they drift the air is as assumed, as in
    ``random_drive``: odometry that is 2 % off does not resolve the scale.

    Parameters
    ----------
    seed : int
        Of the flat, the route and the noise.
    array : str, optional
        Name of a built-in rig.

    Returns
    -------
    Simulation
        With the truth.
    """
    rng = np.random.default_rng(seed)
    for _ in range(_FLATS):
        flat = random_plan(rng, oblique=is_oblique_flat(seed))
        world = flat.world(f"flat {seed}")
        route = find_route(flat, world, rng)
        if route is not None:
            break
    else:
        raise RuntimeError(f"seed {seed}: no route through any of {_FLATS} flats")
    warmth = float(rng.uniform(*_TEMPERATURES))
    return Simulation(
        world=world,
        rig=builtin_rig(array),
        route=route,
        settings=SimulationSettings(
            dropout=0.02,
            stray=0.02,
            air=Air() if is_drifting(seed) else Air(temperature=warmth),
            odometry=DRIFT if is_drifting(seed) else OdometryNoise(),
        ),
        seed=seed,
    )


def random_plan(rng: np.random.Generator, *, oblique: bool) -> Flat:
    """Draw a flat: rooms, doors, furniture."""
    rectangles = _divided(rng, int(rng.integers(2, 5)))
    gaps = _gaps(rectangles, rng)
    moved = _homography(rectangles, rng, oblique=oblique)
    rooms = [Room(corners_xy=_mapped(_corners(each), moved)) for each in rectangles]
    doors = tuple(Door(rooms=pair, jambs_xy=_mapped(jambs, moved)) for pair, jambs in gaps.items())
    return Flat(rooms=tuple(_furnished(room, doors, rng, oblique=oblique) for room in rooms), doors=doors)


def _divided(rng: np.random.Generator, count: int) -> list[FloatArray]:
    """Divide a rectangle into rooms (x0, y0, x1, y1): a wall across the largest one, until there are enough."""
    area, aspect = count * rng.uniform(*_AREA), rng.uniform(*_ASPECT)
    rooms = [np.array([0.0, 0.0, math.sqrt(area * aspect), math.sqrt(area / aspect)])]
    while len(rooms) < count:
        rooms.sort(key=lambda room: float(np.prod(room[2:] - room[:2])))
        low_x, low_y, high_x, high_y = room = rooms.pop()
        axis = int(high_y - low_y > high_x - low_x)
        thickness, side = rng.uniform(*_THICKNESS), room[2 + axis] - room[axis]
        margin = (_SHORTEST + thickness) / side
        face = room[axis] + side * float(np.clip(rng.uniform(*_SHARE), margin, max(margin, 1.0 - margin)))
        first, second = room.copy(), room.copy()
        first[2 + axis], second[axis] = face, face + thickness
        rooms += [first, second]
    return rooms


def _corners(rectangle: FloatArray) -> FloatArray:
    return rectangle[[[0, 1], [2, 1], [2, 3], [0, 3]]]


def _gaps(rectangles: Sequence[FloatArray], rng: np.random.Generator) -> dict[tuple[int, int], FloatArray]:
    """Place a door in each wall between two rooms that is long enough: jambs by pair of rooms, as ``Door`` has them."""
    gaps = {}
    for first, a in enumerate(rectangles):
        for second, b in enumerate(rectangles):
            for axis in (0, 1):
                across = 1 - axis
                low, high = max(a[across], b[across]), min(a[2 + across], b[2 + across])
                is_wall = 0.0 < b[axis] - a[2 + axis] < 2.0 * _THICKNESS[1]
                width = float(rng.uniform(*_DOOR))
                if not is_wall or high - low < width + 2.0 * _JAMB:
                    continue
                start = float(rng.uniform(low + _JAMB, high - _JAMB - width))
                # Counter-clockwise about a room, its right side runs upwards and its upper side to the left.
                ends = [start, start + width] if axis == 0 else [start + width, start]
                along = np.array([ends, ends[::-1]])
                faces = np.array([[a[2 + axis]] * 2, [b[axis]] * 2])
                gaps[first, second] = np.stack([faces, along] if axis == 0 else [along, faces], axis=-1)
    return gaps


def _homography(rectangles: Sequence[FloatArray], rng: np.random.Generator, *, oblique: bool) -> FloatArray:
    """Return a map of the plane that moves the corners of the flat, if it is oblique, and keeps lines straight."""
    low, high = np.min(rectangles, axis=0)[:2], np.max(rectangles, axis=0)[2:]
    corners = _corners(np.concatenate([low, high]))
    targets = corners + oblique * rng.uniform(-_ASKEW, _ASKEW, corners.shape)
    rows, values = [], []
    for (x, y), (u, v) in zip(corners, targets, strict=True):
        rows += [[x, y, 1, 0, 0, 0, -u * x, -u * y], [0, 0, 0, x, y, 1, -v * x, -v * y]]
        values += [u, v]
    solution = np.linalg.solve(np.array(rows), np.array(values)) if oblique else np.eye(3).ravel()[:8]
    return np.append(solution, 1.0).reshape(3, 3)


def _mapped(points_xy: FloatArray, homography: FloatArray) -> FloatArray:
    weighted = points_xy @ homography[:, :2].T + homography[:, 2]
    mapped: FloatArray = weighted[..., :2] / weighted[..., 2:]
    return mapped


def _furnished(room: Room, doors: Sequence[Door], rng: np.random.Generator, *, oblique: bool) -> Room:
    """Put up to two boxes and two cylinders into a room, none before a door."""
    thresholds = thresholds_of(doors)
    for _ in range(rng.integers(0, 3)):
        if rng.random() < _AGAINST:
            room = _with_box_at_wall(room, thresholds, rng)
        else:
            room = with_box(room, thresholds, rng, turned=oblique * float(rng.uniform(-_TURNED, _TURNED)))
    for _ in range(rng.integers(0, 3)):
        room = _with_pillar(room, thresholds, rng)
    return room


def thresholds_of(doors: Sequence[Door]) -> FloatArray:
    """Return circles before doors that must be free: rows of x, y and radius [m]."""
    return np.array([[*door.center_xy, 0.5 * door.width + _THRESHOLD] for door in doors]).reshape(-1, 3)


def with_box(room: Room, thresholds: FloatArray, rng: np.random.Generator, *, turned: float) -> Room:
    """Put a box where the robot can drive around it, if there is such a place."""
    axes = directions(np.array([turned, turned + np.pi / 2]))
    shape = 0.5 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * rng.uniform(*_BOX, 2) @ axes
    for center in _places(room, rng):
        outline = _sampled(center + shape)
        if _is_free(outline, _PASSAGE, sides=room.sides_xy, room=room, thresholds=thresholds):
            return replace(room, boxes=(*room.boxes, Polyline(points_xy=center + shape, closed=True)))
    return room


def _with_box_at_wall(room: Room, thresholds: FloatArray, rng: np.random.Generator) -> Room:
    """Put a box against a wall that has none, if there is a place that leaves a passage to what is opposite."""
    width, depth = float(rng.uniform(*_BOX)), float(rng.uniform(*_DEPTH))
    for _ in range(_TRIES):
        side = int(rng.integers(0, 4))
        start, stop = room.sides_xy[side]
        length = math.dist(start, stop)
        if side in room.against or length < width + 2.0 * _BESIDE:
            continue
        along = (stop - start) / length
        begin = start + along * rng.uniform(_BESIDE, length - _BESIDE - width)
        inward = depth * np.array([-along[1], along[0]])
        corners = np.array([begin, begin + inward, begin + inward + width * along, begin + width * along])
        opposite = room.sides_xy[[(side + 2) % 4]]
        if _is_free(_sampled(corners), _PASSAGE, sides=opposite, room=room, thresholds=thresholds):
            return replace(room, against={**room.against, side: corners})
    return room


def _with_pillar(room: Room, thresholds: FloatArray, rng: np.random.Generator) -> Room:
    """Put a cylinder somewhere, if there is a place."""
    radius = float(rng.uniform(*_RADII))
    for center in _places(room, rng):
        if _is_free(center[None], radius + _GAP, sides=room.sides_xy, room=room, thresholds=thresholds):
            return replace(room, pillars=(*room.pillars, Pillar(center_xy=center, radius=radius)))
    return room


def _places(room: Room, rng: np.random.Generator) -> FloatArray:
    """Draw points of a room, as shares of its sides."""
    x, y = rng.uniform(0.0, 1.0, (2, _TRIES, 1))
    a, b, c, d = room.corners_xy
    places: FloatArray = (1 - x) * (1 - y) * a + x * (1 - y) * b + x * y * c + (1 - x) * y * d
    return places


def _sampled(corners_xy: FloatArray) -> FloatArray:
    """Return points along the outline of a box, 0.1 m apart or less."""
    shares = np.linspace(0.0, 1.0, 10)[:, None]
    sides = zip(corners_xy, np.roll(corners_xy, -1, axis=0), strict=True)
    return np.concatenate([start + shares * (stop - start) for start, stop in sides])


def _is_free(points_xy: FloatArray, gap: float, *, sides: FloatArray, room: Room, thresholds: FloatArray) -> bool:
    """Return True if all points keep a gap to walls and furniture, and none is before a door."""
    boxes = [*(box.points_xy for box in room.boxes), *room.against.values()]
    faces = [np.stack([box, np.roll(box, -1, axis=0)], axis=1) for box in boxes]
    distances = [distances_to_segments(points_xy, np.concatenate([sides, *faces])).min()]
    distances += [np.hypot(*(points_xy - each.center_xy).T).min() - each.radius for each in room.pillars]
    before = [np.hypot(*(points_xy - (x, y)).T).min() - reach for x, y, reach in thresholds]
    return min(distances) > gap and min(before, default=1.0) > 0.0


def _outlines(flat: Flat) -> list[FloatArray]:
    """Join the walls of all rooms at the jambs of doors: outlines of the free space."""
    pieces = dict(piece for number in range(len(flat.rooms)) for piece in _pieces(flat, number))
    outlines = []
    while pieces:
        begin, (end, points) = pieces.popitem()
        outline = [*points]
        while end != begin:
            end, points = pieces.pop(end)
            outline += points
        outlines.append(np.array(outline))
    return outlines


def _pieces(flat: Flat, number: int) -> list[tuple[_End, tuple[_End, list[FloatArray]]]]:
    """Cut the walls of a room at its doors: of each piece where it begins, where the next one begins, and its points.

    A piece begins at a door, seen from a room; where it ends at a door the next one begins in the other room.  A room
    without doors is one piece that ends where it begins.
    """
    room = flat.rooms[number]
    pieces: list[tuple[_End, tuple[_End, list[FloatArray]]]] = []
    begin: _End = (-1, number)
    points: list[FloatArray] = []
    for side, (start, stop) in enumerate(room.sides_xy):
        points.append(start)
        breaks: list[tuple[float, int, FloatArray]] = []
        if side in room.against:
            breaks.append((math.dist(start, room.against[side][0]), -1, room.against[side]))
        for index, door in enumerate(flat.doors):
            if number in door.rooms and _is_on(door.jambs_xy[door.rooms.index(number)], start, stop):
                jambs = door.jambs_xy[door.rooms.index(number)]
                breaks.append((math.dist(start, jambs[0]), index, jambs))
        for _, index, corners in sorted(breaks, key=lambda each: each[0]):
            if index < 0:
                points += list(corners)
                continue
            points.append(corners[0])
            other = sum(flat.doors[index].rooms) - number
            pieces.append((begin, ((index, other), points)))
            begin, points = (index, number), [corners[1]]
    if not pieces:
        return [(begin, (begin, points))]
    # The first piece began at a corner: it continues the last one.
    _, (end, first) = pieces[0]
    return [(begin, (end, points + first)), *pieces[1:]]


def _is_on(points_xy: FloatArray, start: FloatArray, stop: FloatArray) -> bool:
    """Return True if all points are on a segment."""
    return float(distances_to_segments(points_xy, np.stack([start, stop])).max()) < 1e-6
