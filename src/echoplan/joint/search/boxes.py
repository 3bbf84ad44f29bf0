"""Boxes: edges and walls that ray cones read like one cylinder among them.

Edges hardly return sound, but they stop rays. From several stations, the edges of a small box are about where a
cylinder of its size would be, with fewer parameters. But readings of each edge from several stations meet in one point
and those of each wall touch one line, while few of them touch the cylinder.
"""

from collections.abc import Sequence

from echoplan.acoustics.predicted_echo import Kind
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.search.search import Search
from echoplan.joint.trace import Decision, Reason, record_event

__all__ = ["with_boxes"]


def with_boxes(search: Search, features: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Replace cylinders by edges and walls where these explain ray cones better; without ray cones, change nothing."""
    kept = list(features)
    if search.likelihood.tables.cone:
        for feature in features:
            if feature.kind is Kind.CYLINDER and not feature.is_known:
                others = [each for each in kept if each is not feature]
                instead = _instead(search, feature, others)
                if instead:
                    record_event(Decision.CHANGED, feature, reason=Reason.BETTER_CLASS, becomes=instead[0].kind)
                kept = [*others, *(instead or [feature])]
    return kept


def _instead(search: Search, cylinder: Hypothesis, others: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return the edges and walls that explain more than a cylinder; an empty list if there are none."""
    known = {each.key for each in others}
    found = [each for each in search.more(others, (Kind.EDGE, Kind.WALL)) if each.key not in known]
    penalised_llr = sum(each.llr for each in found) - search.acceptance.settings.min_log_likelihood_ratio * (
        len(found) - 1
    )
    return found if found and penalised_llr > search.acceptance.penalised_llr(cylinder) else []
