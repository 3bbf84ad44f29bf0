"""Hypotheses: reflectors with the evidence for them, and what a set of them explains together."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.expectation import Hearing, Kind
from echoplan.arrays import FloatArray
from echoplan.classification.evidence import UNHEARD, Evidence, Frame, Verdict, judge, weigh
from echoplan.classification.ghosts import ghosts_of_cylinder, ghosts_of_walls
from echoplan.classification.past import NO_PAST, Past
from echoplan.classification.volleys import Volleys, volleys_over
from echoplan.geometry import directions, intersections
from echoplan.preprocessing.soundings import Soundings

__all__ = ["Explanation", "Hypothesis"]

# One reading in 25 may be anything within reach, whatever is there.
_ANYTHING = 0.04
# Walls may reflect so far beyond what was heard of them, or up to a crossing that is no farther [m].
_STRETCH, _TO_CROSSING = 0.4, 2.0
# Walls are heard so far beyond the feet of what was heard [m].
_BORDER = 0.1
# Walls that turn less than this toward each other cross too far away (sine).
_PARALLEL = 0.1

# Plain numbers are faster to compare than members of an enumeration.
_WALL = int(Kind.WALL)

_Key: TypeAlias = tuple[object, ...]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Hypothesis:
    """A reflector that may be there, and what speaks for it.

    Parameters
    ----------
    reflector : ndarray, shape (4,)
        Value of ``Kind`` and three parameters.
    evidence : Evidence
        What single pings say.
    gains : ndarray, shape (s,)
        Gain by station over what explains the pings without it [nats].
    total : float, optional
        Their sum [nats].
    extent : tuple of float, optional
        Ends of a wall along it [m].
    past : Past, optional
        What stations said of it whose pings are no longer at hand; it counts in the total and the extent.
    """

    reflector: FloatArray
    evidence: Evidence
    gains: FloatArray
    total: float = 0.0
    extent: tuple[float, float] = (0.0, 0.0)
    past: Past = NO_PAST

    @property
    def best(self) -> float:
        """Gain of the station that says most for it [nats]."""
        return max(float(self.gains.max(initial=0.0)), self.past.best)

    @property
    def is_known(self) -> bool:
        """Whether it was believed before any of the stations at hand."""
        return self.past.number >= 0

    @property
    def kind(self) -> Kind:
        """What it is taken for."""
        return Kind(int(self.reflector[0]))

    @property
    def is_wall(self) -> bool:
        """Whether it is a wall."""
        return bool(self.reflector[0] == _WALL)

    @property
    def parameters(self) -> FloatArray:
        """Its free parameters: two, or three of a cylinder."""
        return self.reflector[1 : 4 if self.kind is Kind.CYLINDER else 3]

    @property
    def line(self) -> FloatArray:
        """Normal angle and offset of a wall [rad, m], shape (2,)."""
        return self.reflector[1:3]

    def speaking(self, least: float) -> int:
        """Count the stations that speak for it by more than this [nats]."""
        return int((self.gains > least).sum()) + self.past.speaking

    @property
    def key(self) -> _Key:
        """What tells it from others: reflector and extent."""
        return (*self.reflector.tolist(), *self.extent)


class Explanation:
    """What explains the pings: a model of the sonar, noise, and any set of features.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    noise : float
        Standard deviation of readings [m].
    """

    def __init__(self, soundings: Soundings, hearing: Hearing, noise: float) -> None:
        self.soundings = soundings
        self.hearing = hearing
        self.noise = noise
        self._silence = np.full(len(soundings.readings), UNHEARD)
        self._known: dict[_Key, FloatArray | None] = {}
        self._volleys: dict[_Key, Volleys] = {}

    @property
    def floor(self) -> float:
        """Logarithm of the density of readings that nothing explains [log 1/m]."""
        return float(np.log(_ANYTHING / self.soundings.max_range))

    def propose(self, reflector: FloatArray) -> Hypothesis:
        """Collect the evidence for a reflector.

        Parameters
        ----------
        reflector : ndarray, shape (4,)
            Kind and parameters.

        Returns
        -------
        Hypothesis
            Not judged yet.
        """
        evidence = weigh(self.soundings, self.hearing, reflector, self.noise)
        return Hypothesis(reflector=reflector, evidence=evidence, gains=np.zeros(len(self.soundings.centers)))

    def judged(self, hypothesis: Hypothesis, levels: FloatArray, others: Sequence[Hypothesis]) -> Hypothesis:
        """Judge a hypothesis beside others.

        Parameters
        ----------
        hypothesis : Hypothesis
            The one.
        levels : ndarray, shape (n,)
            What the others explain.
        others : sequence of Hypothesis
            The others: they may block the view of it.

        Returns
        -------
        Hypothesis
            With its gains, and the extent of a wall.
        """
        return self.judge_all([hypothesis], levels, others)[0]

    def judge_all(
        self, hypotheses: Sequence[Hypothesis], levels: FloatArray, others: Sequence[Hypothesis]
    ) -> list[Hypothesis]:
        """Judge hypotheses one by one beside the same others.

        Parameters
        ----------
        hypotheses : sequence of Hypothesis
            Any number.
        levels : ndarray, shape (n,)
            What the others explain.
        others : sequence of Hypothesis
            The others.

        Returns
        -------
        list of Hypothesis
            With their gains.
        """
        frame, judged = _frame(others), []
        for each in hypotheses:
            verdict = judge(self.soundings, each.reflector, each.evidence, levels, frame, each.past.extent)
            total = verdict.total + each.past.total
            judged.append(replace(each, gains=verdict.gains, total=total, extent=_joined(verdict, each.past)))
        return judged

    def levels(self, features: Sequence[Hypothesis]) -> FloatArray:
        """Explain all pings by a set of features and their ghosts.

        Parameters
        ----------
        features : sequence of Hypothesis
            The features.

        Returns
        -------
        ndarray, shape (n,)
            Logarithm of the density of each reading by its best explanation [log 1/m].
        """
        levels = np.maximum(self.floor, self.ghost_levels(features))
        for each in features:
            np.maximum(levels, self.levels_of(each), out=levels)
        return levels

    def ghost_levels(self, features: Sequence[Hypothesis]) -> FloatArray:
        """Explain pings by nothing but ghosts.

        Parameters
        ----------
        features : sequence of Hypothesis
            What casts them.

        Returns
        -------
        ndarray, shape (n,)
            As ``levels``; ``UNHEARD`` where no ghost explains a ping.
        """
        levels = np.full(len(self.soundings.readings), UNHEARD)
        for ghost in self._ghosts(features):
            if ghost is not None:
                np.maximum(levels, ghost, out=levels)
        return levels

    def _ghosts(self, features: Sequence[Hypothesis]) -> Iterator[FloatArray | None]:
        """Work out the ghosts of features one by one; if no station heard both of two, none hears one in the other."""
        walls = [(each, _listeners(each)) for each in features if each.is_wall]
        columns = [(each, _listeners(each)) for each in features if each.kind is Kind.CYLINDER]
        for number, (wall, listeners) in enumerate(walls):
            yield self._volley(wall)
            for other in (each for each, heard in walls[number + 1 :] if listeners & heard):
                yield self._mirrored(wall, other)
                yield self._volley_of_pair(wall, other)
            yield from (self._reflected(wall, other) for other, heard in columns if listeners & heard)

    def levels_of(self, feature: Hypothesis) -> FloatArray:
        """Explain pings by one feature alone.

        Parameters
        ----------
        feature : Hypothesis
            The feature.

        Returns
        -------
        ndarray, shape (n,)
            As ``levels``; ``UNHEARD`` where it does not explain a ping.
        """

        def alone() -> FloatArray:
            levels, evidence = np.full(len(self.soundings.readings), UNHEARD), feature.evidence
            low, high = feature.extent
            inside = (evidence.feet > low - _BORDER) & (evidence.feet < high + _BORDER) | (not feature.is_wall)
            levels[evidence.pings[inside]] = evidence.densities[inside]
            return levels

        return self._or_nothing(self._once(("alone", *feature.key), alone))

    def pair_levels(self, wall: Hypothesis, other: Hypothesis) -> FloatArray:
        """Explain pings by echoes of one wall in another.

        Parameters
        ----------
        wall, other : Hypothesis
            Two walls.

        Returns
        -------
        ndarray, shape (n,)
            As ``levels``; ``UNHEARD`` where there is no such echo.
        """
        return self._or_nothing(self._mirrored(wall, other))

    def _mirrored(self, wall: Hypothesis, other: Hypothesis) -> FloatArray | None:
        def between() -> FloatArray:
            pair, ends = (wall.reflector, other.reflector), _reflecting(wall, other)
            return ghosts_of_walls(self.soundings, self.hearing, pair, ends, self.noise)

        return self._once(("walls", *wall.key, *other.key), between)

    def _reflected(self, wall: Hypothesis, cylinder: Hypothesis) -> FloatArray | None:
        return self._once(
            ("cylinder", *wall.reflector.tolist(), *cylinder.reflector.tolist()),
            lambda: ghosts_of_cylinder(self.soundings, self.hearing, wall.reflector, cylinder.reflector, self.noise),
        )

    def _volley(self, wall: Hypothesis) -> FloatArray | None:
        return self._once(("volley", *wall.key), lambda: self._volley_over([wall], [_stretched(wall, None)]))

    def _volley_of_pair(self, wall: Hypothesis, other: Hypothesis) -> FloatArray | None:
        def both_ways() -> FloatArray:
            first, second = _reflecting(wall, other)
            there = self._volley_over([wall, other], [first, second])
            return np.maximum(there, self._volley_over([other, wall], [second, first]))

        return self._once(("volleys", *wall.key, *other.key), both_ways)

    def _volley_over(self, walls: Sequence[Hypothesis], extents: Sequence[FloatArray]) -> FloatArray:
        reflectors = np.array([each.reflector for each in walls])
        key = tuple(reflectors.ravel().tolist())
        if key not in self._volleys:
            self._volleys[key] = volleys_over(self.soundings, self.hearing, reflectors, self.noise)
        return self._volleys[key].within(np.array(extents), len(self.soundings.readings))

    def _once(self, key: _Key, explain: Callable[[], FloatArray]) -> FloatArray | None:
        """Explain once; most ghosts explain nothing, and are remembered as such."""
        if key not in self._known:
            levels = explain()
            self._known[key] = levels if levels.max(initial=UNHEARD) > UNHEARD else None
        return self._known[key]

    def _or_nothing(self, levels: FloatArray | None) -> FloatArray:
        return self._silence if levels is None else levels


def _joined(verdict: Verdict, past: Past) -> tuple[float, float]:
    """Join what was heard of a wall now with what was heard before."""
    low, high = verdict.low, verdict.high
    if past.extent[0] > past.extent[1]:
        return low, high
    # A wall that none of the stations at hand heard has no extent of its own.
    return past.extent if low == high == 0.0 else (min(low, past.extent[0]), max(high, past.extent[1]))


def _listeners(feature: Hypothesis) -> int:
    """Collect the stations that heard a feature as the bits of a number."""
    return int.from_bytes(np.packbits(feature.gains > 0.0).tobytes(), "big")


def _frame(features: Sequence[Hypothesis]) -> Frame:
    return Frame(
        reflectors=np.array([each.reflector for each in features]).reshape(-1, 4),
        extents=np.array([each.extent for each in features]).reshape(-1, 2),
    )


def _reflecting(wall: Hypothesis, other: Hypothesis) -> tuple[FloatArray, FloatArray]:
    """Where two walls may reflect: as far as they were heard and a little more, or up to where they meet."""
    if abs(np.sin(wall.line[0] - other.line[0])) < _PARALLEL:
        return _stretched(wall, None), _stretched(other, None)
    meeting = intersections(wall.line, other.line)
    return _stretched(wall, meeting), _stretched(other, meeting)


def _stretched(wall: Hypothesis, meeting_xy: FloatArray | None) -> FloatArray:
    low, high = wall.extent
    if meeting_xy is None:
        return np.array([low - _STRETCH, high + _STRETCH])
    place = float(meeting_xy @ directions(wall.line[0] + np.pi / 2))
    if max(low - place, place - high) > _TO_CROSSING:
        return np.array([low - _STRETCH, high + _STRETCH])
    return np.array([min(low - _STRETCH, place - 0.05), max(high + _STRETCH, place + 0.05)])
