"""Reclassification: features that were taken for something else when not all others were known."""

from collections.abc import Sequence

import numpy as np

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.classification.explanation import Explanation
from echoplan.classification.hypotheses import Hypothesis
from echoplan.mapping.belief import Belief
from echoplan.mapping.refinement import approach
from echoplan.mapping.rivals import rivals_of

__all__ = ["reclassified", "without_joining"]

# What is known from no more stations may be as many walls.
_FEW_STATIONS = 3
# What may seem to join them.
_JOINING = (Kind.CYLINDER, Kind.WALL)


def reclassified(explanation: Explanation, features: Sequence[Hypothesis], belief: Belief) -> list[Hypothesis]:
    """Take walls for what explains their pings best: of poses in error walls bear most, and come before cylinders.

    Corners may turn out to be walls, but no cylinders: what stands in a corner hides in it.

    Parameters
    ----------
    explanation : Explanation
        The pings.
    features : sequence of Hypothesis
        The features, judged beside each other.
    belief : Belief
        When a rival is believed.

    Returns
    -------
    list of Hypothesis
        As many, some of them of another kind.
    """
    kept = list(features)
    for place, feature in enumerate(features):
        if feature.is_known or feature.kind is Kind.CYLINDER:
            continue
        others = [*kept[:place], *kept[place + 1 :]]
        kinds = tuple(Kind) if feature.is_wall else (Kind.WALL,)
        best = max(rivals_of(explanation, feature, others, kinds), key=belief.worth)
        if belief.worth(best) > belief.worth(feature) and belief.holds(best, explanation.levels(others)):
            kept[place] = best
    return kept


def without_joining(explanation: Explanation, features: list[Hypothesis], belief: Belief) -> list[Hypothesis]:
    """Replace features by walls, one for each of few stations, where these explain the pings better.

    Any two walls that were heard from one station each have a cylinder that touches both, and it needs fewer
    parameters; but it would be heard less loud, and so over a narrower angle.  Sides of two boxes that stand nearly in
    line look like one wall, though each of them by itself says a little otherwise.

    Parameters
    ----------
    explanation : Explanation
        The pings.
    features : list of Hypothesis
        The features, judged beside each other.
    belief : Belief
        When a wall is believed.

    Returns
    -------
    list of Hypothesis
        The features, some of them replaced.
    """
    for feature in features:
        stations = np.flatnonzero(feature.gains > belief.settings.second_station)
        if _may_join(feature, stations):
            others = [each for each in features if each is not feature]
            walls = _walls_instead(explanation, feature, stations, others, belief=belief)
            if _explain_more(walls, feature, belief.settings.accept):
                features = [*others, *walls]
    return features


def _may_join(feature: Hypothesis, stations: IntArray) -> bool:
    few = 1 + feature.is_wall <= len(stations) <= _FEW_STATIONS
    return few and feature.kind in _JOINING and not feature.is_known


def _explain_more(walls: Sequence[Hypothesis], joining: Hypothesis, accept: float) -> bool:
    """Whether walls explain more than what joins them: two parameters each, as one wall has; a cylinder has three."""
    if joining.is_wall and len(walls) < 2:
        return False
    cost = accept * (len(walls) - 1) if joining.is_wall else 0.0
    return sum(each.total for each in walls) > joining.total + cost


def _walls_instead(
    explanation: Explanation,
    joining: Hypothesis,
    stations: IntArray,
    others: Sequence[Hypothesis],
    *,
    belief: Belief,
) -> list[Hypothesis]:
    walls, soundings = list[Hypothesis](), explanation.soundings
    course = ((4 * explanation.noise, 0.06, 4), (explanation.noise, 0.03, 4))
    for station in stations:
        levels = explanation.levels([*others, *walls])
        pings = joining.evidence.pings[joining.evidence.densities > levels[joining.evidence.pings]]
        own = pings[soundings.stations[pings] == station]
        start = joining.reflector if joining.is_wall else _touching(joining, soundings.centers[station])
        wall = explanation.propose(approach(soundings, explanation.hearing, start, own, course))
        wall = explanation.judged(wall, levels, [*others, *walls])
        if belief.holds(wall, levels):
            walls.append(wall)
    return walls


def _touching(cylinder: Hypothesis, center_xy: FloatArray) -> FloatArray:
    """Make a wall that touches a cylinder where a station hears it."""
    away = cylinder.reflector[1:3] - center_xy
    normal = away / np.hypot(*away)
    touched = cylinder.reflector[1:3] - cylinder.reflector[3] * normal
    return np.array([Kind.WALL, np.arctan2(normal[1], normal[0]), touched @ normal, 0.0])
