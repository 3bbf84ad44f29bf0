"""Search for landmarks: forward selection with backward elimination.

The hypothesis with the greatest log-likelihood ratio is accepted, and all earlier landmarks are scored again beside it.
When no hypothesis is accepted any more, arcs that are still unexplained suggest new ones.
"""

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.joint.arcs import Arc, arc_planes
from echoplan.joint.landmarks import LANDMARKS
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.proposals import ArcMeasurements, CandidateSettings, propose_hypotheses
from echoplan.joint.search.acceptance import AcceptanceSettings, AcceptanceTest
from echoplan.joint.search.duplicates import DuplicateSettings, are_duplicates
from echoplan.joint.search.model_moves import split_joined_walls
from echoplan.joint.search.refinement import AnnealingSchedule, approach
from echoplan.joint.trace import Decision, Reason, record_event
from echoplan.preprocessing.measurements import independent, select_measurements

__all__ = ["Search", "SearchSettings"]

# Log-likelihood ratio over clutter up to which a reading is open to refinement, or counts as unexplained [nats].
_OPEN, _UNEXPLAINED = math.log(30.0), math.log(20.0)
# A landmark of so many supporting stations needs no coarse refinement.
_SURE_STATIONS = 3
# Walls nearer to each other than this are the same.
_SAME_WALL = DuplicateSettings(angle_gate=0.035, normal_distance_gate=0.012, gap_gate=0.05)
# Kinds that have proposals of their own, in this order.
_PROPOSED = (Kind.WALL, Kind.CORNER, Kind.CYLINDER, Kind.ROUND)


class SearchSettings(AcceptanceSettings):
    """Extent of the search, and the acceptance test."""

    former_keys: ClassVar = {**AcceptanceSettings.former_keys, "rounds": "max_rounds", "most": "max_candidates"}

    candidates: ClassVar[CandidateSettings] = CandidateSettings()
    max_rounds: int = Field(
        default=3, ge=1, description="Largest number of rounds in which unexplained pings propose landmarks."
    )
    # Largest number of proposals of one class that are refined.
    max_candidates: ClassVar[int] = 200
    # Number of best proposals that are refined again before one is accepted.
    contenders: ClassVar[int] = 6


