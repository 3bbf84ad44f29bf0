"""Latent walls: walls that were detected only by multipath, whose echoes look like another wall.

A corner of about a right angle returns sound over both walls, also to places to which neither returns a direct echo. If
one of the walls is not in the map, the model has no path for this echo; and readings of two stations mostly agree with
some line as a direct echo. So a wall of few stations has a rival: a latent wall that forms a corner with a known wall,
at any place and angle, and has as many parameters.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, SonarTables
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.likelihood.double_bounces import ghosts_of_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.image_sources import Extent, Point
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.kernels import order_of
from echoplan.preprocessing.measurements import Measurements, select_measurements

__all__ = ["log_densities_over_latent_walls"]

_WALL = int(Kind.WALL)

# Opening angles of corners that return sound over both walls [rad]: echoes of wider corners are too weak, and in
# narrower ones the sound meets a third wall.
_OPENINGS = np.radians(np.arange(50.0, 111.0))
# Greatest distance of the corner beyond the extent of the known wall, and within it [m].
_BEYOND, _BEFORE = 3.0, 0.1
# Reflecting part of both walls: up to the first distance from the corner, and the second past it [m].
_LONG, _PAST = 2.5, 0.05
# Factor on the noise in the first search; number of corners that are refined; number of halvings of the steps.
_COARSE, _BEST, _HALVINGS = 4.0, 8, 7
# First steps along the known wall and in opening angle [m, rad].
_ALONG, _TURN = 0.02, math.radians(0.5)

# A wall with its extent; a sensor position with half of the path length of its echo [m].
_Known: TypeAlias = tuple[FloatArray, Extent]
_StrongestEcho: TypeAlias = tuple[Point, float]


class Corner(NamedTuple):
    """Corner of a latent wall with a known wall."""

    # Position along the known wall [m].
    place: float
    # Angle between both walls [rad].
    opening: float
    # End of the known wall at the corner: 1 for greatest, -1 for least position along it.
    side: float


def log_densities_over_latent_walls(
    likelihood: PingLikelihood, wall: Hypothesis, others: Sequence[Hypothesis], log_densities: FloatArray
) -> FloatArray:
    """Return the log density of each reading by the latent wall that explains most [log 1/m], shape (n,).

    Only readings that ``wall`` newly explains count, and only walls among ``others`` with a greater log-likelihood
    ratio may form the corner. ``log_densities`` are those of the readings by the others. The result is ``NO_ECHO``
    elsewhere.
    """
    echo_densities, own = (
        np.full(len(log_densities), NO_ECHO),
        wall.ping_scores.pings[wall.newly_explained(log_densities)],
    )
    if not len(own):
        return echo_densities
    chosen = np.zeros(len(log_densities), dtype=bool)
    chosen[own] = True
    few, loudest = select_measurements(likelihood.measurements, chosen), _strongest(likelihood, own)
    most = 0.0
    for known in others:
        if known.is_wall and known.llr > wall.llr:
            pair = known.reflector, known.extent
            gain, echoes = _best_echoes(few, likelihood.tables, pair, loudest, log_densities[chosen], likelihood.noise)
            if gain > most:
                most, echo_densities[chosen] = gain, echoes
    return echo_densities


def _strongest(likelihood: PingLikelihood, pings: IntArray) -> _StrongestEcho:
    """Return the shortest reading of the station with most of these pings, and its sensor [m].

    The strongest echo reads shortest, because of the range walk.
    """
    measurements = likelihood.measurements
    best = np.argmax(np.bincount(measurements.stations[pings]))
    here = pings[measurements.stations[pings] == best]
    first = here[np.argmin(measurements.readings[here])]
    reading = float(measurements.readings[first]) * likelihood.tables.scale
    return (float(measurements.x[first]), float(measurements.y[first])), reading


@compiled
def _best_echoes(
    few: Measurements, tables: SonarTables, known: _Known, loudest: _StrongestEcho, bare: FloatArray, noise: float
) -> tuple[float, FloatArray]:
    """Return the gain of the best latent wall at a known wall [nats], and its log densities."""
    corners, llr_by_station = _corners(few, tables, known, loudest, bare, _COARSE * noise)
    most, echoes = 0.0, np.full(len(bare), NO_ECHO)
    for number in order_of(-llr_by_station)[:_BEST]:
        if llr_by_station[number] > 0.0:
            corner = Corner(corners[number, 0], corners[number, 1], corners[number, 2])
            gain, log_densities = _refined(few, tables, known[0], corner, bare, noise)
            if gain > most:
                most, echoes = gain, log_densities
    return most, echoes


@inlined
def _corners(
    few: Measurements, tables: SonarTables, known: _Known, loudest: _StrongestEcho, bare: FloatArray, noise: float
) -> tuple[FloatArray, FloatArray]:
    """Return the corners whose echo is as long as the measured one, and the gain of each [nats].

    The echo of a corner narrower than a right angle is shorter than the distance of its vertex, by the factor
    sin(opening).
    """
    (wall, extent), (place, reading) = known, loudest
    x, y = math.cos(wall[1]), math.sin(wall[1])
    depth, foot = wall[2] - x * place[0] - y * place[1], x * place[1] - y * place[0]
    corners, llr_by_station = np.zeros((2 * len(_OPENINGS), 3)), np.zeros(2 * len(_OPENINGS))
    for number in range(len(llr_by_station) if depth > 0.0 else 0):
        opening, side = _OPENINGS[number // 2], 2.0 * (number % 2) - 1.0
        away = reading / math.sin(min(opening, 0.5 * math.pi))
        vertex = foot + side * math.sqrt(max(away * away - depth * depth, 0.0))
        beyond = side * (vertex - extent[number % 2])
        if away > depth and -_BEFORE < beyond < _BEYOND:
            corners[number, 0], corners[number, 1], corners[number, 2] = vertex, opening, side
            log_densities = _echoes(few, tables, wall, Corner(vertex, opening, side), noise)
            llr_by_station[number] = _gain(few, log_densities, bare)
    return corners, llr_by_station


@inlined
def _refined(
    few: Measurements, tables: SonarTables, wall: FloatArray, corner: Corner, bare: FloatArray, noise: float
) -> tuple[float, FloatArray]:
    """Refine a corner by a pattern search with halved steps; return its gain [nats] and log densities."""
    log_densities = _echoes(few, tables, wall, corner, noise)
    gain, along, turn = _gain(few, log_densities, bare), _ALONG, _TURN
    for _ in range(_HALVINGS):
        middle = corner
        for cell in range(9):
            place, opening = middle.place + (cell // 3 - 1) * along, middle.opening + (cell % 3 - 1) * turn
            tried = Corner(place, opening, middle.side)
            echo_densities = _echoes(few, tables, wall, tried, noise)
            more = _gain(few, echo_densities, bare)
            if more > gain:
                corner, gain, log_densities = tried, more, echo_densities
        along, turn = 0.5 * along, 0.5 * turn
    return gain, log_densities


@inlined
def _gain(few: Measurements, log_densities: FloatArray, bare: FloatArray) -> float:
    """Return the weighted gain in log density over ``bare`` [nats]."""
    gain = 0.0
    for ping in range(len(log_densities)):
        gain += few.weights[ping] * max(log_densities[ping] - bare[ping], 0.0)
    return gain


@inlined
def _echoes(few: Measurements, tables: SonarTables, wall: FloatArray, corner: Corner, noise: float) -> FloatArray:
    """Return the log density of each reading by double bounces over both walls of a corner [log 1/m]."""
    x, y, side = math.cos(wall[1]), math.sin(wall[1]), corner.side
    vertex_x, vertex_y = wall[2] * x - corner.place * y, wall[2] * y + corner.place * x
    angle = wall[1] + side * (math.pi - corner.opening)
    x, y = math.cos(angle), math.sin(angle)
    other = np.array([float(_WALL), angle, vertex_x * x + vertex_y * y, 0.0])
    place = vertex_y * x - vertex_x * y
    return ghosts_of_walls(few, tables, (wall, other), (_ending(corner.place, side), _ending(place, -side)), noise)


@inlined
def _ending(place: float, side: float) -> Extent:
    """Return the reflecting part of a wall that ends at a corner [m]."""
    return (place - _LONG, place + _PAST) if side > 0.0 else (place - _PAST, place + _LONG)
