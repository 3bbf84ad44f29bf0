"""Edges: where walls end because another one goes on around the corner, and how little is heard of them there."""

import math
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing, Kind, Ping, Shape, Sight, differentiate, excess_of, look, walk_of
from echoplan.arrays import FloatArray
from echoplan.compiled import compiled

__all__ = ["WallExtent", "diffracted", "diffracted_jacobian", "edges_of", "is_ended"]

_WALL = int(Kind.WALL)
# Walls that turn less cross too far away (sine).
_TURN = math.sin(math.radians(20))
# What was heard of walls may seem to reach past an edge, or end before it, by so much [m].
_PAST, _BEFORE = 0.1, 0.5
# Fresnel's parameter from which on an edge takes nothing away.
_CLEAR = -0.78
# At 4 m an edge takes something away from 7 cm before it on [m].
_ZONE = 0.1
# Step of a central difference [m].
_STEP = 1e-4

# Between which places a wall was heard, and where it ends [m].
WallExtent: TypeAlias = tuple[float, float, float, float]


@compiled
def edges_of(reflectors: FloatArray, extents: FloatArray) -> FloatArray:
    """Find where walls end.

    Two walls make an edge where they cross if each lies behind the other, both were heard up to there, and neither was
    heard beyond.

    Parameters
    ----------
    reflectors : ndarray, shape (f, 4)
        Kind and parameters of all features.
    extents : ndarray, shape (f, 2)
        Between which places each wall was heard [m].

    Returns
    -------
    ndarray, shape (f, 2, 6)
        Of the lower and the upper end of each: where it is [m], infinite where there is no edge; its derivatives by the
        normal angle and the offset of the wall, and of the other one that makes the edge; the number of that.
    """
    ends = np.zeros((len(reflectors), 2, 6))
    ends[:, 0, 0], ends[:, 1, 0], ends[:, :, 5] = -np.inf, np.inf, -1.0
    for one in range(len(reflectors)):
        for other in range(one + 1, len(reflectors)):
            if reflectors[one, 0] == _WALL and reflectors[other, 0] == _WALL:
                _meet(reflectors, extents, ends, one, other)
    return ends


@compiled
def is_ended(shape: Shape, place: Ping, reach: WallExtent) -> bool:
    """Tell whether a sensor stands so near to the end of a wall, or past it, that this may matter.

    Parameters
    ----------
    shape : Shape
        The feature.
    place : Ping
        Where the sensor is.
    reach : WallExtent
        How far the wall reaches.

    Returns
    -------
    bool
        False for what is no wall.
    """
    foot = shape[1] * place[1] - shape[2] * place[0]
    return bool(shape[0] == _WALL and max(reach[2] - foot, foot - reach[3]) > -_ZONE)


@compiled
def diffracted(sight: Sight, below: float, above: float, wavelength: float) -> Sight:
    """See a wall from before its end, or from past it: what a knife edge leaves (ITU-R P.526).

    Parameters
    ----------
    sight : Sight
        The wall as if it had no end.
    below, above : float
        How far the foot of the sensor lies past its lower and its upper end; negative before them [m].
    wavelength : float
        Of the carrier [m].

    Returns
    -------
    Sight
        The wall as it is: fainter near the end, and past it by the way over the end, from there.
    """
    depth, cosine, sine, distance, strength = sight
    over = max(below, above)
    passing = 2.0 * over / math.sqrt(depth * wavelength)
    if passing <= _CLEAR:
        return sight
    grazing = passing - 0.1
    strength -= 6.9 + 20.0 * math.log10(math.sqrt(grazing * grazing + 1.0) + grazing)
    if over <= 0.0:
        return depth, cosine, sine, distance, strength
    away = math.hypot(depth, over)
    aside, ahead = (over if below > above else -over) / away, depth / away
    return away, cosine * ahead + sine * aside, sine * ahead - cosine * aside, distance, strength


