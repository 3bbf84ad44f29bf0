"""Wall segments: which parts of a line are wall, as a two-state Markov chain along it.

Each cell of a line is wall or not.  A station says something of the cells near the foot of its perpendicular, and of an
end of the wall near that (``views``); where sound or the robot passed through, there is no wall; and between the cells
ends are rare.  Forward-backward smoothing (Rabiner 1989) gives the probability of each cell, and of an end at each
border between two cells.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.geometry import directions, intersections, is_blocked
from echoplan.mapping.joint.outline.chain import Chain, smoothed
from echoplan.mapping.joint.outline.views import OFFSETS
from echoplan.mapping.joint.search.echoes import Echoes

__all__ = ["CELL", "Segment", "SegmentSettings", "find_segments", "path_crossings"]

# Width of a cell [m].
CELL = 0.02
# Rounds in which segments are found, each with the views that those of the round before block.
_ROUNDS = 3
# Log-likelihood ratio of a wall where the robot drove [nats].
_NEVER = 50.0
# Length from which a stretch that nobody sees interrupts a wall [m].
_UNSEEN = 0.1
# Feet of single pings lie about that of their station: by less than the arm of a turret [m].
_ARM = 0.1
# Standard deviations across the 95 % interval of a normal distribution.
_WIDTH_OF_95 = 2.0 * 1.96
# Walls off a right angle by more than 5 degrees return no echo from their corner (cosine between the normals).
_OBLIQUE = math.sin(math.radians(5.0))
# Pings that detect a corner at least; distance of the corner from what was detected of the other wall at most [m].
_LEAST_PINGS, _AWAY = 5, 1.0


class SegmentSettings(BaseModel, frozen=True, extra="forbid"):
    """The model of a wall line."""

    ends_per_metre: float = Field(default=1 / 3, gt=0.0, description="Prior rate of ends along a wall line [1/m].")
    unrelated: float = Field(
        default=0.003,
        gt=0.0,
        lt=0.5,
        description="Probability that what a station says of a wall is about something else: it is blocked by something "
        "that is not in the map, or detects an echo that the model does not know.",
    )
    corner_end: float = Field(
        default=0.9, gt=0.0, lt=1.0, description="Probability that a wall ends at a corner detected on its line."
    )
    margin: float = Field(default=0.05, ge=0.0, description="Width beside an obstacle that blocks an echo, too [m].")
    max_end_sigma: float = Field(
        default=0.2,
        gt=0.0,
        description="Standard deviation up to which an end is where it probably is; an end that is known less well is "
        "where the wall was detected last [m].",
    )
    certain: float = Field(default=0.95, gt=0.5, lt=1.0, description="Probability from which a cell counts as known.")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Segment:
    """A part of a line that is wall.

    Parameters
    ----------
    owner : int
        Index of the feature.
    wall : Hypothesis
        The feature.
    low, high : float
        Ends along the line [m].
    sigmas : tuple of float
        Standard deviation of both: half the width of the 95 % interval, divided by 1.96 [m]; NaN where nothing says
        that the wall ends there.
    pings : int
        How many pings it reflected.
    start : float
        Place of the lower border of the first cell of the line [m].
    chances : ndarray, shape (n,)
        Probability that each cell of the line is wall.
    """

    owner: int
    wall: Hypothesis
    low: float
    high: float
    sigmas: tuple[float, float]
    pings: int
    start: float
    chances: FloatArray

    @property
    def along(self) -> FloatArray:
        """Unit vector along it, shape (2,)."""
        return directions(self.wall.line[0] + math.pi / 2)

    @property
    def middle_xy(self) -> FloatArray:
        """The point halfway [m], shape (2,)."""
        return self.point(0.5 * (self.low + self.high))

    def point(self, place: float) -> FloatArray:
        """Return the point at a place along the line [m], shape (2,)."""
        point: FloatArray = self.wall.line[1] * directions(self.wall.line[0]) + place * self.along
        return point

    def chances_between(self, low: float, high: float) -> FloatArray:
        """Return the probabilities of the cells whose middles lie between two places along the line [m]."""
        first, last = np.ceil((np.array([low, high]) - self.start) / CELL - 0.5).astype(int).clip(0, len(self.chances))
        return self.chances[first:last]

    def extension(self, point_xy: FloatArray) -> float:
        """Return how far it must be lengthened to reach a point on its line [m]; below 0 if the point lies on it."""
        place = float(point_xy @ self.along)
        return max(self.low - place, place - self.high)

    def is_upper(self, point_xy: FloatArray) -> bool:
        """Return True if a point is nearer to its upper end than to the lower one."""
        return float(point_xy @ self.along) > 0.5 * (self.low + self.high)

    def is_open_toward(self, point_xy: FloatArray, certain: float = 0.95) -> bool:
        """Return True if there is surely no wall somewhere between its end and a point beyond that."""
        place = float(point_xy @ self.along)
        end = self.high if self.is_upper(point_xy) else self.low
        between = self.chances_between(min(end, place) + 0.03, max(end, place) - 0.03)
        return bool(between.min(initial=1.0) < 1.0 - certain)


def find_segments(
    features: Sequence[Hypothesis], echoes: Echoes, path_xy: FloatArray, settings: SegmentSettings
) -> list[Segment]:
    """Find which parts of the lines of all walls are wall.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there, with a past that holds what stations say of each line.
    echoes : Echoes
        Detected corners.
    path_xy : ndarray, shape (p, 2)
        Way of the robot [m].
    settings : SegmentSettings
        The model.

    Returns
    -------
    list of Segment
        In the order of the features, and along the lines.
    """
    walls = {number: each for number, each in enumerate(features) if each.is_wall and len(each.past.line.feet)}
    discs = np.array([each.reflector[1:] for each in features if each.kind is Kind.CYLINDER]).reshape(-1, 3)
    segments: list[Segment] = []
    for _ in range(_ROUNDS):
        before, segments = segments, []
        for number, wall in walls.items():
            others = [each for each in before if each.owner != number]
            narrow, wide = _Obstacles.of(others), _Obstacles.of(others, discs, settings.margin)
            line = _Line.of(number, wall, (narrow, wide), settings)
            corners = _corner_ends(number, wall, before, echoes)
            chain = smoothed(*line.potentials(path_xy, corners))
            segments += line.segments(chain, narrow, path_xy)
    return segments


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Obstacles:
    """What blocks the view of a line: segments of other walls, and cylinders."""

    segments_xy: FloatArray
    discs: FloatArray

    @classmethod
    def of(cls, segments: Sequence[Segment], discs: FloatArray | None = None, margin: float = 0.0) -> "_Obstacles":
        """Take segments and cylinders for obstacles, each a margin wider than it is [m]."""
        ends = [[each.point(each.low - margin), each.point(each.high + margin)] for each in segments]
        wide = np.zeros((0, 3)) if discs is None else discs + (0.0, 0.0, margin)
        return cls(segments_xy=np.array(ends).reshape(-1, 2, 2), discs=wide)

    def block(self, origins_xy: FloatArray, targets_xy: FloatArray) -> BoolArray:
        """Return which targets cannot be seen from the origin beside each: up to 5 cm before them."""
        way = targets_xy - origins_xy
        length = np.hypot(*way.T)[:, None]
        ends = origins_xy + way * np.maximum(1.0 - 0.05 / np.maximum(length, 1e-9), 0.0)
        return is_blocked(origins_xy, ends, segments_xy=self.segments_xy, discs=self.discs)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Line:
    """The cells of one wall line, and the log-likelihood ratios of the stations that say something of it.

    Parameters
    ----------
    owner : int
        Index of the feature.
    wall : Hypothesis
        The feature.
    start : float
        Place of the lower border of the first cell [m].
    count : int
        Number of cells.
    feet : ndarray, shape (k,)
        Foot of the perpendicular from each station [m].
    ratios : ndarray, shape (k, 2, m)
        As in ``LineEvidence``, without those of stations whose view is blocked, and bounded.
    settings : SegmentSettings
        The model.
    """

    owner: int
    wall: Hypothesis
    start: float
    count: int
    feet: FloatArray
    ratios: FloatArray
    settings: SegmentSettings

    @classmethod
    def of(
        cls, owner: int, wall: Hypothesis, obstacles: tuple[_Obstacles, _Obstacles], settings: SegmentSettings
    ) -> "_Line":
        """Lay cells along a line, as far as stations say something of it.

        What another wall blocks is no echo of this one, whatever was detected; and where an obstacle, with a margin, is
        in the way, an echo may be missing.
        """
        feet, centers_xy, ratios = wall.past.line
        places = np.concatenate([feet, wall.past.crossings])
        start = float(places.min()) - OFFSETS[-1]
        hidden, disturbed = (each.block(centers_xy, _points(wall.line, feet))[:, None, None] for each in obstacles)
        detected = np.where(OFFSETS <= 0.0, np.maximum(ratios[:, :, :1], 0.0), 0.0)
        ratios = np.where(hidden, 0.0, np.where(disturbed, detected, ratios))
        # With a small probability e what a station says is about something else, as likely as its best explanation:
        # log of (1 - e) p / p_best + e never falls below log of e.
        best = np.maximum(ratios.max(axis=(1, 2), initial=0.0), 0.0)[:, None, None]
        related, unrelated = math.log1p(-settings.unrelated), math.log(settings.unrelated)
        ratios = np.logaddexp(related + ratios - best, unrelated) - np.logaddexp(related - best, unrelated)
        return cls(
            owner=owner,
            wall=wall,
            start=start,
            count=math.ceil((float(places.max()) + OFFSETS[-1] - start) / CELL) + 1,
            feet=feet,
            ratios=ratios,
            settings=settings,
        )

    @property
    def borders(self) -> FloatArray:
        """Places between two cells [m], shape (count - 1,)."""
        return self.start + CELL * np.arange(1, self.count)

    def cells_of(self, places: FloatArray) -> IntArray:
        """Return the cell of each place."""
        return np.floor((np.asarray(places) - self.start) / CELL).astype(np.int64).clip(0, self.count - 1)

    def potentials(
        self, path_xy: FloatArray, corners: Sequence[tuple[float, int]]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the log potentials of the chain: cells, ends and no ends.

        A corner on the line is a place and the end of the wall that lies there: 0 the lower one, 1 the upper one.
        """
        settings, past = self.settings, self.wall.past
        cells = np.bincount(self.cells_of(self.feet), self.ratios[:, 0, 0], minlength=self.count)
        cells += math.log(settings.unrelated) * np.bincount(self.cells_of(past.crossings), minlength=self.count)
        cells[self.cells_of(path_crossings(self.wall.line, path_xy))] = -_NEVER
        rate = settings.ends_per_metre * CELL
        ends, stay = np.full((2, self.count - 1), math.log(rate)), np.full((2, self.count - 1), math.log1p(-rate))
        for place, side in corners:
            border = int(np.abs(self.borders - place).argmin())
            ends[side, border], stay[side, border] = math.log(settings.corner_end), math.log1p(-settings.corner_end)
        for foot, (lower, upper) in zip(self.feet, self.ratios, strict=True):
            for side, ratios, over in ((0, lower, self.borders - foot), (1, upper, foot - self.borders)):
                # The cell of the foot counts as whole wall wherever it is wall; what an end near it changes is added.
                inside = np.where(over <= 0.0, ratios[0], 0.0)
                ends[side] += np.interp(over, OFFSETS, ratios) - inside
        return cells, ends, stay

    def segments(self, chain: Chain, obstacles: _Obstacles, path_xy: FloatArray) -> list[Segment]:
        """Take the runs of cells that are more likely wall than not, as far as stations detected them."""
        is_wall = np.concatenate([[False], chain.wall > 0.5, [False]])
        runs = np.flatnonzero(np.diff(is_wall.astype(int))).reshape(-1, 2)
        support = np.sort(self.feet[self.ratios[:, 0, 0] > 0.0])
        owners = self.cells_of(support)
        pieces = [
            each
            for first, last in runs
            for each in self._observed(support[(owners >= first) & (owners < last)], obstacles, path_xy)
        ]
        return [
            self._segment(chain, piece, before, after)
            for piece, before, after in zip(pieces, [None, *pieces], [*pieces[1:], None], strict=False)
        ]

    def _observed(self, support: FloatArray, obstacles: _Obstacles, path_xy: FloatArray) -> list[FloatArray]:
        """Split the feet of a run where no station sees the line between two of them."""
        if not len(support):
            return []
        cuts = [
            index + 1
            for index, (low, high) in enumerate(pairwise(support))
            if high - low > _UNSEEN and self._is_unseen(low, high, obstacles, path_xy)
        ]
        return np.split(support, cuts)

    def _is_unseen(self, low: float, high: float, obstacles: _Obstacles, path_xy: FloatArray) -> bool:
        """Return True if some stretch between two places is seen from nowhere."""
        places = np.arange(low + CELL, high, CELL)
        targets = _points(self.wall.line, places)
        before = path_xy[self.wall.line[1] - path_xy @ directions(self.wall.line[0]) > 0.0]
        origins = np.repeat(before, len(places), axis=0)
        seen = ~obstacles.block(origins, np.tile(targets, (len(before), 1))).reshape(len(before), -1)
        unseen = np.concatenate([[0], (~seen.any(axis=0)).astype(int), [0]])
        lengths = np.diff(np.flatnonzero(np.diff(unseen)).reshape(-1, 2), axis=1)
        return bool(CELL * lengths.max(initial=0) > _UNSEEN)

    def _segment(self, chain: Chain, piece: FloatArray, before: FloatArray | None, after: FloatArray | None) -> Segment:
        """Make a segment of the stations that support it: each end where it probably is, if stations say so."""
        feet = self.wall.past.feet
        near = feet[(feet >= piece[0] - _ARM) & (feet <= piece[-1] + _ARM)]
        first, last = min(float(piece[0]), near.min(initial=math.inf)), max(float(piece[-1]), near.max(initial=-math.inf))
        # A station may detect a wall from a little past its end.
        low = self._end(chain.ends[0], -math.inf if before is None else before[-1], piece[0] + OFFSETS[-1])
        high = self._end(chain.ends[1], piece[-1] - OFFSETS[-1], math.inf if after is None else after[0])
        is_low = low is not None and (before is not None or low.sigma < self.settings.max_end_sigma)
        is_high = high is not None and (after is not None or high.sigma < self.settings.max_end_sigma)
        return Segment(
            owner=self.owner,
            wall=self.wall,
            low=low.place if is_low else first,
            high=high.place if is_high else last,
            sigmas=(low.sigma if is_low else math.nan, high.sigma if is_high else math.nan),
            pings=round(self.wall.past.pings * len(near) / max(len(feet), 1)),
            start=self.start,
            chances=chain.wall,
        )

    def _end(self, ends: FloatArray, low: float, high: float) -> "_End | None":
        """Return the end of a wall between two places; None if there may be none."""
        borders = self.borders
        within = (borders > low) & (borders < high)
        chances, places = ends[within], borders[within]
        if chances.sum() < self.settings.certain:
            return None
        total = np.cumsum(chances) / chances.sum()
        lower, place, upper = np.interp([0.025, 0.5, 0.975], total, places + 0.5 * CELL)
        return _End(float(place), float(upper - lower) / _WIDTH_OF_95)


