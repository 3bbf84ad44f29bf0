"""Edges: where walls end because another one goes on around the corner."""

import math

import numpy as np

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import FloatArray
from echoplan.compiled import compiled

__all__ = ["edges_of"]

_WALL = int(Kind.WALL)
# Walls that turn less cross too far away (sine).
_TURN = math.sin(math.radians(20))
# What was heard of walls may seem to reach past an edge, or end before it, by so much [m].
_PAST, _BEFORE = 0.1, 0.5


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