@compiled
def diffracted_jacobian(
    hearing: Hearing, shape: Shape, place: Ping, end: tuple[FloatArray, float], jacobian: tuple[FloatArray, FloatArray]
) -> int:
    """Differentiate the reading of a wall near its end; past it, as if the end were seen along the normal.

    Parameters
    ----------
    hearing : Hearing
        The sonar.
    shape : Shape
        The wall.
    place : Ping
        Where the sensor is and where it looks.
    end : tuple of ndarray, shape (2, 6), and float
        Its ends as ``edges_of`` tells, and how much fainter than all of it it is from there [dB].
    jacobian : tuple of ndarray, shapes (8,) and (2,)
        Filled with the derivatives as by ``differentiate``, and with those by angle and offset of the wall it meets.

    Returns
    -------
    int
        The number of that wall.
    """
    (ends, attenuation), (own, neighbours) = end, jacobian
    sight, foot = look(shape, place), shape[1] * place[1] - shape[2] * place[0]
    below, above = ends[0, 0] - foot, foot - ends[1, 0]
    lost = sight[4] - diffracted(sight, below, above, hearing.wavelength)[4]
    differentiate(hearing, shape, place, own, attenuation + lost)
    near = _read(hearing, diffracted(sight, below - _STEP, above - _STEP, hearing.wavelength), attenuation)
    far = _read(hearing, diffracted(sight, below + _STEP, above + _STEP, hearing.wavelength), attenuation)
    side, sign = (0, 1.0) if below > above else (1, -1.0)
    slope = sign * (far - near) / (2.0 * _STEP)
    # The foot of the sensor moves the other way, as the wall turns and as the sensor moves.
    own[0] += slope * (ends[side, 1] + shape[3] - sight[0])
    own[1] += slope * ends[side, 2]
    own[3] += slope * shape[2]
    own[4] -= slope * shape[1]
    neighbours[0], neighbours[1] = slope * ends[side, 3], slope * ends[side, 4]
    return int(ends[side, 5])


@compiled
def _read(hearing: Hearing, sight: Sight, attenuation: float) -> float:
    return sight[0] + walk_of(hearing, excess_of(hearing, sight) - attenuation)


@compiled
def _meet(reflectors: FloatArray, extents: FloatArray, ends: FloatArray, one: int, other: int) -> None:
    """End two walls where they make an edge, unless they end before."""
    turn = reflectors[other, 1] - reflectors[one, 1]
    across, ahead = math.sin(turn), math.cos(turn)
    if abs(across) < _TURN:
        return
    # Along each, as far as the other's offset less its own, turned, leaves over.
    place = (reflectors[other, 2] - reflectors[one, 2] * ahead) / across
    beyond = (reflectors[other, 2] * ahead - reflectors[one, 2]) / across
    # The part of a wall that lies behind the other begins at the crossing where its direction leads behind that.
    side = 0 if across > 0.0 else 1
    if _reaches(extents[one], side, place) and _reaches(extents[other], 1 - side, beyond):
        _end(ends[one], side, place, reflectors[one, 2], (ahead, across), other)
        _end(ends[other], 1 - side, beyond, reflectors[other, 2], (ahead, -across), one)


@compiled
def _reaches(extent: FloatArray, side: int, place: float) -> bool:
    """Whether what was heard of a wall ends about a place on its lower (0) or upper (1) side."""
    gap = extent[0] - place if side == 0 else place - extent[1]
    return bool(-_PAST < gap < _BEFORE)


@compiled
def _end(ends: FloatArray, side: int, place: float, offset: float, turn: tuple[float, float], neighbour: int) -> None:
    """Let a wall end where it meets a neighbour turned by an angle of this cosine and sine, unless it ends before."""
    if (place > ends[side, 0]) != (side == 0):
        return
    cosine, sine = turn
    turning = place * cosine / sine - offset
    ends[side, 0], ends[side, 5] = place, neighbour
    ends[side, 1], ends[side, 2], ends[side, 3], ends[side, 4] = turning, -cosine / sine, -turning, 1.0 / sine
