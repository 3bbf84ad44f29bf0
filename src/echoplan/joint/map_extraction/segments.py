"""Wall segments: which parts of a line are wall, as a Markov chain along it.

Each cell of a line is wall or not. A station contributes to the cell at the foot of its perpendicular, depending on how
far this is from an end of the wall (``endpoint_views``). Where sound or the robot passed through there is no wall. Ends
are rare. Forward-backward smoothing (``markov_chain``) gives the probability of each cell and of an end at each border.
"""

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import path_crossings
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.map_extraction.bodies import Bodies
from echoplan.joint.map_extraction.endpoint_views import OFFSETS
from echoplan.joint.map_extraction.markov_chain import Chain, smoothed
from echoplan.joint.map_extraction.segment import CELL, CERTAIN, End, Segment, path_since
from echoplan.joint.map_extraction.surroundings import (
    CornerOnLine,
    Obstacles,
    before_corners,
    corners_on,
    fronts_of,
    is_across,
    is_copy,
    points_on,
)
from echoplan.joint.search.corner_echoes import Echoes
from echoplan.settings import Settings

__all__ = ["SegmentSettings", "find_segments"]

# Iterations: occlusion is computed from the segments of the previous one.
_ROUNDS = 3
# Log-likelihood ratio against wall where the robot crossed the line [nats].
_NEVER = 1e6
# Length from which a stretch hidden by an object interrupts a wall [m].
_UNSEEN = 0.1
# Weights of the borders about an end: the knife-edge model locates the end of a real wall to within one cell.
_BLUR = np.array([0.25, 0.5, 0.25])
# Greatest distance of the foot of a ping from that of its station: the arm of a turret is shorter [m].
_ARM = 0.1
# Distance from which cells are independent: at the default rate of ends their correlation is 2e-9 [m].
_APART = 30.0


class SegmentSettings(Settings):
    """Prior probabilities of the chain along a wall line."""

    ends_per_metre: float = Field(default=1 / 3, gt=0.0, description="Prior rate of ends along a wall line [1/m].")
    unmapped: float = Field(
        default=0.05,
        gt=0.0,
        lt=0.5,
        description="Probability that a station misses a wall because of something before it that is not in the map.",
    )
    false_echo: float = Field(
        default=0.005,
        gt=0.0,
        lt=0.5,
        description="Probability that what a station detects of a wall is an echo that the model does not know.",
    )
    # Probability that a wall ends at a corner detected on its line.
    corner_end: ClassVar[float] = 0.97
    driven: bool = Field(
        default=True,
        description="Whether the robot drove straight from station to station: then no wall crosses its path.",
    )
    # Width beside an obstacle that blocks an echo, too [m].
    margin: ClassVar[float] = 0.05


def find_segments(
    features: Sequence[Hypothesis], echoes: Echoes, path_xy: FloatArray, settings: SegmentSettings
) -> list[Segment]:
    """Return the segments of all walls, in the order of the landmarks and along the lines.

    Landmarks carry the line evidence of the stations in their track histories; ``path_xy`` is the path of the robot,
    shape (p, 2) [m]. The occlusion by segments depends on the result, so it is repeated a few times.
    """
    walls = {number: each for number, each in enumerate(features) if each.is_wall and len(each.history.line.feet)}
    discs = np.array([each.reflector[1:] for each in features if each.kind is Kind.CYLINDER]).reshape(-1, 3)
    segments: list[Segment] = []
    for _ in range(_ROUNDS):
        before, segments = segments, []
        bodies = Bodies.behind(before, path_xy)
        for number, wall in walls.items():
            others = [each for each in before if each.owner != number]
            narrow, wide = Obstacles.of(others), Obstacles.of(others, discs, settings.margin)
            corners = corners_on(number, wall, before, echoes)
            passed = _near(path_crossings(wall.line, path_since(wall, path_xy)), wall.history.line.feet)
            places = np.concatenate([passed, [each.place for each in corners]])
            line = _Line.of(
                number,
                wall,
                obstacles=(narrow, wide),
                bodies=bodies,
                passed=passed,
                places=places,
                settings=settings,
            )
            chain = smoothed(*line.potentials(corners))
            segments += line.segments(chain, corners, others)
    return _without_copies(segments)


def _near(places: FloatArray, feet: FloatArray) -> FloatArray:
    """Return the places along a line that are near enough to its feet to influence the result."""
    near: FloatArray = places[(places > feet.min() - _APART) & (places < feet.max() + _APART)]
    return near


