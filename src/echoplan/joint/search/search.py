"""Search: the set of features that explains the pings best, one by one, each held against all others.

Greedy, with second thoughts: the candidate that explains most of what is unexplained is accepted, and every older
feature has to stand up again beside it.  When nothing is left to accept, what is still unexplained suggests anew.
"""

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cached_property

import numpy as np
from pydantic import Field

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.joint.arcs import Arc, arc_planes
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import Explanation
from echoplan.joint.likelihood.proposals import CandidateSettings, Sightings, suggest
from echoplan.joint.search.acceptance import Belief, BeliefSettings
from echoplan.joint.search.duplicates import CopySettings, are_copies
from echoplan.joint.search.model_moves import without_joining
from echoplan.joint.search.refinement import Course, approach
from echoplan.joint.trace import Decision, Reason, record_event
from echoplan.preprocessing.ping_arrays import chosen_soundings, independent

__all__ = ["Search", "SearchSettings"]

# A reading is open as long as it is no more than this many times likelier than if it were anything.
_OPEN, _UNEXPLAINED = math.log(30.0), math.log(20.0)
# A reflector that so many stations speak for cannot be far off.
_SURE_STATIONS = 3
# Walls nearer than this to each other are one.
_SAME_WALL = CopySettings(turn=0.035, beside=0.012, apart=0.05)
# Candidates of one kind this near to each other are one [rad and m; m; m and radius].
_CELLS = {
    Kind.WALL: (0.01, 0.006, 1.0),
    Kind.CORNER: (0.012, 0.012, 1.0),
    Kind.CYLINDER: (0.015, 0.015, 0.02),
}


class SearchSettings(BeliefSettings, frozen=True, extra="forbid"):
    """How long is searched, and when a reflector is believed."""

    candidates: CandidateSettings = Field(default_factory=CandidateSettings)
    rounds: int = Field(default=3, ge=1, description="how often what is unexplained may suggest anew")
    most: int = Field(default=200, ge=1, description="candidates of one kind that are refined")
    contenders: int = Field(default=6, ge=1, description="candidates that are refined again before one is accepted")


