"""Scores: what a method reached on all recordings together."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from math import nan

import numpy as np

from echoplan.comparison.trials import Outcome
from echoplan.evaluation import ErrorSummary, GridScore, pool, pool_grid_scores

__all__ = ["MethodScore", "score_methods"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class MethodScore:
    """What a method reached on all recordings together.

    Parameters
    ----------
    method : str
        Name of the method.
    outcomes : tuple of Outcome
        Its trials, failed ones too.
    summary : ErrorSummary or None
        Its evaluations pooled; None if there is none.
    """

    method: str
    outcomes: tuple[Outcome, ...]
    summary: ErrorSummary | None

    @property
    def maps(self) -> int:
        """How many of its trials gave a map."""
        return sum(outcome.feature_map is not None for outcome in self.outcomes)

    @property
    def grid_score(self) -> GridScore | None:
        """Its grids against the truth, cell by cell; None if it drew none that could be scored."""
        grids = [outcome.grid_score for outcome in self.outcomes if outcome.grid_score is not None]
        return pool_grid_scores(grids) if grids else None

    @property
    def seconds_per_thousand_pings(self) -> float:
        """Processor time for a thousand pings over all maps [s]; nan if there is none."""
        mapped = [outcome for outcome in self.outcomes if outcome.feature_map is not None]
        pings = sum(outcome.trial.subject.pings for outcome in mapped)
        return 1000 * sum(outcome.seconds for outcome in mapped) / pings if pings else nan

    @property
    def peak_memory(self) -> float:
        """Greatest peak memory of all trials [bytes]; nan if none is known."""
        return max((each.peak_memory for each in self.outcomes if each.peak_memory > 0), default=nan)


def score_methods(outcomes: Iterable[Outcome], methods: Sequence[str]) -> tuple[MethodScore, ...]:
    """Pool outcomes by method.

    Parameters
    ----------
    outcomes : iterable of Outcome
        Of all trials, in any order.
    methods : sequence of str
        The methods in the order wanted.

    Returns
    -------
    tuple of MethodScore
        One a method; deviations and shares are pooled over objects, map errors over recordings.
    """
    every = list(outcomes)
    return tuple(_score(name, tuple(each for each in every if each.trial.method == name)) for name in methods)


def _score(method: str, outcomes: tuple[Outcome, ...]) -> MethodScore:
    evaluations = [outcome.evaluation for outcome in outcomes if outcome.evaluation is not None]
    # The same draws for every method: every run of the comparison gives the same intervals.
    summary = pool(evaluations, rng=np.random.default_rng(0)) if evaluations else None
    return MethodScore(method=method, outcomes=outcomes, summary=summary)
