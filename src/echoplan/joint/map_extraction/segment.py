"""A wall segment: a part of a line that is wall, and the distributions of its ends."""

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.model import HALF_OF_95

__all__ = ["CELL", "CERTAIN", "PARALLEL", "End", "Segment", "path_since"]

# Width of a cell of a line [m].
CELL = 0.02
# Probability from which a cell or an end is certain.
CERTAIN = 0.95
# Walls within 12 degrees of each other are parallel (cosine).
PARALLEL = math.cos(math.radians(12.0))
# Standard deviation below which an end is known [m].
_KNOWN = 0.2
# Overlap of two distributions, as share of the greatest possible one, below which they disagree.
_AGREEMENT = 0.01
# Margin at the end of a segment and at a corner within which cells do not count [m].
_AT_END = 0.03


class End(NamedTuple):
    """Distribution of the place of an end along a line."""

    # Borders between cells, in order [m], shape (n,).
    places: FloatArray
    # Probability of each border, up to a factor, shape (n,).
    chances: FloatArray

    @classmethod
    def normal(cls, place: float, sigma: float) -> "End":
        """Return a normal distribution with a mean and a standard deviation [m]."""
        deviations = np.linspace(-3.0, 3.0, 61)
        return cls(place + max(sigma, 1e-6) * deviations, np.exp(-0.5 * deviations**2))

    @property
    def interval(self) -> FloatArray:
        """Quantiles of 2.5, 50 and 97.5 % [m], shape (3,)."""
        half = 0.5 * (self.places[-1] - self.places[0]) / (len(self.places) - 1) if len(self.places) > 1 else 0.5 * CELL
        total = np.concatenate([[0.0], np.cumsum(self.chances)]) / self.chances.sum()
        bounds = np.concatenate([self.places[:1] - half, self.places + half])
        quantiles: FloatArray = np.interp([0.025, 0.5, 0.975], total, bounds)
        return quantiles

    @property
    def place(self) -> float:
        """Median [m]."""
        return float(self.interval[1])

    @property
    def sigma(self) -> float:
        """Half the width of the 95 % interval, divided by 1.96 [m]."""
        lower, _, upper = self.interval
        return float(upper - lower) / (2.0 * HALF_OF_95)

    @property
    def is_known(self) -> bool:
        """Whether the wall is drawn up to this end; otherwise it is drawn as far as it was detected."""
        return self.sigma < _KNOWN

    def reversed(self) -> "End":
        """Return the end along the line in the opposite direction."""
        return End(-self.places[::-1], self.chances[::-1])

    def centred(self, place: float) -> "End":
        """Return the same distribution about another median [m]."""
        return End(self.places + (place - self.place), self.chances)

    def joined(self, other: "End") -> "End":
        """Return the product of two independent distributions, or the narrower one if they disagree."""
        fine, coarse = sorted((self, other), key=lambda each: each.sigma)
        chances = fine.chances * np.interp(fine.places, coarse.places, coarse.chances, left=0.0, right=0.0)
        agrees = chances.sum() > _AGREEMENT * fine.chances.sum() * coarse.chances.max()
        return End(fine.places, chances) if agrees else fine


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Segment:
    """A part of a line that is wall."""

    # Index of the landmark.
    owner: int
    wall: Hypothesis
    # Drawn ends along the line [m]: the medians of known ends, else as far as it was detected.
    low: float
    high: float
    # Distributions of the lower and the upper end; None without evidence for an end.
    ends: tuple[End | None, End | None]
    # Number of pings that it reflected.
    pings: int
    # Place of the lower border of the first cell of the line [m].
    start: float
    # Probability that each cell of the line is wall, shape (n,).
    chances: FloatArray

    @property
    def along(self) -> FloatArray:
        """Unit vector along the segment, shape (2,)."""
        angle = float(self.wall.line[0])
        return np.array([-math.sin(angle), math.cos(angle)])

    @property
    def middle_xy(self) -> FloatArray:
        """Midpoint [m], shape (2,)."""
        return self.point(0.5 * (self.low + self.high))

    def point(self, place: float) -> FloatArray:
        """Return the point at a place along the line [m], shape (2,)."""
        angle, offset = self.wall.line.tolist()
        cosine, sine = math.cos(angle), math.sin(angle)
        return np.array([offset * cosine - place * sine, offset * sine + place * cosine])

    def chances_between(self, low: float, high: float) -> FloatArray:
        """Return the wall probabilities of the cells whose middles lie between two places along the line [m]."""
        first, last = np.ceil((np.array([low, high]) - self.start) / CELL - 0.5).astype(int).clip(0, len(self.chances))
        return self.chances[first:last]

    def is_free(self, low: float, high: float) -> bool:
        """Return True if a cell between two places along the line [m] is certainly no wall."""
        return bool(self.chances_between(low, high).min(initial=1.0) < 1.0 - CERTAIN)

    def chance_up_to(self, point_xy: FloatArray) -> float:
        """Return the least wall probability between the nearer end and a point on the line."""
        place = float(point_xy @ self.along)
        end = self.high if self.is_upper(point_xy) else self.low
        return float(self.chances_between(min(end, place), max(end, place)).min(initial=1.0))

    def extension(self, point_xy: FloatArray) -> float:
        """Return how far the segment must grow to reach a point on its line [m]; negative if it contains it."""
        place = float(point_xy @ self.along)
        return max(self.low - place, place - self.high)

    def is_upper(self, point_xy: FloatArray) -> bool:
        """Return True if a point is nearer to the upper end than to the lower one."""
        return float(point_xy @ self.along) > 0.5 * (self.low + self.high)

    def is_open_toward(self, point_xy: FloatArray) -> bool:
        """Return True if a cell between the nearer end and a point beyond it is certainly no wall."""
        place = float(point_xy @ self.along)
        end = self.high if self.is_upper(point_xy) else self.low
        return self.is_free(min(end, place) + _AT_END, max(end, place) - _AT_END)


def path_since(wall: Hypothesis, path_xy: FloatArray) -> FloatArray:
    """Return the path of the robot since the beginning of the recording that first detected a wall, shape (q, 2) [m].

    The path before that does not count: the wall may have been put there later. ``path_xy``, shape (p, 2), is the whole
    path, with a row of NaN after each earlier recording.
    """
    starts = np.append(0, np.flatnonzero(np.isnan(path_xy[:, 0])) + 1)
    # The whole path is empty if the robot may have driven around walls.
    return path_xy[starts[min(wall.history.recording, len(starts) - 1)] :]