class Search:
    """Finds the features that explain the pings.

    Parameters
    ----------
    explanation : Explanation
        The pings and the sonar.
    arcs : sequence of Arc
        Arcs of all stations.
    half_aperture : float
        Of the sensors [rad].
    settings : SearchSettings
        When a reflector is believed.
    """

    def __init__(
        self, explanation: Explanation, arcs: Sequence[Arc], *, half_aperture: float, settings: SearchSettings
    ) -> None:
        self.explanation = explanation
        self.arcs = list(arcs)
        self.settings = settings
        self.belief = Belief(explanation.soundings, half_aperture=half_aperture, settings=settings)

    @cached_property
    def _few(self) -> BoolArray:
        return independent(self.explanation.soundings)

    @cached_property
    def _rough(self) -> Explanation:
        """A few of the pings, each of which counts for more; whoever only judges needs none of it."""
        few = chosen_soundings(self.explanation.soundings, self._few)
        few = few._replace(weights=few.weights * (len(self._few) / max(len(few.weights), 1)))
        return Explanation(few, self.explanation.hearing, max(0.012, 2 * self.explanation.noise))

    def run(self, known: Sequence[Hypothesis] = ()) -> list[Hypothesis]:
        """Find the features.

        Parameters
        ----------
        known : sequence of Hypothesis, optional
            Features to start from; those that do not stand up are dropped.

        Returns
        -------
        list of Hypothesis
            The features, in the order in which they were found.
        """
        features = self.tested(self._renewed(known))
        for _ in range(self.settings.rounds):
            pool = self._seeded(features)
            grown = without_joining(self.explanation, self._grown(features, pool), self.belief)
            if [each.key for each in grown] == [each.key for each in features]:
                return grown
            features = grown
        return features

    def more(self, features: Sequence[Hypothesis], kinds: Collection[Kind]) -> list[Hypothesis]:
        """Find more features of some kinds, and no others.

        Parameters
        ----------
        features : sequence of Hypothesis
            Those that are known.
        kinds : collection of Kind
            What to find.

        Returns
        -------
        list of Hypothesis
            Those that are known, as far as they stand up, and the others.
        """
        pool = [each for each in self._seeded(features) if each.kind in kinds]
        return self._grown(list(features), pool)

    def tested(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Hold each feature against all others, and drop those that do not stand up.

        Parameters
        ----------
        features : sequence of Hypothesis
            The features.

        Returns
        -------
        list of Hypothesis
            Those that stay, judged beside each other.
        """
        kept, place = list(features), 0
        without = self.explanation.levels_without(kept)
        while place < len(kept):
            feature, others = kept[place], [*kept[:place], *kept[place + 1 :]]
            judged = self.explanation.judged(feature, without[place], others)
            refusal = self.belief.refusal(judged, without[place])
            holds = refusal is None
            if refusal:
                record_event(Decision.REMOVED, judged, reason=refusal, threshold=self.settings.accept)
            kept = [*kept[:place], judged, *kept[place + 1 :]] if holds else others
            place += holds
            if not holds or judged.casts_otherwise_than(feature):
                without = self.explanation.levels_without(kept)
        return kept

    def judged(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Judge features beside each other with fresh evidence, and keep them all.

        Parameters
        ----------
        features : sequence of Hypothesis
            The features, perhaps moved since they were judged.

        Returns
        -------
        list of Hypothesis
            The same features with their gains.
        """
        return self._beside_others(self._renewed(features))[0]

    def settled(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Drop the weakest of the features that do not stand up, until all do.

        Parameters
        ----------
        features : sequence of Hypothesis
            The features, perhaps moved since they were judged.

        Returns
        -------
        list of Hypothesis
            Those that stay, with fresh evidence.
        """
        kept = self._renewed(features)
        while True:
            judged, refusals = self._beside_others(kept)
            fallen = [(each, refusal) for each, refusal in zip(judged, refusals, strict=True) if refusal]
            if not fallen:
                return judged
            weakest, refusal = min(fallen, key=lambda each: each[0].total)
            record_event(Decision.REMOVED, weakest, reason=refusal, threshold=self.settings.accept)
            kept = [each for each in judged if each is not weakest]

    def _beside_others(self, features: Sequence[Hypothesis]) -> tuple[list[Hypothesis], list[Reason | None]]:
        judged, refusals = [], []
        for place, levels in enumerate(self.explanation.levels_without(features)):
            others = _others(features, place)
            left = levels if len(others) == len(features) - 1 else self.explanation.levels(others)
            judged.append(self.explanation.judged(features[place], left, others))
            refusals.append(self.belief.refusal(judged[-1], left))
        return judged, refusals

    def _renewed(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Collect the evidence anew: pings, noise or the sonar may have changed."""
        fresh = [
            replace(self.explanation.propose(each.reflector), past=each.past, is_square=each.is_square)
            for each in features
        ]
        bare = np.full(len(self.explanation.soundings.readings), self.explanation.floor)
        return self.explanation.judge_all(fresh, bare, [])

    def _grown(self, features: list[Hypothesis], pool: list[Hypothesis]) -> list[Hypothesis]:
        """Accept the best of a pool, again and again."""
        explanation, accepted = self.explanation, list[Hypothesis]()
        levels = explanation.levels(features)
        while pool:
            scored = sorted(explanation.judge_all(pool, levels, features), key=self.belief.worth, reverse=True)
            pool = [each for each in scored if self.belief.worth(each) > 0.0]
            contenders = scored[: self.settings.contenders]
            best = self._best(contenders, levels, features)
            if self.belief.worth(best) <= self.settings.accept:
                return features
            # What was accepted and fell would fall again: two rivals may take each other's place for ever.
            if self._is_rejected(best, levels) or any(_same(best, each) for each in accepted):
                pool = self._without_fallen(pool, contenders, levels)
                continue
            accepted.append(best)
            record_event(Decision.ADDED, best, reason=Reason.EVIDENCE, threshold=self.settings.accept)
            pool = [each for each in pool if not _same(each, best)]
            features = self.tested([*features, best])
            levels = explanation.levels(features)
        return features

    def _is_rejected(self, hypothesis: Hypothesis, levels: FloatArray) -> bool:
        refusal = self.belief.refusal(hypothesis, levels)
        if refusal:
            record_event(Decision.REJECTED, hypothesis, reason=refusal, threshold=self.settings.accept)
        return refusal is not None

    def _without_fallen(
        self, pool: Sequence[Hypothesis], contenders: Sequence[Hypothesis], levels: FloatArray
    ) -> list[Hypothesis]:
        """Leave out the contenders that are not believed, and the first of them at any rate."""
        fallen = [contenders[0], *(each for each in contenders if not self.belief.holds(each, levels))]
        return [each for each in pool if not any(each is other for other in fallen)]

    def _best(self, contenders: Sequence[Hypothesis], levels: FloatArray, features: Sequence[Hypothesis]) -> Hypothesis:
        """Refine the best few once more on the pings that are still open, and return the best of them."""
        best = self.belief.worth(contenders[0])
        near = [each for each in contenders if self.belief.worth(each) >= min(best, 0.8 * best)]
        refined = [self._polished(each, levels, features) for each in near]
        return max([*near, *refined], key=self.belief.worth)

    def _polished(self, hypothesis: Hypothesis, levels: FloatArray, features: Sequence[Hypothesis]) -> Hypothesis:
        explanation, noise = self.explanation, self.explanation.noise
        speaking = (hypothesis.gains > 0.0)[explanation.soundings.stations]
        free = np.flatnonzero((levels < explanation.floor + _OPEN) & speaking)
        courses = [[(noise, max(0.02, 4 * noise), 3)]]
        if (hypothesis.gains > self.settings.second_station).sum() < _SURE_STATIONS:
            # Where few stations speak, the first guess may be farther off than readings scatter.
            courses.append([(4 * noise, max(0.03, 16 * noise), 3), *courses[0]])
        proposed = [explanation.propose(self._moved(hypothesis.reflector, free, course)) for course in courses]
        return max(explanation.judge_all(proposed, levels, features), key=self.belief.worth)

    def _moved(self, reflector: FloatArray, pings: IntArray, course: Course) -> FloatArray:
        return approach(self.explanation.soundings, self.explanation.hearing, reflector, pings, course)

    def _seeded(self, features: Sequence[Hypothesis]) -> list[Hypothesis]:
        """Let arcs that are mostly unexplained suggest reflectors."""
        explanation = self.explanation
        levels = explanation.levels(features)
        open_readings = levels < explanation.floor + _UNEXPLAINED
        arcs = [arc for arc in self.arcs if arc.share_of(open_readings) > 0.5]
        if not arcs:
            return []
        stations = np.array([arc.station for arc in arcs])
        sightings = Sightings(
            stations=stations,
            centers=explanation.soundings.centers[stations],
            planes=arc_planes(arcs, explanation.soundings, explanation.hearing),
        )
        fresh: BoolArray = np.ones(len(arcs), dtype=bool)
        rows = suggest(sightings, fresh, self.settings.candidates)
        free = np.flatnonzero(levels < explanation.floor + _OPEN)
        pool = [each for kind in _CELLS for each in self._promising(kind, rows, levels, free)]
        return [each for each in pool if not any(_same(each, feature) for feature in features)]

    def _promising(self, kind: Kind, rows: FloatArray, levels: FloatArray, free: IntArray) -> list[Hypothesis]:
        """Screen candidates of one kind, move the best of them to where the pings want them, and keep those apart."""
        explanation, noise = self.explanation, self.explanation.noise
        judged = self._screened(rows[rows[:, 0] == kind], levels)
        rough, fine = ((max(0.008, 1.5 * noise), 0.03, 4),), ((noise, 0.02, 3),)
        few = free[self._few[free]]
        moved = [self._moved(each.reflector, few, rough) for each in judged[: self.settings.most] if each.total > 2.0]
        moved = [self._moved(row, free, fine) for row in _apart(np.array(moved).reshape(-1, 4), _CELLS[kind])]
        apart = _apart(np.array(moved).reshape(-1, 4), _CELLS[kind])
        if kind is Kind.CORNER:
            edges = [self._moved(np.array([Kind.EDGE, *row[1:]]), free, fine) for row in apart]
            # What returns in a concave corner is sound; rays read the walls there.
            corners = apart[:0] if explanation.hearing.cone else apart
            apart = np.concatenate([corners, np.array(edges).reshape(-1, 4)])
        return [explanation.propose(row) for row in apart]

    def _screened(self, rows: FloatArray, levels: FloatArray) -> list[Hypothesis]:
        """Rank candidates by a few of the pings, the best first."""
        judged = self._rough.judge_all([self._rough.propose(row) for row in rows], levels[self._few], [])
        return sorted(judged, key=lambda each: each.total, reverse=True)


def _others(features: Sequence[Hypothesis], place: int) -> list[Hypothesis]:
    """List what a feature is judged beside: two that came to lie on each other would leave each other nothing to say.

    So the stronger of them, or of equals the first, is judged as if the other were not there.
    """
    feature = features[place]
    return [
        each
        for number, each in enumerate(features)
        if number != place and ((each.total, place) > (feature.total, number) or not _same(each, feature))
    ]


def _same(one: Hypothesis, other: Hypothesis) -> bool:
    if one.reflector[0] != other.reflector[0]:
        return False
    if not one.is_wall:
        apart = one.reflector[1:] - other.reflector[1:]
        return bool(np.hypot(apart[0], apart[1]) < 0.02 and abs(apart[2]) < 0.03)
    return are_copies(one, other, _SAME_WALL)


def _apart(rows: FloatArray, cell: tuple[float, float, float]) -> FloatArray:
    if not len(rows):
        return rows
    _, first = np.unique(np.round(rows[:, 1:] / cell).astype(np.int64), axis=0, return_index=True)
    return rows[np.sort(first)]
