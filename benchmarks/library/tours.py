"""Routes through flats: stations in all rooms, with legs that are free and lead through every door."""

import heapq
import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import distances_to_segments
from echoplan.model import Route, World

if TYPE_CHECKING:
    from library.flats import Door, Flat

__all__ = ["BODY", "FARTHEST", "NEAREST", "STATIONS", "clearances", "find_route"]

# What must be free about a robot [m]; length of a leg [m]; stations in a room.
BODY = 0.33
NEAREST, FARTHEST = 0.4, 1.1
STATIONS = (10, 16)
# Distance from the wall at which a robot stops before and behind a door [m].
_WAIT = 0.36
# Points drawn in a room as candidates for stations; least distance between two that are kept [m].
_DRAWN, _APART = 400, 0.35
# Points of a leg that must be free are so far apart, and checked with so much to spare [m].
_FOOT, _SPARE = 0.02, 0.001
# Length that a second stop at the same station counts as [m]; tries for the stations of a flat.
_AGAIN, _TRIES = 1.0, 5


def find_route(flat: "Flat", world: World, rng: np.random.Generator) -> Route | None:
    """Drive through every door, and stop in each room at 10 to 16 stations.

    The robot explores a room when it first enters it, and later takes the shortest way through it.

    Parameters
    ----------
    flat : Flat
        Rooms and doors.
    world : World
        What stands there.
    rng : Generator
        Source of randomness.

    Returns
    -------
    Route or None
        None if a room cannot be reached, or no route was found.
    """
    visits = _visits([door.rooms for door in flat.doors], len(flat.rooms), rng)
    if visits is None or not all(_is_passable(door, world) for door in flat.doors):
        return None
    rooms = [_roadmap(number, flat, world, rng) for number in range(len(flat.rooms))]
    for _ in range(_TRIES):
        stations = _stations(visits, rooms, rng)
        if stations is not None:
            legs = np.diff(stations, axis=0)
            yaws = np.arctan2(legs[:, 1], legs[:, 0])
            return Route(map_from_base=np.column_stack([stations, np.append(yaws, yaws[-1])]))
    return None


def clearances(points_xy: FloatArray, world: World) -> FloatArray:
    """Return the distance from each point to the nearest wall, box or cylinder [m]."""
    nearest: FloatArray = distances_to_segments(points_xy, world.segments_xy).min(axis=1)
    for x, y, radius in world.discs:
        nearest = np.minimum(nearest, np.hypot(*(points_xy - (x, y)).T) - radius)
    return nearest


class _Roadmap:
    """Candidates for stations in a room, and the free legs between them."""

    def __init__(self, nodes_xy: FloatArray, entrances: dict[int, int], world: World) -> None:
        self.nodes_xy, self.entrances = nodes_xy, entrances
        self.legs: dict[int, dict[int, float]] = {number: {} for number in range(len(nodes_xy))}
        for a, b in zip(*np.triu_indices(len(nodes_xy), 1), strict=True):
            length = math.dist(nodes_xy[a], nodes_xy[b])
            if NEAREST <= length <= FARTHEST and _is_clear(nodes_xy[a], nodes_xy[b], world):
                self.legs[int(a)][int(b)] = self.legs[int(b)][int(a)] = length

    def path(self, start: int, stop: int, visited: Sequence[int]) -> list[int] | None:
        """Return the nodes of the shortest way, without the first; None if there is none (Dijkstra)."""
        queue: list[tuple[float, int, list[int]]] = [(0.0, start, [])]
        done = set()
        while queue:
            length, node, path = heapq.heappop(queue)
            if node == stop:
                return path
            if node in done:
                continue
            done.add(node)
            for other, leg in self.legs[node].items():
                if other not in done:
                    heapq.heappush(queue, (length + leg + _AGAIN * (other in visited), other, [*path, other]))
        return None

    def tour(self, begin: int, end: int | None, *, fewest: int) -> list[int] | None:
        """Return the nodes of a way that visits what is farthest from all stops so far, and then goes to its end."""
        stops = [begin]
        reachable = [node for node in self.legs if self.path(begin, node, []) is not None]
        for _ in range(fewest + 1):
            home = [] if end is None or end == stops[-1] else self.path(stops[-1], end, stops)
            if home is None:
                return None
            if len(stops) + len(home) >= fewest:
                return stops + home
            away = np.linalg.norm(self.nodes_xy[reachable][:, None] - self.nodes_xy[stops], axis=2).min(axis=1)
            stops += self.path(stops[-1], reachable[int(away.argmax())], stops) or []
        return None


