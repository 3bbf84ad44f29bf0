"""Past: what stations said of a feature whose pings are no longer at hand."""

from dataclasses import dataclass, field

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model import ClassProbabilities

__all__ = ["NO_PAST", "Past"]


def _undecided() -> ClassProbabilities:
    return ClassProbabilities(wall=1 / 3, corner=1 / 3, cylinder=1 / 3)


def _nowhere() -> FloatArray:
    return np.zeros(0)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Past:
    """What is kept of the stations that were let go.

    Parameters
    ----------
    number : int
        Tells the feature from all others; -1 if it has no past.
    total : float
        Gain of those stations [nats].
    best : float
        Gain of the best of them [nats].
    speaking : int
        How many spoke for it clearly.
    missing : int
        How many had a free view of it and did not.
    hidden : int
        How many of those that spoke for it would have heard it through a wall.
    passed : int
        How many pings of what explains more went through it, of a wall.
    pings : int
        How many pings heard it.
    extent : tuple of float
        Ends of what was heard of a wall along it [m].
    feet : ndarray, shape (k,)
        Where along a wall it sent sound back, in order [m].
    crossings : ndarray, shape (c,)
        Where sound of other features went through its line, in order [m].
    silences : ndarray, shape (d,)
        Where along a wall stations should have heard it and did not, in order [m].
    probabilities : ClassProbabilities, optional
        How sure its class was when it was heard best.
    certainty : float
        How well that was [nats].
    """

    number: int = -1
    total: float = 0.0
    best: float = 0.0
    speaking: int = 0
    missing: int = 0
    hidden: int = 0
    passed: int = 0
    pings: int = 0
    extent: tuple[float, float] = (np.inf, -np.inf)
    feet: FloatArray = field(default_factory=_nowhere)
    crossings: FloatArray = field(default_factory=_nowhere)
    silences: FloatArray = field(default_factory=_nowhere)
    probabilities: ClassProbabilities = field(default_factory=_undecided)
    certainty: float = -np.inf


# Of a feature that only stations at hand have heard.
NO_PAST = Past()
