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
from echoplan.joint.likelihood.ping_likelihood import Explanation
from echoplan.joint.likelihood.ping_scores import UNHEARD
from echoplan.preprocessing.ping_arrays import Soundings, chosen_soundings

__all__ = ["levels_over_unheard"]

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


def levels_over_unheard(
    explanation: Explanation, wall: Hypothesis, others: Sequence[Hypothesis], levels: FloatArray
) -> FloatArray:
    """Explain what speaks for a wall by echoes over a stronger one and one that nobody heard.

    Parameters
    ----------
    explanation : Explanation
        The pings.
    wall : Hypothesis
        The wall, judged beside the others.
    others : sequence of Hypothesis
        What else is there.
    levels : ndarray, shape (n,)
        What these explain.

    Returns
    -------
    ndarray, shape (n,)
        Logarithm of the density of each reading by the unheard wall that explains most [log 1/m]; ``UNHEARD`` where it
        explains nothing.
    """
    told, own = np.full(len(levels), UNHEARD), wall.evidence.pings[wall.explains_anew(levels)]
    if not len(own):
        return told
    chosen = np.zeros(len(levels), dtype=bool)
    chosen[own] = True
    few, heard = chosen_soundings(explanation.soundings, chosen), _loudest(explanation, own)
    most = 0.0
    for known in others:
        if known.is_wall and known.total > wall.total:
            pair = known.reflector, known.extent
            gain, echoes = _best_echoes(few, explanation.hearing, pair, heard, levels[chosen], explanation.noise)
            if gain > most:
                most, told[chosen] = gain, echoes
    return told


def _loudest(explanation: Explanation, pings: IntArray) -> _Heard:
    """Tell where, and how far off, the station with most of these pings reads first: what is loudest is read early."""
    soundings = explanation.soundings
    best = np.argmax(np.bincount(soundings.stations[pings]))
    here = pings[soundings.stations[pings] == best]
    first = here[np.argmin(soundings.readings[here])]
    reading = float(soundings.readings[first]) * explanation.hearing.scale
    return (float(soundings.x[first]), float(soundings.y[first])), reading


@compiled
def _best_echoes(
    few: Soundings, hearing: Hearing, known: _Known, heard: _Heard, bare: FloatArray, noise: float
) -> tuple[float, FloatArray]:
    """Find the unheard wall on a known one whose echoes explain most: by how much, and the levels."""
    corners, gains = _corners(few, hearing, known, heard, bare, _COARSE * noise)
    most, echoes = 0.0, np.full(len(bare), UNHEARD)
    for number in np.argsort(-gains)[:_BEST]:
        if gains[number] > 0.0:
            corner = Corner(corners[number, 0], corners[number, 1], corners[number, 2])
            gain, levels = _refined(few, hearing, known[0], corner, bare, noise)
            if gain > most:
                most, echoes = gain, levels
    return most, echoes


@compiled
def _corners(
    few: Soundings, hearing: Hearing, known: _Known, heard: _Heard, bare: FloatArray, noise: float
) -> tuple[FloatArray, FloatArray]:
    """List corners that return sound as far as it was heard, and what each explains.

    A corner narrower than a right angle is heard from nearer than it is, by the sine of its opening.
    """
    (wall, extent), (place, reading) = known, heard
    x, y = math.cos(wall[1]), math.sin(wall[1])
    depth, foot = wall[2] - x * place[0] - y * place[1], x * place[1] - y * place[0]
    corners, gains = np.zeros((2 * len(_OPENINGS), 3)), np.zeros(2 * len(_OPENINGS))
    for number in range(len(gains) if depth > 0.0 else 0):
        opening, side = _OPENINGS[number // 2], 2.0 * (number % 2) - 1.0
        away = reading / math.sin(min(opening, 0.5 * math.pi))
        vertex = foot + side * math.sqrt(max(away * away - depth * depth, 0.0))
        beyond = side * (vertex - extent[number % 2])
        if away > depth and -_BEFORE < beyond < _BEYOND:
            corners[number] = vertex, opening, side
            levels = _echoes(few, hearing, wall, Corner(vertex, opening, side), noise)
            gains[number] = _gain(few, levels, bare)
    return corners, gains


@compiled
def _refined(
    few: Soundings, hearing: Hearing, wall: FloatArray, corner: Corner, bare: FloatArray, noise: float
) -> tuple[float, FloatArray]:
    """Move a corner to where it explains most, by ever smaller steps, and tell how much and the levels."""
    levels = _echoes(few, hearing, wall, corner, noise)
    gain, along, turn = _gain(few, levels, bare), _ALONG, _TURN
    for _ in range(_HALVINGS):
        middle = corner
        for cell in range(9):
            place, opening = middle.place + (cell // 3 - 1) * along, middle.opening + (cell % 3 - 1) * turn
            tried = Corner(place, opening, middle.side)
            told = _echoes(few, hearing, wall, tried, noise)
            more = _gain(few, told, bare)
            if more > gain:
                corner, gain, levels = tried, more, told
        along, turn = 0.5 * along, 0.5 * turn
    return gain, levels


@compiled
def _gain(few: Soundings, levels: FloatArray, bare: FloatArray) -> float:
    gain = 0.0
    for ping in range(len(levels)):
        gain += few.weights[ping] * max(levels[ping] - bare[ping], 0.0)
    return gain


@compiled
def _echoes(few: Soundings, hearing: Hearing, wall: FloatArray, corner: Corner, noise: float) -> FloatArray:
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