def _visits(doors: Sequence[tuple[int, int]], rooms: int, rng: np.random.Generator) -> list[tuple[int, int]] | None:
    """Return the order in which to visit rooms, and the door by which to leave each (-1: the last one).

    All doors are passed at least once; None if a room cannot be reached.  A room with an odd number of doors is the
    better start (Euler).
    """
    degrees = Counter(room for pair in doors for room in pair)
    starts = sorted(range(rooms), key=lambda room: (degrees[room] % 2 == 0, rng.random()))
    room, unused = starts[0], set(range(len(doors)))
    visits = []
    while unused:
        leaving = _next_door(room, doors, unused)
        if leaving is None:
            return None
        unused.discard(leaving)
        visits.append((room, leaving))
        room = sum(doors[leaving]) - room
    visits.append((room, -1))
    return visits if len({room for room, _ in visits}) == rooms else None


def _next_door(start: int, doors: Sequence[tuple[int, int]], unused: set[int]) -> int | None:
    """Return the door of a room that leads to the nearest unused door (breadth first)."""
    queue, seen = [(start, -1)], {start}
    for room, first in queue:
        here = [index for index, pair in enumerate(doors) if room in pair]
        if free := [index for index in here if index in unused]:
            return free[0] if first < 0 else first
        for index in here:
            other = sum(doors[index]) - room
            if other not in seen:
                seen.add(other)
                queue.append((other, index if first < 0 else first))
    return None


def _stations(
    visits: Sequence[tuple[int, int]], rooms: Sequence[_Roadmap], rng: np.random.Generator
) -> FloatArray | None:
    """Return the stations of all visits, or None if a room has too few or too many."""
    stations, counts, entered = [], Counter[int](), -1
    for number, leaving in visits:
        room = rooms[number]
        begin = room.entrances[entered] if entered >= 0 else int(rng.integers(len(room.nodes_xy)))
        end = room.entrances[leaving] if leaving >= 0 else None
        tour = room.tour(begin, end, fewest=0 if counts[number] else int(rng.integers(STATIONS[0], STATIONS[1] - 1)))
        if tour is None:
            return None
        counts[number] += len(tour)
        stations.append(room.nodes_xy[tour])
        entered = leaving
    if not all(STATIONS[0] <= counts[number] <= STATIONS[1] for number in range(len(rooms))):
        return None
    return np.concatenate(stations)


def _roadmap(number: int, flat: "Flat", world: World, rng: np.random.Generator) -> _Roadmap:
    """Draw candidates in a room, with clearance and apart from each other, beside the stops at its doors."""
    doors = [index for index, door in enumerate(flat.doors) if number in door.rooms]
    nodes = [_stop(flat.doors[index], number) for index in doors]
    x, y = rng.uniform(0.0, 1.0, (2, _DRAWN, 1))
    a, b, c, d = flat.rooms[number].corners_xy
    drawn = (1 - x) * (1 - y) * a + x * (1 - y) * b + x * y * c + (1 - x) * y * d
    for point in drawn[clearances(drawn, world) > BODY + _SPARE]:
        if min((math.dist(point, node) for node in nodes), default=math.inf) > _APART:
            nodes.append(point)
    return _Roadmap(np.array(nodes), {index: place for place, index in enumerate(doors)}, world)


def _stop(door: "Door", room: int) -> FloatArray:
    """Return where the robot stops before it drives through the middle of a door, or after it."""
    left, right = door.jambs_xy[door.rooms.index(room)]
    along = (right - left) / math.dist(left, right)
    stop: FloatArray = 0.5 * (left + right) + _WAIT * np.array([-along[1], along[0]])
    return stop


def _is_passable(door: "Door", world: World) -> bool:
    first, second = (_stop(door, room) for room in door.rooms)
    return _is_clear(first, second, world)


def _is_clear(start: FloatArray, stop: FloatArray, world: World) -> bool:
    """Return True if the robot has room all along a leg."""
    shares = np.linspace(0.0, 1.0, 2 + int(math.dist(start, stop) / _FOOT))
    return bool(clearances(start + shares[:, None] * (stop - start), world).min() > BODY + _SPARE)
