"""A two-state Markov chain along a wall line: is each cell wall or not, and where does the wall end.

Forward-backward smoothing (L. R. Rabiner, "A tutorial on hidden Markov models", Proc. IEEE 77 (1989) 257) with
transitions that depend on the place: the log potentials of ends hold the prior and what stations say of an end there.
"""

from typing import NamedTuple

import numpy as np

from echoplan.arrays import FloatArray

__all__ = ["Chain", "smoothed"]


class Chain(NamedTuple):
    """Marginal probabilities along a line of n cells.

    Attributes
    ----------
    wall : ndarray, shape (n,)
        Probability that each cell is wall.
    ends : ndarray, shape (2, n - 1)
        Probability that at each border between two cells a wall begins (0: its lower end) or stops (1: its upper end).
    """

    wall: FloatArray
    ends: FloatArray


def smoothed(cells: FloatArray, ends: FloatArray, stay: FloatArray) -> Chain:
    """Smooth a line.

    Parameters
    ----------
    cells : ndarray, shape (n,)
        Log-likelihood ratio of wall against no wall of each cell [nats].
    ends : ndarray, shape (2, n - 1)
        Log potential of a lower and of an upper end at each border [nats].
    stay : ndarray, shape (2, n - 1)
        Log potential of no end at each border, outside of walls (0) and inside (1) [nats].

    Returns
    -------
    Chain
        Marginals.
    """
    count = len(cells)
    # State 0 is no wall, 1 is wall; the potential of going from one to the other at each border.
    steps = np.array([[stay[0], ends[0]], [ends[1], stay[1]]])
    levels = np.stack([np.zeros(count), cells])
    forward, backward = np.zeros((2, count)), np.zeros((2, count))
    forward[:, 0] = levels[:, 0]
    for cell in range(1, count):
        forward[:, cell] = levels[:, cell] + np.logaddexp(*(forward[:, cell - 1, None] + steps[:, :, cell - 1]))
    for cell in range(count - 2, -1, -1):
        after = backward[:, cell + 1] + levels[:, cell + 1]
        backward[:, cell] = np.logaddexp(*(steps[:, :, cell] + after).T)
    total = np.logaddexp(*forward[:, -1])
    wall = np.exp(forward[1] + backward[1] - total)
    after = backward[:, 1:] + levels[:, 1:]
    lower = np.exp(forward[0, :-1] + steps[0, 1] + after[1] - total)
    upper = np.exp(forward[1, :-1] + steps[1, 0] + after[0] - total)
    return Chain(wall, np.stack([lower, upper]))
