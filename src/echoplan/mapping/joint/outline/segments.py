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

__all__ = ["CELL", "End", "Segment", "SegmentSettings", "find_segments", "path_crossings"]

# Width of a cell [m].
CELL = 0.02
# Rounds in which segments are found, each with the views that those of the round before block.
_ROUNDS = 3
# Log-likelihood ratio of a wall where the robot drove [nats].
_NEVER = 50.0
# Length from which a stretch behind something interrupts a wall; what stands nearer before it is part of it [m].
_UNSEEN, _BEFORE = 0.1, 0.05
# No furniture that stands against a wall is deeper [m].
_DEEPEST = 1.0
# Walls within 12 degrees of each other are parallel (cosine).
_PARALLEL = math.cos(math.radians(12.0))
# Feet of single pings lie about that of their station: by less than the arm of a turret [m].
_ARM = 0.1
# Share of the probability of one source about which two must agree to be joined.
_AGREEMENT = 0.01
# Standard deviations across the 95 % interval of a normal distribution.
_WIDTH_OF_95 = 2.0 * 1.96
# Walls off a right angle by more than 5 degrees return no echo from their corner (cosine between the normals).
_OBLIQUE = math.sin(math.radians(5.0))
# Pings that detect a corner at least; distance of the corner from what was detected of the other wall at most [m].
_LEAST_PINGS, _AWAY = 5, 1.0
# Distance from a line up to which a corner lies on it [m].
_CORNER_REACH = 0.03


