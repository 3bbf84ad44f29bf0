"""Explanation: what explains the pings: a model of the sonar, noise, and any set of features."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.likelihood.double_bounces import ghosts_of_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.hypothesis_scores import Frame, Verdict, judge
from echoplan.joint.likelihood.multipath import Multipath, Part, reflecting
from echoplan.joint.likelihood.ping_scores import UNHEARD, weigh
from echoplan.joint.likelihood.track_history import Past
from echoplan.preprocessing.ping_arrays import Soundings

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
    before : Explanation, optional
        Of the same pings from other poses, or with another sonar.
    """

    def __init__(
        self, soundings: Soundings, hearing: Hearing, noise: float, *, before: "Explanation | None" = None
    ) -> None:
        self.soundings = soundings
        self.hearing = hearing
        self.noise = noise
        self.multipath: Multipath = Multipath(soundings, hearing, noise, before=before.multipath if before else None)

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
            judged.append(each.judged(verdict.gains, total, _joined(verdict, each.past)))
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
        parts = list(self._parts(features))
        left_out = _without_each(*_flat(parts), len(features), np.full(len(self.soundings.readings), self.floor))
        return list(left_out)

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
        return self._best(self.multipath.parts(features), UNHEARD)

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
        return self._best([self._alone(0, feature)], UNHEARD)

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
        pair = wall.reflector, other.reflector
        ends = reflecting(pair, (wall.extent, other.extent))
        return ghosts_of_walls(self.soundings, self.hearing, pair, ends, self.noise)

    def _parts(self, features: Sequence[Hypothesis]) -> Iterator[Part]:
        yield from (self._alone(number, each) for number, each in enumerate(features))
        yield from self.multipath.parts(features)

    def _alone(self, number: int, feature: Hypothesis) -> Part:
        evidence, (low, high) = feature.evidence, feature.extent
        heard = evidence.densities > UNHEARD
        if feature.is_wall:
            heard &= (evidence.feet > low - _BORDER) & (evidence.feet < high + _BORDER)
        return Part((number, number), evidence.pings[heard], evidence.densities[heard])

    def _best(self, parts: Iterable[Part], least: float) -> FloatArray:
        _, pings, densities = _flat(list(parts))
        levels = np.full(len(self.soundings.readings), least)
        np.maximum.at(levels, pings, densities)
        return levels


def _flat(parts: Sequence[Part]) -> tuple[IntArray, IntArray, FloatArray]:
    """Put parts one after the other: owners of shape (e, 2), pings and levels of shape (e,)."""
    if not parts:
        return np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)
    owners = np.repeat([part.owners for part in parts], [len(part.pings) for part in parts], axis=0)
    return owners, np.concatenate([part.pings for part in parts]), np.concatenate([part.levels for part in parts])


@compiled
def _without_each(owners: IntArray, pings: IntArray, levels: FloatArray, features: int, bare: FloatArray) -> FloatArray:
    """Best levels of what each feature has no hand in, shape (f, n)."""
    left_out = np.empty((features, len(bare)))
    left_out[:] = bare
    for entry in range(len(pings)):
        ping, level = pings[entry], levels[entry]
        for number in range(features):
            mine = number == owners[entry, 0] or number == owners[entry, 1]
            if not mine and level > left_out[number, ping]:
                left_out[number, ping] = level
    return left_out


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