def _without_copies(segments: Sequence[Segment]) -> list[Segment]:
    """Remove segments beside or across others with more pings: these are duplicates, or corners taken for a wall.

    A segment across another wall is kept if its landmark has other segments: then it is a real end of a wall.
    """
    kept: list[Segment] = []
    owners = Counter(each.owner for each in segments)
    for segment in sorted(segments, key=lambda each: each.pings, reverse=True):
        has_single_station = owners[segment.owner] == 1
        if not any(is_copy(segment, each) or (has_single_station and is_across(segment, each)) for each in kept):
            kept.append(segment)
    return [each for each in segments if each in kept]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Line:
    """Cells of one wall line, and the log-likelihood ratios of k stations."""

    # Index of the landmark.
    owner: int
    wall: Hypothesis
    # Place of the lower border of the first cell [m].
    start: float
    # Number of cells.
    count: int
    # Foot of the perpendicular from each station along the line [m], shape (k,).
    feet: FloatArray
    # Log-likelihood ratios as in ``LineEvidence``, bounded, and zero for stations whose view is blocked [nats], shape
    # (k, 2, m).
    ratios: FloatArray
    # Greatest log-likelihood ratio of each station for a wall, not bounded [nats], shape (k,).
    best: FloatArray
    # Places where the robot crossed the line [m], shape (p,).
    passed: FloatArray
    settings: SegmentSettings

    @classmethod
    def of(
        cls,
        owner: int,
        wall: Hypothesis,
        *,
        obstacles: tuple[Obstacles, Obstacles],
        bodies: Bodies,
        passed: FloatArray,
        places: FloatArray,
        settings: SegmentSettings,
    ) -> "_Line":
        """Divide a line into cells over all feet, crossings and given places, and bound the ratios of the stations.

        Behind another wall, a station contributes nothing. Near an obstacle, within its margin, non-detections do not
        count, and behind the front of a body they count less.
        """
        feet, centers_xy, ratios = wall.history.line
        places = np.concatenate([feet, _near(wall.history.crossings, feet), places])
        start = float(places.min()) - OFFSETS[-1]
        hidden, disturbed = (each.block(centers_xy, points_on(wall.line, feet))[:, None, None] for each in obstacles)
        detected = np.where(OFFSETS <= 0.0, np.maximum(ratios[:, :, :1], 0.0), 0.0)
        ratios = np.where(hidden, 0.0, np.where(disturbed, detected, ratios))
        # With a small probability e the pings of a station are unrelated to the wall, and then as likely as under its
        # best explanation. So log((1 - e) p / p_best + e) never falls below log(e).
        best = np.maximum(ratios.max(axis=(1, 2), initial=0.0), 0.0)[:, None, None]
        seen = (1.0 - settings.unmapped) * (1.0 - bodies.hide(centers_xy, owner, wall.line, feet))
        wrong = np.where(best > 0.0, settings.false_echo, 1.0 - np.maximum(seen, 1e-9)[:, None, None])
        related, unrelated = np.log1p(-wrong), np.log(wrong)
        ratios = np.logaddexp(related + ratios - best, unrelated) - np.logaddexp(related - best, unrelated)
        return cls(
            owner=owner,
            wall=wall,
            start=start,
            count=math.ceil((float(places.max()) + OFFSETS[-1] - start) / CELL) + 1,
            feet=feet,
            ratios=ratios,
            best=best[:, 0, 0],
            passed=passed,
            settings=settings,
        )

    @property
    def borders(self) -> FloatArray:
        """Places between two cells [m], shape (count - 1,)."""
        borders: FloatArray = self.start + CELL * np.arange(1, self.count, dtype=np.float64)
        return borders

    def cells_of(self, places: FloatArray) -> IntArray:
        """Return the cell of each place [m]."""
        cells: IntArray = np.floor((places - self.start) / CELL).astype(np.int64).clip(0, self.count - 1)
        return cells

    def potentials(self, corners: Sequence[CornerOnLine]) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the log potentials of the chain: cells, cells near an end, ends and no ends [nats]."""
        settings, history = self.settings, self.wall.history
        crossings = _near(history.crossings, self.feet)
        places = np.concatenate([self.feet, crossings])
        passing = np.full(len(crossings), math.log(settings.false_echo))
        ratios = np.concatenate([self.ratios[:, 0, 0], passing])
        cells: FloatArray = np.bincount(self.cells_of(places), ratios, minlength=self.count).astype(np.float64)
        rate = settings.ends_per_metre * CELL
        # The line is known because it has a wall. So the cell with the most evidence gets back the prior of two ends.
        cells[self.cells_of(self.feet[[int(self.best.argmax())]])] -= 2.0 * math.log(rate)
        cells[self.cells_of(self.passed)] = -_NEVER
        ends, stay = np.full((2, self.count - 1), math.log(rate)), np.full((2, self.count - 1), math.log1p(-rate))
        for corner in corners:
            border = int(np.abs(self.borders - corner.place).argmin())
            ends[:, border], stay[:, border] = self._at_corner(corner, rate)
        steps = CELL * np.arange(round(OFFSETS[-1] / CELL))
        near = np.zeros((self.count, 2, len(steps)))
        for cell, foot, (lower, upper) in zip(self.cells_of(self.feet), self.feet, self.ratios, strict=True):
            # The cell of the foot holds the ratio of a wall without end; an end beside it inside the wall changes it.
            ends[0, :cell] += np.interp(self.borders[:cell] - foot, OFFSETS, lower) - lower[0]
            ends[1, cell:] += np.interp(foot - self.borders[cell:], OFFSETS, upper) - upper[0]
            into = foot - self.start - CELL * cell
            near[cell, 0] += np.interp(into + steps, OFFSETS, upper)
            near[cell, 1] += np.interp(CELL - into + steps, OFFSETS, lower)
        return cells, near, ends, stay

    def _at_corner(self, corner: CornerOnLine, rate: float) -> tuple[FloatArray, FloatArray]:
        """Return the log potentials of ends and no ends at a detected corner, which may be a false detection [nats]."""
        settings = self.settings
        wrong = settings.false_echo + (1.0 - settings.false_echo) * math.exp(-corner.evidence)
        ends, stay = np.full(2, wrong * rate), np.full(2, wrong * (1.0 - rate))
        ends[list(corner.sides)] += (1.0 - wrong) * settings.corner_end
        # There is wall up to the corner of two known walls, so only the state inside of a wall may continue.
        stay[1 if len(corner.sides) == 1 else slice(None)] += (1.0 - wrong) * (1.0 - settings.corner_end)
        return np.log(ends), np.log(stay)

    def segments(self, chain: Chain, corners: Sequence[CornerOnLine], others: Sequence[Segment]) -> list[Segment]:
        """Return the runs of cells that are probably wall, each with a certain cell, as far as they were detected."""
        is_wall = np.concatenate([[False], chain.wall > 0.5, [False]])
        runs = np.flatnonzero(np.diff(is_wall.astype(int))).reshape(-1, 2)
        known = [(first, last) for first, last in runs if chain.wall[first:last].max() > CERTAIN]
        support = np.sort(np.concatenate([self.feet[self.ratios[:, 0, 0] > 0.0], before_corners(corners)]))
        owners = self.cells_of(support)
        pieces = [
            piece
            for first, last in known
            for piece in self._observed(support[(owners >= first) & (owners < last)], others)
        ]
        pieces = [piece for piece, *beside in _with_neighbours(pieces) if self._is_wanted(piece, *beside)]
        return [self._segment(chain, *each) for each in _with_neighbours(pieces)]

    def _is_wanted(self, piece: FloatArray, before: FloatArray, after: FloatArray) -> bool:
        """Return False for a piece that only corners support, unless the robot crossed the line beside it."""
        beside = (self.passed > before[-1]) & (self.passed < after[0])
        return bool(np.isin(piece, self.feet).any() or beside.any())

    def _observed(self, support: FloatArray, others: Sequence[Segment]) -> list[FloatArray]:
        """Split the places that support a run where an object stands before the line and no station looks behind it."""
        if not (np.diff(support) > _UNSEEN).any():
            return [support] if len(support) else []
        fronts = fronts_of(self.wall.line, others)
        cuts = [
            index + 1
            for index, (low, high) in enumerate(pairwise(support))
            if any(min(high, last) - max(low, first) > _UNSEEN for first, last in fronts)
        ]
        return np.split(support, cuts)

    def _segment(self, chain: Chain, piece: FloatArray, before: FloatArray, after: FloatArray) -> Segment:
        """Make a segment from the places that support it, with ends where the chain finds them."""
        feet = self.wall.history.feet
        near = feet[(feet >= piece[0] - _ARM) & (feet <= piece[-1] + _ARM)]
        detected = np.concatenate([piece, near])
        # By diffraction, a station detects a wall from a little past its end.
        low = self._end(chain.ends[0], before[-1], piece[0] + OFFSETS[-1])
        high = self._end(chain.ends[1], piece[-1] - OFFSETS[-1], after[0])
        return Segment(
            owner=self.owner,
            wall=self.wall,
            low=low.place if low is not None and low.is_known else float(detected.min()),
            high=high.place if high is not None and high.is_known else float(detected.max()),
            ends=(low, high),
            pings=round(self.wall.history.pings * len(near) / max(len(feet), 1)),
            start=self.start,
            chances=chain.wall,
        )

    def _end(self, ends: FloatArray, low: float, high: float) -> End | None:
        """Return the distribution of an end of a wall between two places [m]; None if there may be no end."""
        within = (self.borders > low) & (self.borders < high)
        if ends[within].sum() < CERTAIN:
            return None
        return End(self.borders[within], np.convolve(ends[within], _BLUR, mode="same"))


def _with_neighbours(pieces: Sequence[FloatArray]) -> Iterator[tuple[FloatArray, FloatArray, FloatArray]]:
    """Yield each piece with the previous and the next one, infinitely far away where there is none."""
    yield from zip(pieces, [np.array([-np.inf]), *pieces], [*pieces[1:], np.array([np.inf])], strict=False)