class _End(NamedTuple):
    """Where a wall ends along its line, in the median, and the width of the 95 % interval over 2 x 1.96 [m]."""

    place: float
    sigma: float


def _points(line: FloatArray, places: FloatArray) -> FloatArray:
    """Points at places along a line [m], shape (n, 2)."""
    points: FloatArray = line[1] * directions(line[0]) + places[:, None] * directions(line[0] + math.pi / 2)
    return points


def path_crossings(line: FloatArray, path_xy: FloatArray) -> FloatArray:
    """Places along a line where a path crosses it [m]."""
    depths, places = line[1] - path_xy @ directions(line[0]), path_xy @ directions(line[0] + math.pi / 2)
    crossed = depths[:-1] * depths[1:] < 0.0
    before, after = depths[:-1][crossed], depths[1:][crossed]
    crossings: FloatArray = places[:-1][crossed] + np.diff(places)[crossed] * before / (before - after)
    return crossings


def _corner_ends(
    number: int, wall: Hypothesis, segments: Sequence[Segment], echoes: Echoes
) -> list[tuple[float, int]]:
    """Where other walls abut on a line with a corner that was detected, and which end of the wall lies there."""
    along, ends = directions(wall.line[0] + math.pi / 2), []
    for other in segments:
        if other.owner == number or abs(math.cos(wall.line[0] - other.wall.line[0])) > _OBLIQUE:
            continue
        point, echo = intersections(wall.line, other.wall.line), echoes.between(number, other.owner)
        is_detected = echo.is_believed and echo.pings >= _LEAST_PINGS
        if not is_detected or other.extension(point) > _AWAY or other.is_open_toward(point):
            continue
        # The wall lies before the other one: if its normal looks down the line, this is the upper end.
        ahead = float(directions(other.wall.line[0]) @ along)
        ends.append((float(point @ along), 1 if ahead > 0.0 else 0))
    return ends
