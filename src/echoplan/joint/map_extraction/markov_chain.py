"""A two-state Markov chain along a wall line: whether each cell is wall, and where the wall ends.

Forward-backward smoothing (L. R. Rabiner, "A tutorial on hidden Markov models", Proc. IEEE 77 (1989) 257) with
transitions that depend on the place: the log potentials of ends hold the prior and the evidence of stations for an end.
"""

from typing import NamedTuple

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.compiled import compiled

__all__ = ["Chain", "smoothed"]


class Chain(NamedTuple):
    """Marginal probabilities along a line of n cells."""

    # Probability that each cell is wall, shape (n,).
    wall: FloatArray
    # Probability that a wall begins (row 0, its lower end) or stops (row 1, its upper end) at each border between two
    # cells, shape (2, n - 1).
    ends: FloatArray


def smoothed(cells: FloatArray, ends: FloatArray, stay: FloatArray) -> Chain:
    """Return the marginal probabilities of a line of n cells.

    ``cells`` are log-likelihood ratios of wall against no wall, shape (n,). ``ends`` are log potentials of a lower and
    of an upper end at each border, ``stay`` of no end outside (0) and inside (1) of walls, both of shape (2, n - 1)
    [nats].
    """
    forward, backward = _messages(cells, ends, stay)
    total = np.logaddexp(*forward[-1])
    rising = forward[:-1, 0] + ends[0] + cells[1:] + backward[1:, 1]
    falling = forward[:-1, 1] + ends[1] + backward[1:, 0]
    return Chain(wall=np.exp(forward[:, 1] + backward[:, 1] - total), ends=np.exp(np.stack([rising, falling]) - total))


@compiled
def _messages(cells: FloatArray, ends: FloatArray, stay: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the log messages from both sides of a line to each cell, shape (n, 2); state 0 is no wall, 1 is wall."""
    count = len(cells)
    forward, backward = np.zeros((count, 2)), np.zeros((count, 2))
    forward[0, 1] = cells[0]
    for cell in range(1, count):
        none, wall = forward[cell - 1, 0], forward[cell - 1, 1]
        forward[cell, 0] = np.logaddexp(none + stay[0, cell - 1], wall + ends[1, cell - 1])
        forward[cell, 1] = np.logaddexp(none + ends[0, cell - 1], wall + stay[1, cell - 1]) + cells[cell]
    for cell in range(count - 2, -1, -1):
        none, wall = backward[cell + 1, 0], backward[cell + 1, 1] + cells[cell + 1]
        backward[cell, 0] = np.logaddexp(stay[0, cell] + none, ends[0, cell] + wall)
        backward[cell, 1] = np.logaddexp(ends[1, cell] + none, stay[1, cell] + wall)
    return forward, backward
