"""A Markov chain along a wall line: whether each cell is wall, and where the wall ends.

A cell outside of walls has a state for its distance from the nearest end, because a station there detects this end by
diffraction, and no other. Forward-backward smoothing (L. R. Rabiner, "A tutorial on hidden Markov models", Proc. IEEE
77 (1989) 257) with transitions that depend on the place: the log potentials of ends hold the prior and the evidence.
"""

from typing import NamedTuple

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.compiled import compiled

__all__ = ["Chain", "smoothed"]

# States of a cell: far from any end, and wall. The others follow: 1 to d cells past an end, then 1 to d before one.
_FAR, _WALL, _PAST = 0, 1, 2


class Chain(NamedTuple):
    """Marginal probabilities along a line of n cells."""

    # Probability that each cell is wall, shape (n,).
    wall: FloatArray
    # Probability that a wall begins (row 0, its lower end) or stops (row 1, its upper end) at each border between two
    # cells, shape (2, n - 1).
    ends: FloatArray


def smoothed(cells: FloatArray, near: FloatArray, ends: FloatArray, stay: FloatArray) -> Chain:
    """Return the marginal probabilities of a line of n cells.

    ``cells`` are log-likelihood ratios of wall against no wall, shape (n,). ``near`` are those of no wall with the
    nearest end 1 to d cells away against no end within d cells, shape (n, 2, d): first the upper end before the cell,
    then the lower end after it. ``ends`` are log potentials of a lower and of an upper end at each border, ``stay`` of
    no end outside (0) and inside (1) of walls, both of shape (2, n - 1) [nats].
    """
    states = np.column_stack([np.zeros(len(cells)), cells, near.reshape(len(cells), -1)])
    forward, backward = _messages(states, ends, stay)
    before = _PAST + near.shape[2]
    total = np.logaddexp.reduce(forward[-1] + backward[-1])
    rising = np.logaddexp(forward[:-1, _PAST], forward[:-1, before]) + ends[0] + cells[1:] + backward[1:, _WALL]
    falling = forward[:-1, _WALL] + ends[1] + states[1:, _PAST] + backward[1:, _PAST]
    return Chain(
        wall=np.exp(forward[:, _WALL] + backward[:, _WALL] - total), ends=np.exp(np.stack([rising, falling]) - total)
    )


@compiled
def _messages(states: FloatArray, ends: FloatArray, stay: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the log messages from both sides of a line to each cell, shape (n, s).

    From the middle of a gap on, the nearest end is the one after it, so that a gap of each width has one sequence.
    """
    count, reach = len(states), (states.shape[1] - _PAST) // 2
    before, last = _PAST + reach, states.shape[1] - 1
    forward, backward = np.full(states.shape, -np.inf), np.full(states.shape, -np.inf)
    # There is no wall before the line, and none after it.
    forward[0, :_PAST], forward[0, before:] = states[0, :_PAST], states[0, before:]
    backward[-1, :before] = 0.0
    for cell in range(1, count):
        known, found, (outside, inside) = forward[cell - 1], forward[cell], stay[:, cell - 1]
        into = np.logaddexp(known[_PAST], known[before]) + ends[0, cell - 1]
        found[_FAR] = np.logaddexp(known[_FAR], known[before - 1]) + outside
        found[_WALL] = np.logaddexp(known[_WALL] + inside, into)
        found[_PAST] = known[_WALL] + ends[1, cell - 1]
        for state in range(_PAST, before - 1):
            found[state + 1] = known[state] + outside
            middle = np.logaddexp(known[state], known[state + 1])
            found[state + reach] = np.logaddexp(middle, known[state + reach + 1]) + outside
        found[last] = np.logaddexp(known[before - 1], known[_FAR]) + outside
        found += states[cell]
    for cell in range(count - 2, -1, -1):
        known, found, (outside, inside) = backward[cell + 1] + states[cell + 1], backward[cell], stay[:, cell]
        into = known[_WALL] + ends[0, cell]
        found[_FAR] = np.logaddexp(known[_FAR], known[last]) + outside
        found[_WALL] = np.logaddexp(known[_WALL] + inside, known[_PAST] + ends[1, cell])
        for state in range(_PAST, before):
            farther = known[state + 1] if state + 1 < before else known[_FAR]
            found[state] = np.logaddexp(farther, known[state + reach]) + outside
            if state > _PAST:
                found[state] = np.logaddexp(found[state], known[state + reach - 1] + outside)
                found[state + reach] = known[state + reach - 1] + outside
        found[_PAST], found[before] = np.logaddexp(found[_PAST], into), into
    return forward, backward