class SegmentSettings(BaseModel, frozen=True, extra="forbid"):
    """The model of a wall line."""

    ends_per_metre: float = Field(default=1 / 3, gt=0.0, description="Prior rate of ends along a wall line [1/m].")
    unrelated: float = Field(
        default=0.02,
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


class End(NamedTuple):
    """Where a wall may end along its line.

    Attributes
    ----------
    places : ndarray, shape (n,)
        Borders between cells, in order [m].
    chances : ndarray, shape (n,)
        Probability of each, up to a factor.
    """

    places: FloatArray
    chances: FloatArray

    @classmethod
    def normal(cls, place: float, sigma: float) -> "End":
        """Make one that is normally distributed."""
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
        return float(upper - lower) / _WIDTH_OF_95

    def reversed(self) -> "End":
        """Return the same end along the same line counted the other way."""
        return End(-self.places[::-1], self.chances[::-1])

    def joined(self, other: "End") -> "End":
        """Return where the end is if two independent sources say where; the better known one if they disagree."""
        fine, coarse = sorted((self, other), key=lambda each: each.sigma)
        chances = fine.chances * np.interp(fine.places, coarse.places, coarse.chances, left=0.0, right=0.0)
        return End(fine.places, chances) if chances.sum() > _AGREEMENT * coarse.chances.max() else fine


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
    ends : tuple of End or None
        Where the lower and the upper end may be; None where nothing says that the wall ends there.
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
    ends: tuple[End | None, End | None]
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
            corners = _corners_on(number, wall, before, echoes)
            chain = smoothed(*line.potentials(path_xy, corners))
            segments += line.segments(chain, corners, others)
    return segments


class _CornerOnLine(NamedTuple):
    """A corner that was detected on a line: where [m], and which end of the wall may lie there (0 lower, 1 upper)."""

    place: float
    sides: tuple[int, ...]


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
        self, path_xy: FloatArray, corners: Sequence[_CornerOnLine]
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return the log potentials of the chain: cells, ends and no ends.

        """
        settings, past = self.settings, self.wall.past
        cells = np.bincount(self.cells_of(self.feet), self.ratios[:, 0, 0], minlength=self.count)
        cells += math.log(settings.unrelated) * np.bincount(self.cells_of(past.crossings), minlength=self.count)
        cells += np.bincount(self.cells_of(_beside(corners)), minlength=self.count) * -math.log(settings.unrelated)
        cells[self.cells_of(path_crossings(self.wall.line, path_xy))] = -_NEVER
        rate = settings.ends_per_metre * CELL
        ends, stay = np.full((2, self.count - 1), math.log(rate)), np.full((2, self.count - 1), math.log1p(-rate))
        for place, sides in corners:
            border = int(np.abs(self.borders - place).argmin())
            ends[list(sides), border] = math.log(settings.corner_end / len(sides))
            stay[list(sides), border] = math.log1p(-settings.corner_end)
        for foot, (lower, upper) in zip(self.feet, self.ratios, strict=True):
            for side, ratios, over in ((0, lower, self.borders - foot), (1, upper, foot - self.borders)):
                # The cell of the foot counts as whole wall wherever it is wall; what an end near it changes is added.
                inside = np.where(over <= 0.0, ratios[0], 0.0)
                ends[side] += np.interp(over, OFFSETS, ratios) - inside
        return cells, ends, stay

    def segments(
        self, chain: Chain, corners: Sequence[_CornerOnLine], others: Sequence[Segment]
    ) -> list[Segment]:
        """Take the runs of cells that are more likely wall than not, as far as stations detected them."""
        is_wall = np.concatenate([[False], chain.wall > 0.5, [False]])
        runs = np.flatnonzero(np.diff(is_wall.astype(int))).reshape(-1, 2)
        support = np.sort(np.concatenate([self.feet[self.ratios[:, 0, 0] > 0.0], _beside(corners)]))
        owners = self.cells_of(support)
        pieces = [
            each
            for first, last in runs
            for each in self._observed(support[(owners >= first) & (owners < last)], others)
        ]
        return [
            self._segment(chain, piece, before, after)
            for piece, before, after in zip(pieces, [None, *pieces], [*pieces[1:], None], strict=False)
        ]

    def _observed(self, support: FloatArray, others: Sequence[Segment]) -> list[FloatArray]:
        """Split the places that support a run where something stands before the line and nobody listened behind it."""
        if not len(support):
            return []
        fronts = _fronts(self.wall.line, others)
        cuts = [
            index + 1
            for index, (low, high) in enumerate(pairwise(support))
            if any(min(high, last) - max(low, first) > _UNSEEN for first, last in fronts)
        ]
        return np.split(support, cuts)

    def _segment(self, chain: Chain, piece: FloatArray, before: FloatArray | None, after: FloatArray | None) -> Segment:
        """Make a segment of the stations that support it: each end where it probably is, if stations say so."""
        feet = self.wall.past.feet
        near = feet[(feet >= piece[0] - _ARM) & (feet <= piece[-1] + _ARM)]
        first, last = min(float(piece[0]), near.min(initial=math.inf)), max(float(piece[-1]), near.max(initial=-math.inf))
        # A station may detect a wall from a little past its end.
        low = self._end(chain.ends[0], -math.inf if before is None else before[-1], piece[0] + OFFSETS[-1])
        high = self._end(chain.ends[1], piece[-1] - OFFSETS[-1], math.inf if after is None else after[0])
        if low is not None and before is None and low.sigma > self.settings.max_end_sigma:
            low = None
        if high is not None and after is None and high.sigma > self.settings.max_end_sigma:
            high = None
        return Segment(
            owner=self.owner,
            wall=self.wall,
            low=first if low is None else low.place,
            high=last if high is None else high.place,
            ends=(low, high),
            pings=round(self.wall.past.pings * len(near) / max(len(feet), 1)),
            start=self.start,
            chances=chain.wall,
        )

    def _end(self, ends: FloatArray, low: float, high: float) -> End | None:
        """Return the end of a wall between two places; None if there may be none."""
        within = (self.borders > low) & (self.borders < high)
        return End(self.borders[within], ends[within]) if ends[within].sum() > self.settings.certain else None


def _points(line: FloatArray, places: FloatArray) -> FloatArray:
    """Points at places along a line [m], shape (n, 2)."""
    points: FloatArray = line[1] * directions(line[0]) + places[:, None] * directions(line[0] + math.pi / 2)
    return points


def _beside(corners: Sequence[_CornerOnLine]) -> FloatArray:
    """Places that corners of two known walls show to be wall: a cell before them [m]."""
    known = [(each.place, each.sides[0]) for each in corners if len(each.sides) == 1]
    return np.array([place + (CELL if side == 0 else -CELL) for place, side in known])


def _fronts(line: FloatArray, others: Sequence[Segment]) -> list[tuple[float, float]]:
    """Where along a line a wall of something stands before it, and nobody detected the back of that."""
    normal, along = directions(line[0]), directions(line[0] + math.pi / 2)
    fronts, backs = [], []
    for other in others:
        depth = line[1] - float(other.middle_xy @ normal)
        first, last = sorted((float(other.point(each) @ along) for each in (other.low, other.high)))
        turn = math.cos(other.wall.line[0] - line[0])
        if _BEFORE < depth < _DEEPEST and abs(turn) > _PARALLEL:
            (fronts if turn > 0.0 else backs).append((depth, first, last))
    return [
        (first, last)
        for depth, first, last in fronts
        if not any(behind < depth and low < last and first < high for behind, low, high in backs)
    ]


def path_crossings(line: FloatArray, path_xy: FloatArray) -> FloatArray:
    """Places along a line where a path crosses it [m]."""
    depths, places = line[1] - path_xy @ directions(line[0]), path_xy @ directions(line[0] + math.pi / 2)
    crossed = depths[:-1] * depths[1:] < 0.0
    before, after = depths[:-1][crossed], depths[1:][crossed]
    crossings: FloatArray = places[:-1][crossed] + np.diff(places)[crossed] * before / (before - after)
    return crossings


def _corners_on(number: int, wall: Hypothesis, segments: Sequence[Segment], echoes: Echoes) -> list[_CornerOnLine]:
    """Find the corners that were detected on a line: with other walls that abut on it, and with nothing known."""
    along, corners = directions(wall.line[0] + math.pi / 2), []
    for other in segments:
        if other.owner == number or abs(math.cos(wall.line[0] - other.wall.line[0])) > _OBLIQUE:
            continue
        point, echo = intersections(wall.line, other.wall.line), echoes.between(number, other.owner)
        is_detected = echo.is_believed and echo.pings >= _LEAST_PINGS
        if not is_detected or other.extension(point) > _AWAY or other.is_open_toward(point):
            continue
        # The wall lies before the other one: if its normal looks up the line, this is the upper end.
        ahead = float(directions(other.wall.line[0]) @ along)
        corners.append(_CornerOnLine(float(point @ along), (1 if ahead > 0.0 else 0,)))
    on_line = np.abs(echoes.corners_xy @ directions(wall.line[0]) - wall.line[1]) < _CORNER_REACH
    alone = [place for place in echoes.corners_xy[on_line] @ along if not _is_near(place, corners)]
    return [*corners, *(_CornerOnLine(float(place), (0, 1)) for place in alone)]


def _is_near(place: float, corners: Sequence[_CornerOnLine]) -> bool:
    return any(abs(place - each.place) < 2.0 * _CORNER_REACH for each in corners)
