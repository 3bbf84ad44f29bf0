"""Track history: what is kept of a landmark from marginalised stations."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.model import ClassProbabilities

__all__ = ["NO_HISTORY", "LineEvidence", "TrackHistory"]


def _nowhere() -> FloatArray:
    return np.zeros(0)


class LineEvidence(NamedTuple):
    """Log-likelihood ratios by which k stations locate the ends of a wall on its line."""

    # Foot of the perpendicular from each station, along the line [m], shape (k,).
    feet: FloatArray
    # Centers of the stations [m], shape (k, 2).
    centers_xy: FloatArray
    # Log-likelihood ratio of a wall whose lower or upper end lies at each of m offsets from the foot, relative to no
    # wall [nats], shape (k, 2, m).
    log_ratios: FloatArray

    def joined(self, other: "LineEvidence") -> "LineEvidence":
        """Append the rows of other stations."""
        return other if not len(self.feet) else LineEvidence(*map(np.concatenate, zip(self, other, strict=True)))

    def chosen(self, rows: BoolArray | IntArray) -> "LineEvidence":
        """Select the rows of some stations."""
        return LineEvidence(*(each[rows] for each in self))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TrackHistory:
    """Log-likelihood ratio and counts of a landmark from marginalised stations."""

    # Identifier of the landmark; -1 without a history.
    number: int = -1
    # Number of earlier recordings, none of which detected it.
    recording: int = 0
    # Log-likelihood ratio from these stations [nats].
    llr: float = 0.0
    # Greatest contribution of one of them [nats].
    best_llr: float = 0.0
    # Number of stations that clearly support it.
    supporting: int = 0
    # Number of stations with a free view that do not.
    missing: int = 0
    # Number of supporting stations that detected it mostly through a wall of a greater log-likelihood ratio.
    hidden: int = 0
    # Number of pings of landmarks of a greater log-likelihood ratio that passed through it, if it is a wall.
    passed: int = 0
    # Number of pings associated with it.
    pings: int = 0
    # Ends of a wall along its line, as far as detected [m].
    extent: tuple[float, float] = (np.inf, -np.inf)
    # Specular points along a wall [m], or as bearings from the centre of a round one; of a concave corner, the bearings
    # of stations that detected it [rad]. Sorted, shape (k,).
    feet: FloatArray = field(default_factory=_nowhere)
    # Points along the line of a wall where sound of other landmarks crossed it, one per station and landmark [m], shape
    # (c,): there is no wall.
    crossings: FloatArray = field(default_factory=_nowhere)
    # Log-likelihood ratios of where the line of a wall is wall, by station.
    line: LineEvidence = field(default_factory=lambda: LineEvidence(np.zeros(0), np.zeros((0, 2)), np.zeros((0, 2, 0))))
    # Class probabilities from the stations with the greatest log-likelihood ratio.
    probabilities: ClassProbabilities = field(
        default_factory=lambda: ClassProbabilities(wall=1 / 3, corner=1 / 3, cylinder=1 / 3)
    )
    # Log-likelihood ratio of those stations [nats].
    certainty: float = -np.inf


# Of a landmark that only stations of the window detected.
NO_HISTORY = TrackHistory()