class Search:
    """Search for the landmarks that maximise the likelihood of the pings.

    ``arcs`` are those of all stations, ``half_aperture`` is that of the sensors [rad].
    """

    def __init__(
        self, likelihood: PingLikelihood, arcs: Sequence[Arc], *, half_aperture: float, settings: SearchSettings
    ) -> None:
        self.likelihood = likelihood
        self.arcs = list(arcs)
        self.settings = settings
        self.acceptance = AcceptanceTest(likelihood.measurements, half_aperture=half_aperture, settings=settings)

    @cached_property
    def _few(self) -> BoolArray:
        """Mask of pings with independent errors, shape (n,)."""
        return independent(self.likelihood.measurements)

    @cached_property
    def _rough(self) -> PingLikelihood:
        """Likelihood of the independent pings, with greater weights and noise; computed only to screen proposals."""
        few = select_measurements(self.likelihood.measurements, self._few)
        few = few._replace(weights=few.weights * (len(self._few) / max(len(few.weights), 1)))
        return PingLikelihood(few, self.likelihood.tables, max(0.012, 2 * self.likelihood.noise))

    def run(self, known: Sequence[Hypothesis] = ()) -> list[Hypothesis]:
        """Return the landmarks in the order of acceptance.

        The search starts from those of ``known`` that are still accepted.
        """
        features = self.tested(self._renewed(known))
        for _ in range(self.settings.max_rounds):
            grown = split_joined_walls(self.likelihood, self._grown(features, self._seeded(features)), self.acceptance)
            if [each.key for each in grown] == [each.key for each in features]:
                return grown
            features = grown
        return features

    def more(self, features: Sequence[Hypothesis], kinds: Collection[Kind]) -> list[Hypothesis]:
        """Search for more landmarks of some classes only; earlier ones that are no longer accepted are removed."""
        pool = [each for each in self._seeded(features) if each.kind in kinds]
        return self._grown(list(features), pool)

    def tested(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Score each landmark beside all others, one after the other, and remove those that are not accepted."""
        kept, place = list(features), 0
        without = self.likelihood.log_densities_without(kept)
        while place < len(kept):
            feature, others = kept[place], [*kept[:place], *kept[place + 1 :]]
            rescored = self.likelihood.rescored(feature, without[place], others)
            refusal = self.acceptance.refusal(rescored, without[place])
            is_accepted = refusal is None
            if refusal:
                record_event(
                    Decision.REMOVED, rescored, reason=refusal, threshold=self.settings.min_log_likelihood_ratio
                )
            kept = [*kept[:place], rescored, *kept[place + 1 :]] if is_accepted else others
            place += is_accepted
            if not is_accepted or rescored.has_other_multipath_than(feature):
                without = self.likelihood.log_densities_without(kept)
        return kept

    def rescored(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Score all landmarks from scratch beside each other, and keep all of them."""
        return self._beside_others(self._renewed(features))[0]

    def settled(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Remove the weakest landmark that is not accepted beside the others, until all are accepted."""
        kept = self._renewed(features)
        while True:
            rescored, refusals = self._beside_others(kept)
            fallen = [(each, refusal) for each, refusal in zip(rescored, refusals, strict=True) if refusal]
            if not fallen:
                return rescored
            weakest, refusal = min(fallen, key=lambda each: each[0].llr)
            record_event(Decision.REMOVED, weakest, reason=refusal, threshold=self.settings.min_log_likelihood_ratio)
            kept = [each for each in rescored if each is not weakest]

    def _beside_others(self, features: Sequence[Hypothesis]) -> tuple[list[Hypothesis], list[Reason | None]]:
        """Score landmarks beside each other; return them, and the acceptance test that each one fails or None."""
        rescored, refusals = [], []
        for place, log_densities in enumerate(self.likelihood.log_densities_without(features)):
            others = _others(features, place)
            left = log_densities if len(others) == len(features) - 1 else self.likelihood.log_densities(others)
            rescored.append(self.likelihood.rescored(features[place], left, others))
            refusals.append(self.acceptance.refusal(rescored[-1], left))
        return rescored, refusals

    def _renewed(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Score the pings for each landmark again, since pings, noise or sonar model may have changed."""
        fresh = [
            replace(self.likelihood.score(each.reflector), history=each.history, is_square=each.is_square)
            for each in features
        ]
        bare = np.full(len(self.likelihood.measurements.readings), self.likelihood.floor)
        return self.likelihood.score_all(fresh, bare, [])

    def _grown(self, features: list[Hypothesis], pool: list[Hypothesis]) -> list[Hypothesis]:
        """Accept the best hypothesis of a pool, until none is acceptable."""
        likelihood, accepted = self.likelihood, list[Hypothesis]()
        log_densities = likelihood.log_densities(features)
        while pool:
            scored = sorted(
                likelihood.score_all(pool, log_densities, features),
                key=self.acceptance.penalised_llr,
                reverse=True,
            )
            pool = [each for each in scored if self.acceptance.penalised_llr(each) > 0.0]
            contenders = scored[: self.settings.contenders]
            best = self._best(contenders, log_densities, features)
            if self.acceptance.penalised_llr(best) <= self.settings.min_log_likelihood_ratio:
                return features
            # A landmark that was accepted and removed is not accepted again: two rivals could replace each other for
            # ever.
            if self._is_rejected(best, log_densities) or any(_same(best, each) for each in accepted):
                pool = self._without_fallen(pool, contenders, log_densities)
                continue
            accepted.append(best)
            record_event(Decision.ADDED, best, reason=Reason.EVIDENCE, threshold=self.settings.min_log_likelihood_ratio)
            pool = [each for each in pool if not _same(each, best)]
            features = self.tested([*features, best])
            log_densities = likelihood.log_densities(features)
        return features

    def _is_rejected(self, hypothesis: Hypothesis, log_densities: FloatArray) -> bool:
        """Return True if a hypothesis fails the acceptance test, and record that."""
        refusal = self.acceptance.refusal(hypothesis, log_densities)
        if refusal:
            record_event(
                Decision.REJECTED, hypothesis, reason=refusal, threshold=self.settings.min_log_likelihood_ratio
            )
        return refusal is not None

    def _without_fallen(
        self, pool: Sequence[Hypothesis], contenders: Sequence[Hypothesis], log_densities: FloatArray
    ) -> list[Hypothesis]:
        """Remove from a pool the contenders that are not accepted, and the first of them in any case."""
        fallen = [contenders[0], *(each for each in contenders if not self.acceptance.is_accepted(each, log_densities))]
        return [each for each in pool if not any(each is other for other in fallen)]

    def _best(
        self, contenders: Sequence[Hypothesis], log_densities: FloatArray, features: Sequence[Hypothesis]
    ) -> Hypothesis:
        """Refine the best few once more on the pings that are still open, and return the best of them."""
        best = self.acceptance.penalised_llr(contenders[0])
        near = [each for each in contenders if self.acceptance.penalised_llr(each) >= min(best, 0.8 * best)]
        refined = [self._refined(each, log_densities, features) for each in near]
        return max([*near, *refined], key=self.acceptance.penalised_llr)

    def _refined(self, hypothesis: Hypothesis, log_densities: FloatArray, features: Sequence[Hypothesis]) -> Hypothesis:
        """Refine a hypothesis on the open readings of its supporting stations."""
        likelihood, noise = self.likelihood, self.likelihood.noise
        supporting = (hypothesis.llr_by_station > 0.0)[likelihood.measurements.stations]
        free = np.flatnonzero((log_densities < likelihood.floor + _OPEN) & supporting)
        schedules = [[(noise, max(0.02, 4 * noise), 3)]]
        if (hypothesis.llr_by_station > self.settings.min_second_station_llr).sum() < _SURE_STATIONS:
            # With few supporting stations, the start may be farther off than the noise.
            schedules.append([(4 * noise, max(0.03, 16 * noise), 3), *schedules[0]])
        proposed = [likelihood.score(self._moved(hypothesis.reflector, free, schedule)) for schedule in schedules]
        return max(likelihood.score_all(proposed, log_densities, features), key=self.acceptance.penalised_llr)

    def _moved(self, reflector: FloatArray, pings: IntArray, schedule: AnnealingSchedule) -> FloatArray:
        """Refine a reflector on pings by an annealing schedule."""
        return approach(self.likelihood.measurements, self.likelihood.tables, reflector, pings, schedule)

    def _seeded(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Propose hypotheses from arcs that are mostly unexplained."""
        rows, log_densities, free = self._proposals(features)
        pool = [each for kind in _PROPOSED for each in self._promising(kind, rows, log_densities, free)]
        return [each for each in pool if not any(_same(each, feature) for feature in features)]

    def _proposals(self, features: Sequence[Hypothesis]) -> tuple[FloatArray, FloatArray, IntArray]:
        """Return reflectors that unexplained arcs suggest, log densities of readings, and readings that are open."""
        likelihood = self.likelihood
        log_densities = likelihood.log_densities(features)
        open_readings = log_densities < likelihood.floor + _UNEXPLAINED
        arcs = [arc for arc in self.arcs if arc.share_of(open_readings) > 0.5]
        free = np.flatnonzero(log_densities < likelihood.floor + _OPEN)
        if not arcs:
            return np.zeros((0, 4)), log_densities, free
        stations = np.array([arc.station for arc in arcs])
        arc_measurements = ArcMeasurements(
            stations=stations,
            centers=likelihood.measurements.centers[stations],
            planes=arc_planes(arcs, likelihood.measurements, likelihood.tables),
            pings=np.array([len(arc.pings) for arc in arcs]),
        )
        fresh: BoolArray = np.ones(len(arcs), dtype=bool)
        rows = propose_hypotheses(arc_measurements, fresh, self.settings.candidates)
        return rows, log_densities, free

    def _promising(self, kind: Kind, rows: FloatArray, log_densities: FloatArray, free: IntArray) -> list[Hypothesis]:
        """Screen proposals of one class, refine the best of them on open readings, and keep distinct ones."""
        likelihood, noise = self.likelihood, self.likelihood.noise
        rough, fine = ((max(0.008, 1.5 * noise), 0.03, 4),), ((noise, 0.02, 3),)
        few, cell = free[self._few[free]], LANDMARKS[kind].refined_cell
        coarse = _apart(self._all_moved(self._screened(rows[rows[:, 0] == kind], log_densities), few, rough), cell)
        apart = _apart(self._all_moved(coarse, free, fine), cell)
        others = [np.array([other, *row[1:]]) for other in LANDMARKS[kind].also_proposed for row in apart]
        # Only sound returns from a concave corner; rays read its walls.
        apart = apart[:0] if kind is Kind.CORNER and likelihood.tables.cone else apart
        return [likelihood.score(row) for row in [*apart, *self._all_moved(others, free, fine)]]

    def _all_moved(
        self, reflectors: Iterable[FloatArray], pings: IntArray, schedule: AnnealingSchedule
    ) -> list[FloatArray]:
        """Refine reflectors on pings by an annealing schedule."""
        return [self._moved(each, pings, schedule) for each in reflectors]

    def _screened(self, rows: FloatArray, log_densities: FloatArray) -> list[FloatArray]:
        """Return the best proposals on the independent pings, best first."""
        scored = self._rough.score_all([self._rough.score(row) for row in rows], log_densities[self._few], [])
        best = sorted(scored, key=lambda each: each.llr, reverse=True)[: self.settings.max_candidates]
        return [each.reflector for each in best if each.llr > 2.0]


def _others(features: Sequence[Hypothesis], place: int) -> list[Hypothesis]:
    """Return the landmarks beside which a landmark is scored.

    Two coincident landmarks would leave each other no gain. So the stronger one, or the first of two equals, is scored
    without the other.
    """
    feature = features[place]
    return [
        each
        for number, each in enumerate(features)
        if number != place and ((each.llr, place) > (feature.llr, number) or not _same(each, feature))
    ]


def _same(one: Hypothesis, other: Hypothesis) -> bool:
    """Return True if two hypotheses of one class coincide."""
    if one.reflector[0] != other.reflector[0]:
        return False
    if not one.is_wall:
        apart = one.reflector[1:] - other.reflector[1:]
        return bool(np.hypot(apart[0], apart[1]) < 0.02 and abs(apart[2]) < 0.03)
    return are_duplicates(one, other, _SAME_WALL)


def _apart(reflectors: Sequence[FloatArray], cell: tuple[float, float, float]) -> FloatArray:
    """Keep the first reflector in each cell of a grid."""
    rows = np.array(reflectors).reshape(-1, 4)
    _, first = np.unique(np.round(rows[:, 1:] / cell).astype(np.int64), axis=0, return_index=True)
    return rows[np.sort(first)]
