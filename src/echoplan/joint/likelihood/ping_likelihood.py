"""Likelihood of all pings given a sonar model, a noise level and a set of landmarks: a max-mixture of associations."""

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from echoplan.acoustics.predicted_echo import SonarTables
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.likelihood.double_bounces import ghosts_of_walls
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.hypothesis_scores import HypothesisScore, Occluders, rescore
from echoplan.joint.likelihood.multipath import Multipath, Part, reflecting
from echoplan.joint.likelihood.ping_scores import NO_ECHO, score_pings
from echoplan.joint.likelihood.track_history import TrackHistory
from echoplan.preprocessing.measurements import Measurements

__all__ = ["PingLikelihood"]

# Probability p_c that a reading is clutter, which is uniform up to `max_range` (docs/theory.md).
_ANYTHING = 0.04
# A wall explains readings whose foot of the perpendicular is up to this far beyond its extent [m].
_BORDER = 0.1


class PingLikelihood:
    """Likelihood of pings given a sonar model, a noise level and any set of landmarks.

    ``noise`` is the standard deviation of readings [m]. ``before`` is the likelihood of the same pings for other poses
    or another sonar model: its list of crosstalk emissions is reused if it still applies.
    """

    def __init__(
        self, measurements: Measurements, tables: SonarTables, noise: float, *, before: "PingLikelihood | None" = None
    ) -> None:
        self.measurements = measurements
        self.tables = tables
        self.noise = noise
        self.multipath: Multipath = Multipath(measurements, tables, noise, before=before.multipath if before else None)

    @property
    def floor(self) -> float:
        """Log density of a clutter reading [log 1/m]."""
        return float(np.log(_ANYTHING / self.measurements.max_range))

    def score(self, reflector: FloatArray) -> Hypothesis:
        """Return a hypothesis with the ping scores of a landmark, shape (4,); its log-likelihood ratios are zero."""
        scores = score_pings(self.measurements, self.tables, reflector, self.noise)
        return Hypothesis(
            reflector=reflector, ping_scores=scores, llr_by_station=np.zeros(len(self.measurements.centers))
        )

    def rescored(self, hypothesis: Hypothesis, log_densities: FloatArray, others: Sequence[Hypothesis]) -> Hypothesis:
        """Return a hypothesis with its log-likelihood ratios and the extent of a wall, given the other landmarks.

        ``log_densities``, shape (n,), are those of the readings by their best association without it [log 1/m];
        ``others`` may occlude it.
        """
        return self.score_all([hypothesis], log_densities, others)[0]

    def score_all(
        self, hypotheses: Sequence[Hypothesis], log_densities: FloatArray, others: Sequence[Hypothesis]
    ) -> list[Hypothesis]:
        """Return each hypothesis with its log-likelihood ratios and extent, given the same others, as ``rescored``."""
        rescored = []
        frame = Occluders(
            reflectors=np.array([each.reflector for each in others]).reshape(-1, 4),
            extents=np.array([each.extent for each in others]).reshape(-1, 2),
        )
        for each in hypotheses:
            verdict = rescore(
                self.measurements, each.reflector, each.ping_scores, log_densities, frame, each.history.extent
            )
            total = verdict.llr + each.history.llr
            rescored.append(each.rescored(verdict.llr_by_station, total, _joined(verdict, each.history)))
        return rescored

    def log_densities(self, features: Sequence[Hypothesis]) -> FloatArray:
        """Return the log density of each reading by landmarks, their multipath or clutter [log 1/m], shape (n,).

        The association of the greatest density counts.
        """
        return self._best(self._parts(features), self.floor)

    def log_densities_without(self, features: Sequence[Hypothesis]) -> list[FloatArray]:
        """Return, for each landmark, the ``log_densities`` of all others and their multipath."""
        parts = list(self._parts(features))
        left_out = _without_each(*_flat(parts), len(features), np.full(len(self.measurements.readings), self.floor))
        return list(left_out)

    def multipath_log_densities(self, features: Sequence[Hypothesis]) -> FloatArray:
        """Return the log density of each reading by multipath alone [log 1/m], shape (n,); ``NO_ECHO`` elsewhere."""
        return self._best(self.multipath.parts(features), NO_ECHO)

    def log_densities_of(self, feature: Hypothesis) -> FloatArray:
        """Return the log density of each reading by one landmark alone [log 1/m], shape (n,); ``NO_ECHO`` elsewhere."""
        return self._best([self._alone(0, feature)], NO_ECHO)

    def pair_log_densities(self, wall: Hypothesis, other: Hypothesis) -> FloatArray:
        """Return the log density of each reading by double bounces of two walls [log 1/m]; ``NO_ECHO`` elsewhere."""
        pair = wall.reflector, other.reflector
        ends = reflecting(pair, (wall.extent, other.extent))
        return ghosts_of_walls(self.measurements, self.tables, pair, ends, self.noise)

    def _parts(self, features: Sequence[Hypothesis]) -> Iterator[Part]:
        """Yield what each landmark explains, and then what their multipath explains."""
        yield from (self._alone(number, each) for number, each in enumerate(features))
        yield from self.multipath.parts(features)

    def _alone(self, number: int, feature: Hypothesis) -> Part:
        """Return the readings that direct echoes of a landmark explain; of a wall, within its extent and a margin."""
        evidence, (low, high) = feature.ping_scores, feature.extent
        detected = evidence.densities > NO_ECHO
        if feature.is_wall:
            detected &= (evidence.feet > low - _BORDER) & (evidence.feet < high + _BORDER)
        return Part((number, number), evidence.pings[detected], evidence.densities[detected])

    def _best(self, parts: Iterable[Part], least: float) -> FloatArray:
        """Return the greatest log density of each reading by any of the parts, and at least ``least``."""
        _, pings, densities = _flat(list(parts))
        log_densities = np.full(len(self.measurements.readings), least)
        np.maximum.at(log_densities, pings, densities)
        return log_densities


def _flat(parts: Sequence[Part]) -> tuple[IntArray, IntArray, FloatArray]:
    """Concatenate parts into owners of shape (e, 2), and pings and log densities of shape (e,)."""
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
    """Return, for each landmark, the best log densities of all parts that do not involve it, shape (f, n)."""
    left_out = np.empty((features, len(bare)))
    for number in range(features):
        for ping in range(len(bare)):
            left_out[number, ping] = bare[ping]
    for entry in range(len(pings)):
        ping, level = pings[entry], log_densities[entry]
        for number in range(features):
            mine = number == owners[entry, 0] or number == owners[entry, 1]
            if not mine and level > left_out[number, ping]:
                left_out[number, ping] = level
    return left_out


def _joined(verdict: HypothesisScore, history: TrackHistory) -> tuple[float, float]:
    """Return the extent of a wall [m] from the stations of the window and from its track history."""
    low, high = verdict.low, verdict.high
    if history.extent[0] > history.extent[1]:
        return low, high
    # The extent (0, 0) means that no station of the window detected the wall.
    return history.extent if low == high == 0.0 else (min(low, history.extent[0]), max(high, history.extent[1]))
