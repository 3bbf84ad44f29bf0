"""TrackHistory: what stations said of a feature whose pings are no longer at hand."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.model import ClassProbabilities

__all__ = ["NO_HISTORY", "LineEvidence", "TrackHistory"]


def _undecided() -> ClassProbabilities:
    return ClassProbabilities(wall=1 / 3, corner=1 / 3, cylinder=1 / 3)


def _nowhere() -> FloatArray:
    return np.zeros(0)


class LineEvidence(NamedTuple):
    """What k stations say of where a line is wall.

    Attributes
    ----------
    feet : ndarray, shape (k,)
        Foot of the perpendicular from each station, along the line [m].
    centers_xy : ndarray, shape (k, 2)
        The stations [m].
    log_ratios : ndarray, shape (k, 2, m)
        Log-likelihood ratio of a wall whose lower or upper end lies at each of m offsets from the foot against no wall
        [nats].
    """

    feet: FloatArray
    centers_xy: FloatArray
    log_ratios: FloatArray

    def joined(self, other: "LineEvidence") -> "LineEvidence":
        """Add what other stations say."""
        return other if not len(self.feet) else LineEvidence(*map(np.concatenate, zip(self, other, strict=True)))

    def chosen(self, rows: BoolArray | IntArray) -> "LineEvidence":
        """Keep some of the stations."""
        return LineEvidence(*(each[rows] for each in self))


def _no_line_evidence() -> LineEvidence:
    return LineEvidence(np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2, 0)))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TrackHistory:
    """What is kept of the stations that were let go.

    Parameters
    ----------
    number : int
        Tells the feature from all others; -1 if it has no past.
    total : float
        Gain of those stations [nats].
    best : float
        Gain of the best of them [nats].
    supporting : int
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
        Where sound of other features crossed its line, one place a station and feature [m]: there it is no wall.
    line : LineEvidence
        What each station says of where the line of a wall is wall.
    probabilities : ClassProbabilities, optional
        How sure its class was when it was heard best.
    certainty : float
        How well that was [nats].
    """

    number: int = -1
    total: float = 0.0
    best: float = 0.0
    supporting: int = 0
    missing: int = 0
    hidden: int = 0
    passed: int = 0
    pings: int = 0
    extent: tuple[float, float] = (np.inf, -np.inf)
    feet: FloatArray = field(default_factory=_nowhere)
    crossings: FloatArray = field(default_factory=_nowhere)
    line: LineEvidence = field(default_factory=_no_line_evidence)
    probabilities: ClassProbabilities = field(default_factory=_undecided)
    certainty: float = -np.inf


# Of a feature that only stations at hand have heard.
NO_HISTORY = TrackHistory()
