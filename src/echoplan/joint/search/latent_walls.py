"""Unheard walls: of some corners one side was heard in the other only, and such echoes look like walls themselves.

A corner that opens about a right angle sends sound back over both of its sides, also to where neither sends any back by
itself.  If nothing is known of one of them, the echo has no name; and whatever two stations heard, there mostly is a
line that it may have come straight back from.  So what few stations speak for has a rival: a wall that stands somewhere
on a known one, at any angle, and needs as many parameters.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing, Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.likelihood.double_bounces import ghosts_of_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.image_sources import Extent, Point
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import UNHEARD
from echoplan.preprocessing.measurements import Measurements, select_measurements

__all__ = ["log_densities_over_latent_walls"]

_WALL = int(Kind.WALL)

# Corners that send sound back over both sides open so wide [rad]: what is left of wider ones is too faint, and sound
# meets a third wall in narrower ones.
_OPENINGS = np.radians(np.arange(50.0, 111.0))
# A known wall ends in a corner no farther than this beyond where it was heard, and no nearer than this before [m].
_BEYOND, _BEFORE = 3.0, 0.1
# So far from the corner its sides reflect, and no farther than this past it [m].
_LONG, _PAST = 2.5, 0.05
# At first readings may scatter so many times more; the best few corners are moved by ever smaller steps [m, rad].
_COARSE, _BEST, _HALVINGS = 4.0, 8, 7
_ALONG, _TURN = 0.02, math.radians(0.5)

# A wall with what was heard of it, and a sensor with half of the way that the sound came to it.
_Known: TypeAlias = tuple[FloatArray, Extent]
_Heard: TypeAlias = tuple[Point, float]


class Corner(NamedTuple):
    """Where an unheard wall stands on a known one.

    Attributes
    ----------
    place : float
        Along the known wall [m].
    opening : float
        Angle between both [rad].
    side : float
        On which end of the known wall: 1 where places along it are greatest, -1 where they are least.
    """

    place: float
    opening: float
    side: float


def log_densities_over_latent_walls(
    likelihood: PingLikelihood, wall: Hypothesis, others: Sequence[Hypothesis], log_densities: FloatArray
) -> FloatArray:
    """Explain what speaks for a wall by echoes over a stronger one and one that nobody heard.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    wall : Hypothesis
        The wall, judged beside the others.
    others : sequence of Hypothesis
        What else is there.
    log_densities : ndarray, shape (n,)
        What these explain.

    Returns
    -------
    ndarray, shape (n,)
        Logarithm of the density of each reading by the unheard wall that explains most [log 1/m]; ``UNHEARD`` where it
        explains nothing.
    """
    echo_densities, own = (
        np.full(len(log_densities), UNHEARD),
        wall.ping_scores.pings[wall.newly_explained(log_densities)],
    )
    if not len(own):
        return echo_densities
    chosen = np.zeros(len(log_densities), dtype=bool)
    chosen[own] = True
    few, loudest = select_measurements(likelihood.measurements, chosen), _loudest(likelihood, own)
    most = 0.0
    for known in others:
        if known.is_wall and known.total > wall.total:
            pair = known.reflector, known.extent
            gain, echoes = _best_echoes(few, likelihood.hearing, pair, loudest, log_densities[chosen], likelihood.noise)
            if gain > most:
                most, echo_densities[chosen] = gain, echoes
    return echo_densities


def _loudest(likelihood: PingLikelihood, pings: IntArray) -> _Heard:
    """Tell where, and how far off, the station with most of these pings reads first: what is loudest is read early."""
    measurements = likelihood.measurements
    best = np.argmax(np.bincount(measurements.stations[pings]))
    here = pings[measurements.stations[pings] == best]
    first = here[np.argmin(measurements.readings[here])]
    reading = float(measurements.readings[first]) * likelihood.hearing.scale
    return (float(measurements.x[first]), float(measurements.y[first])), reading


@compiled
def _best_echoes(
    few: Measurements, hearing: Hearing, known: _Known, loudest: _Heard, bare: FloatArray, noise: float
) -> tuple[float, FloatArray]:
    """Find the unheard wall on a known one whose echoes explain most: by how much, and the levels."""
    corners, llr_by_station = _corners(few, hearing, known, loudest, bare, _COARSE * noise)
    most, echoes = 0.0, np.full(len(bare), UNHEARD)
    for number in np.argsort(-llr_by_station)[:_BEST]:
        if llr_by_station[number] > 0.0:
            corner = Corner(corners[number, 0], corners[number, 1], corners[number, 2])
            gain, log_densities = _refined(few, hearing, known[0], corner, bare, noise)
            if gain > most:
                most, echoes = gain, log_densities
    return most, echoes


@compiled
def _corners(
    few: Measurements, hearing: Hearing, known: _Known, loudest: _Heard, bare: FloatArray, noise: float
) -> tuple[FloatArray, FloatArray]:
    """List corners that return sound as far as it was heard, and what each explains.

    A corner narrower than a right angle is heard from nearer than it is, by the sine of its opening.
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
            corners[number] = vertex, opening, side
            log_densities = _echoes(few, hearing, wall, Corner(vertex, opening, side), noise)
            llr_by_station[number] = _gain(few, log_densities, bare)
    return corners, llr_by_station


@compiled
def _refined(
    few: Measurements, hearing: Hearing, wall: FloatArray, corner: Corner, bare: FloatArray, noise: float
) -> tuple[float, FloatArray]:
    """Move a corner to where it explains most, by ever smaller steps, and tell how much and the levels."""
    log_densities = _echoes(few, hearing, wall, corner, noise)
    gain, along, turn = _gain(few, log_densities, bare), _ALONG, _TURN
    for _ in range(_HALVINGS):
        middle = corner
        for cell in range(9):
            place, opening = middle.place + (cell // 3 - 1) * along, middle.opening + (cell % 3 - 1) * turn
            tried = Corner(place, opening, middle.side)
            echo_densities = _echoes(few, hearing, wall, tried, noise)
            more = _gain(few, echo_densities, bare)
            if more > gain:
                corner, gain, log_densities = tried, more, echo_densities
        along, turn = 0.5 * along, 0.5 * turn
    return gain, log_densities


@compiled
def _gain(few: Measurements, log_densities: FloatArray, bare: FloatArray) -> float:
    gain = 0.0
    for ping in range(len(log_densities)):
        gain += few.weights[ping] * max(log_densities[ping] - bare[ping], 0.0)
    return gain


@compiled
def _echoes(few: Measurements, hearing: Hearing, wall: FloatArray, corner: Corner, noise: float) -> FloatArray:
    """Explain readings by echoes over both sides of a corner."""
    x, y, side = math.cos(wall[1]), math.sin(wall[1]), corner.side
    vertex_x, vertex_y = wall[2] * x - corner.place * y, wall[2] * y + corner.place * x
    angle = wall[1] + side * (math.pi - corner.opening)
    x, y = math.cos(angle), math.sin(angle)
    other = np.array([float(_WALL), angle, vertex_x * x + vertex_y * y, 0.0])
    place = vertex_y * x - vertex_x * y
    return ghosts_of_walls(few, hearing, (wall, other), (_ending(corner.place, side), _ending(place, -side)), noise)


@compiled
def _ending(place: float, side: float) -> Extent:
    """Along a wall that ends at a place, from there on or up to there."""
    return (place - _LONG, place + _PAST) if side > 0.0 else (place - _PAST, place + _LONG)
