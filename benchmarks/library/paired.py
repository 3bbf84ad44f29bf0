"""Two versions of the estimator on the same recordings: which measures became worse beyond their tolerance."""

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import numpy as np

from echoplan.evaluation import Evaluation
from echoplan.evaluation.consistency import PARAMETERS, pool_consistency
from echoplan.evaluation.tally import Tally
from echoplan.model import FeatureClass, Table

__all__ = ["Scores", "compare"]

# What a version may be worse by: objects lost or wrong, of all; error; share of truths in 95 % ellipses; CPU time.
LOST, ERROR, INSIDE, TIME = 1 / 200, 0.05, 0.015, 0.20


@dataclass(frozen=True, slots=True, kw_only=True)
class Scores:
    """The maps of one version: their evaluations, in the order of the recordings, and CPU time [s]."""

    evaluations: Sequence[Evaluation]
    seconds: float


@dataclass(frozen=True, slots=True, kw_only=True)
class _Measure:
    """One number of both versions, and how much worse the second one may be."""

    name: str
    before: float
    after: float
    worst: float

    @property
    def is_worse(self) -> bool:
        sign = 1.0 if self.worst >= self.before else -1.0
        return sign * self.after > sign * self.worst


def compare(title: str, before: Scores, after: Scores) -> tuple[Table, list[str]]:
    """Compare the maps of two versions: a table, and the names of the measures that became worse."""
    measures = [
        *(each for name in FeatureClass for each in _of_class(name, before, after)),
        _Measure(name="CPU time [s]", before=before.seconds, after=after.seconds, worst=(1.0 + TIME) * before.seconds),
    ]
    rows = [
        (each.name, f"{each.before:.4g}", f"{each.after:.4g}", f"{each.worst:.4g}", "worse" if each.is_worse else "")
        for each in measures
        if not np.isnan(each.before)
    ]
    table = Table(title=title, columns=("measure", "before", "after", "at worst", ""), rows=tuple(rows))
    return table, [each.name for each in measures if each.is_worse]


def _of_class(name: FeatureClass, before: Scores, after: Scores) -> list[_Measure]:
    found = []
    old_shares, new_shares = (_shares(name, each.evaluations) for each in (before, after))
    for what, tolerance in (("recall", LOST), ("precision", LOST), ("inside 95 %", INSIDE)):
        old, new = old_shares[what], new_shares[what]
        found.append(_Measure(name=f"{name} {what}", before=old, after=new, worst=old - tolerance))
    for what, share in (("median", 0.5), ("95th percentile", 0.95)):
        old, new = (_error(name, each.evaluations, share) for each in (before, after))
        found.append(_Measure(name=f"{name} {what} [mm]", before=old, after=new, worst=(1.0 + ERROR) * old))
    return found


def _shares(name: FeatureClass, evaluations: Sequence[Evaluation]) -> dict[str, float]:
    tally = sum((each.matches.by_class[name].tally for each in evaluations), Tally())
    consistency = pool_consistency([each.consistency[name] for each in evaluations], parameters=PARAMETERS[name])
    return {"recall": tally.recall, "precision": tally.precision, "inside 95 %": consistency.share_inside}


def _error(name: FeatureClass, evaluations: Sequence[Evaluation], share: float) -> float:
    errors = [1000.0 * match.distance for each in evaluations for match in each.matches.by_class[name].right]
    return float(np.quantile(errors, share)) if errors else nan
