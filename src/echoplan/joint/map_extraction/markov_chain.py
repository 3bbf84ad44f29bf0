"""A Markov chain along a wall line: whether each cell is wall, and where the wall ends.

A cell outside of walls knows how far it is from the nearest end, as a station whose foot lies there detects that end
by diffraction, and no other: before this end, past it, or too far from any. Forward-backward smoothing (L. R. Rabiner,
"A tutorial on hidden Markov models", Proc. IEEE 77 (1989) 257) with transitions that depend on the place.
"""

from functools import cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled

__all__ = ["Chain", "smoothed"]

# States of a cell: far from any end, and wall. The others follow: 1 to d cells past an end, then 1 to d before one.
_FAR, _WALL, _PAST = 0, 1, 2
# Kinds of transitions: outside of walls, inside, into a wall (its lower end), out of it (its upper end).
_OUTSIDE, _INSIDE, _LOWER, _UPPER = range(4)
# Least log weight of a state or a transition [nats]: the product of two is still far above the smallest double.
_LEAST = -230.0


class Chain(NamedTuple):
    """Marginal probabilities along a line of n cells."""

    # Probability that each cell is wall, shape (n,).
    wall: FloatArray
    # Probability that a wall begins (row 0, its lower end) or stops (row 1, its upper end) at each border between two
    # cells, shape (2, n - 1).
    ends: FloatArray


def smoothed(cells: FloatArray, near: FloatArray, ends: FloatArray, stay: FloatArray) -> Chain:
    """Return the marginal probabilities of a line of n cells.

    ``cells`` are log-likelihood ratios of wall against no wall, shape (n,); ``near`` those of no wall with the nearest
    end 1 to d cells away, the upper end of a wall before the cell (0) or the lower end of one after it (1), against no
    wall at all, shape (n, 2, d). ``ends`` are log potentials of a lower and of an upper end at each border, ``stay`` of
    no end outside (0) and inside (1) of walls, both of shape (2, n - 1) [nats].
    """
    states = np.column_stack([np.zeros(len(cells)), cells, near.reshape(len(cells), -1)])
    borders = np.concatenate([stay, ends])
    # What is common to all states does not count, so no weight overflows, and none is zero.
    by_state = np.exp(np.maximum(states - states.max(axis=1, keepdims=True), _LEAST))
    by_border = np.exp(np.maximum(borders - borders.max(axis=0), _LEAST))
    return Chain(*_marginals(by_state, by_border, _moves(near.shape[2]), near.shape[2]))


@cache
def _moves(reach: int) -> IntArray:
    """Return the transitions of the states: from, to, kind, shape (m, 3). A gap of each width has one sequence."""
    past, before = np.arange(_PAST, _PAST + reach), np.arange(_PAST + reach, _PAST + 2 * reach)
    moves = [(_WALL, _WALL, _INSIDE), (_WALL, past[0], _UPPER), (past[0], _WALL, _LOWER), (before[0], _WALL, _LOWER)]
    outside = [(_FAR, _FAR), (past[-1], _FAR), (_FAR, before[-1])]
    outside += [*pairwise(past), *pairwise(before[::-1])]
    # In the middle of a gap the nearest end changes from the one before to the one after.
    outside += [*zip(past, before, strict=True), *zip(past[1:], before[:-1], strict=True)]
    return np.array([*moves, *((*each, _OUTSIDE) for each in outside)])


@compiled
def _marginals(states: FloatArray, borders: FloatArray, moves: IntArray, reach: int) -> tuple[FloatArray, FloatArray]:
    """Return the marginal probabilities of walls and ends from the weights of states, shape (n, s), and transitions."""
    count, before = len(states), _PAST + reach
    forward, wall, ends = np.zeros(states.shape), np.zeros(count), np.zeros((2, count - 1))
    # There is no wall before the line, and none after it.
    forward[0] = states[0]
    forward[0, _PAST:before] = 0.0
    for cell in range(1, count):
        for source, target, kind in moves:
            forward[cell, target] += forward[cell - 1, source] * borders[kind, cell - 1]
        forward[cell] *= states[cell]
        forward[cell] /= forward[cell].sum()
    backward = np.ones(states.shape[1])
    backward[before:] = 0.0
    wall[-1] = forward[-1, _WALL] / (forward[-1] * backward).sum()
    for cell in range(count - 2, -1, -1):
        following = backward * states[cell + 1]
        backward = np.zeros(len(following))
        for source, target, kind in moves:
            backward[source] += following[target] * borders[kind, cell]
        total = (forward[cell] * backward).sum()
        wall[cell] = forward[cell, _WALL] * backward[_WALL] / total
        outside = forward[cell, _PAST] + forward[cell, before]
        ends[0, cell] = outside * borders[_LOWER, cell] * following[_WALL] / total
        ends[1, cell] = forward[cell, _WALL] * borders[_UPPER, cell] * following[_PAST] / total
        backward /= backward.sum()
    return wall, ends
