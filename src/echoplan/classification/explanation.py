"""Explanation: what explains the pings: a model of the sonar, noise, and any set of features."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from echoplan.acoustics.expectation import Hearing
from echoplan.arrays import FloatArray
from echoplan.classification.evidence import UNHEARD, Frame, Verdict, judge, weigh
from echoplan.classification.hypotheses import Hypothesis, Key
from echoplan.classification.multipath import Multipath, Part
from echoplan.classification.past import Past
from echoplan.preprocessing.soundings import Soundings

__all__ = ["Explanation"]

# One reading in 25 may be anything within reach, whatever is there.
_ANYTHING = 0.04
# Walls are heard so far beyond the feet of what was heard [m].
_BORDER = 0.1


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
        self._multipath = Multipath(soundings, hearing, noise)
        self._alone: dict[Key, FloatArray] = {}

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
        return self._best(self._parts(features), self.floor)

    def levels_without(self, features: Sequence[Hypothesis]) -> list[FloatArray]:
        """Explain all pings by all features but one, and by the ghosts of these.

        Parameters
        ----------
        features : sequence of Hypothesis
            The features.

        Returns
        -------
        list of ndarray, shape (n,)
            As ``levels`` of all others, for each feature.
        """
        parts = self._parts(features)
        stack = np.array([part.levels for part in parts]).reshape(len(parts), len(self.soundings.readings))
        concerned = np.array([[number in part.owners for part in parts] for number in range(len(features))])
        all_levels = self._best(parts, self.floor)
        left_out = []
        for mine in concerned:
            levels = all_levels.copy()
            # Only where this feature has a hand in the best explanation does it matter that it is gone.
            gone = (stack[mine].max(axis=0) >= levels).nonzero()[0]
            levels[gone] = np.maximum(self.floor, stack[np.ix_(~mine, gone)].max(axis=0, initial=UNHEARD))
            left_out.append(levels)
        return left_out

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
        return self._best(list(self._multipath.parts(features)), UNHEARD)

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
        if feature.key not in self._alone:
            levels, evidence = np.full(len(self.soundings.readings), UNHEARD), feature.evidence
            low, high = feature.extent
            inside = (evidence.feet > low - _BORDER) & (evidence.feet < high + _BORDER) | (not feature.is_wall)
            levels[evidence.pings[inside]] = evidence.densities[inside]
            self._alone[feature.key] = levels
        return self._alone[feature.key]

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
        levels = self._multipath.mirrored(wall, other)
        return np.full(len(self.soundings.readings), UNHEARD) if levels is None else levels

    def _parts(self, features: Sequence[Hypothesis]) -> list[Part]:
        alone = [Part((number,), self.levels_of(each)) for number, each in enumerate(features)]
        return [*alone, *self._multipath.parts(features)]

    def _best(self, parts: Sequence[Part], least: float) -> FloatArray:
        levels = np.full(len(self.soundings.readings), least)
        for part in parts:
            np.maximum(levels, part.levels, out=levels)
        return levels


def _joined(verdict: Verdict, past: Past) -> tuple[float, float]:
    """Join what was heard of a wall now with what was heard before."""
    low, high = verdict.low, verdict.high
    if past.extent[0] > past.extent[1]:
        return low, high
    # A wall that none of the stations at hand heard has no extent of its own.
    return past.extent if low == high == 0.0 else (min(low, past.extent[0]), max(high, past.extent[1]))


def _frame(features: Sequence[Hypothesis]) -> Frame:
    return Frame(
        reflectors=np.array([each.reflector for each in features]).reshape(-1, 4),
        extents=np.array([each.extent for each in features]).reshape(-1, 2),
    )
