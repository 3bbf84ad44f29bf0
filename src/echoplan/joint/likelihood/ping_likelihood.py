"""PingLikelihood: what explains the pings: a model of the sonar, noise, and any set of features."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.likelihood.double_bounces import ghosts_of_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.hypothesis_scores import HypothesisScore, Occluders, rescore
from echoplan.joint.likelihood.multipath import Multipath, Part, reflecting
from echoplan.joint.likelihood.ping_scores import UNHEARD, score_pings
from echoplan.joint.likelihood.track_history import TrackHistory
from echoplan.preprocessing.measurements import Measurements

__all__ = ["PingLikelihood"]

# One reading in 25 may be anything within reach, whatever is there.
_ANYTHING = 0.04
# Walls are heard so far beyond the feet of what was heard [m].
_BORDER = 0.1


class PingLikelihood:
    """What explains the pings: a model of the sonar, noise, and any set of features.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    hearing : Hearing
        The sonar.
    noise : float
        Standard deviation of readings [m].
    before : PingLikelihood, optional
        Of the same pings from other poses, or with another sonar.
    """

    def __init__(
        self, measurements: Measurements, hearing: Hearing, noise: float, *, before: "PingLikelihood | None" = None
    ) -> None:
        self.measurements = measurements
        self.hearing = hearing
        self.noise = noise
        self.multipath: Multipath = Multipath(measurements, hearing, noise, before=before.multipath if before else None)

    @property
    def floor(self) -> float:
        """Logarithm of the density of readings that nothing explains [log 1/m]."""
        return float(np.log(_ANYTHING / self.measurements.max_range))

    def score(self, reflector: FloatArray) -> Hypothesis:
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
        scores = score_pings(self.measurements, self.hearing, reflector, self.noise)
        return Hypothesis(
            reflector=reflector, ping_scores=scores, llr_by_station=np.zeros(len(self.measurements.centers))
        )

    def rescored(self, hypothesis: Hypothesis, log_densities: FloatArray, others: Sequence[Hypothesis]) -> Hypothesis:
        """Judge a hypothesis beside others.

        Parameters
        ----------
        hypothesis : Hypothesis
            The one.
        log_densities : ndarray, shape (n,)
            What the others explain.
        others : sequence of Hypothesis
            The others: they may block the view of it.

        Returns
        -------
        Hypothesis
            With its gains, and the extent of a wall.
        """
        return self.score_all([hypothesis], log_densities, others)[0]

    def score_all(
        self, hypotheses: Sequence[Hypothesis], log_densities: FloatArray, others: Sequence[Hypothesis]
    ) -> list[Hypothesis]:
        """Judge hypotheses one by one beside the same others.

        Parameters
        ----------
        hypotheses : sequence of Hypothesis
            Any number.
        log_densities : ndarray, shape (n,)
            What the others explain.
        others : sequence of Hypothesis
            The others.

        Returns
        -------
        list of Hypothesis
            With their gains.
        """
        frame, rescored = _frame(others), []
        for each in hypotheses:
            verdict = rescore(
                self.measurements, each.reflector, each.ping_scores, log_densities, frame, each.history.extent
            )
            total = verdict.total + each.history.total
            rescored.append(each.rescored(verdict.llr_by_station, total, _joined(verdict, each.history)))
        return rescored

    def log_densities(self, features: Sequence[Hypothesis]) -> FloatArray:
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

    def log_densities_without(self, features: Sequence[Hypothesis]) -> list[FloatArray]:
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
        left_out = _without_each(*_flat(parts), len(features), np.full(len(self.measurements.readings), self.floor))
        return list(left_out)

    def multipath_log_densities(self, features: Sequence[Hypothesis]) -> FloatArray:
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

    def log_densities_of(self, feature: Hypothesis) -> FloatArray:
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

    def pair_log_densities(self, wall: Hypothesis, other: Hypothesis) -> FloatArray:
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
        return ghosts_of_walls(self.measurements, self.hearing, pair, ends, self.noise)

    def _parts(self, features: Sequence[Hypothesis]) -> Iterator[Part]:
        yield from (self._alone(number, each) for number, each in enumerate(features))
        yield from self.multipath.parts(features)

    def _alone(self, number: int, feature: Hypothesis) -> Part:
        evidence, (low, high) = feature.ping_scores, feature.extent
        detected = evidence.densities > UNHEARD
        if feature.is_wall:
            detected &= (evidence.feet > low - _BORDER) & (evidence.feet < high + _BORDER)
        return Part((number, number), evidence.pings[detected], evidence.densities[detected])

    def _best(self, parts: Iterable[Part], least: float) -> FloatArray:
        _, pings, densities = _flat(list(parts))
        log_densities = np.full(len(self.measurements.readings), least)
        np.maximum.at(log_densities, pings, densities)
        return log_densities


def _flat(parts: Sequence[Part]) -> tuple[IntArray, IntArray, FloatArray]:
    """Put parts one after the other: owners of shape (e, 2), pings and levels of shape (e,)."""
    if not parts:
        return np.zeros((0, 2), dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0)
    owners = np.repeat([part.owners for part in parts], [len(part.pings) for part in parts], axis=0)
    return (
        owners,
        np.concatenate([part.pings for part in parts]),
        np.concatenate([part.log_densities for part in parts]),
    )


@compiled
def _without_each(
    owners: IntArray, pings: IntArray, log_densities: FloatArray, features: int, bare: FloatArray
) -> FloatArray:
    """Best levels of what each feature has no hand in, shape (f, n)."""
    left_out = np.empty((features, len(bare)))
    left_out[:] = bare
    for entry in range(len(pings)):
        ping, level = pings[entry], log_densities[entry]
        for number in range(features):
            mine = number == owners[entry, 0] or number == owners[entry, 1]
            if not mine and level > left_out[number, ping]:
                left_out[number, ping] = level
    return left_out


def _joined(verdict: HypothesisScore, history: TrackHistory) -> tuple[float, float]:
    """Join what was heard of a wall now with what was heard before."""
    low, high = verdict.low, verdict.high
    if history.extent[0] > history.extent[1]:
        return low, high
    # A wall that none of the stations at hand heard has no extent of its own.
    return history.extent if low == high == 0.0 else (min(low, history.extent[0]), max(high, history.extent[1]))


def _frame(features: Sequence[Hypothesis]) -> Occluders:
    return Occluders(
        reflectors=np.array([each.reflector for each in features]).reshape(-1, 4),
        extents=np.array([each.extent for each in features]).reshape(-1, 2),
    )
