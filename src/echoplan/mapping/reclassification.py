"""Reclassification: features that were taken for something else when not all others were known."""

from collections.abc import Sequence

import numpy as np

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import IntArray
from echoplan.classification.explanation import Explanation
from echoplan.classification.hypotheses import Hypothesis
from echoplan.mapping.belief import Belief
from echoplan.mapping.refinement import approach
from echoplan.mapping.rivals import rivals_of

__all__ = ["reclassified", "without_joining"]

# A cylinder known from no more stations may be as many walls.
_FEW_STATIONS = 3


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
    """Replace cylinders by walls, one for each of few stations, where these explain the pings better.

    Any two walls that were heard from one station each have a cylinder that touches both, and it needs fewer
    parameters; but it would be heard less loud, and so over a narrower angle.

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
        The features, some cylinders among them replaced.
    """
    for feature in features:
        stations = np.flatnonzero(feature.gains > belief.settings.second_station)
        if feature.kind is Kind.CYLINDER and not feature.is_known and len(stations) <= _FEW_STATIONS:
            others = [each for each in features if each is not feature]
            walls = _walls_instead(explanation, feature, stations, others, belief=belief)
            if sum(each.total for each in walls) > feature.total:
                features = [*others, *walls]
    return features


def _walls_instead(
    explanation: Explanation,
    cylinder: Hypothesis,
    stations: IntArray,
    others: Sequence[Hypothesis],
    *,
    belief: Belief,
) -> list[Hypothesis]:
    walls, soundings = list[Hypothesis](), explanation.soundings
    course = ((4 * explanation.noise, 0.06, 4), (explanation.noise, 0.03, 4))
    for station in stations:
        levels = explanation.levels([*others, *walls])
        pings = cylinder.evidence.pings[cylinder.evidence.densities > levels[cylinder.evidence.pings]]
        own = pings[soundings.stations[pings] == station]
        away = cylinder.reflector[1:3] - soundings.centers[station]
        normal = away / np.hypot(*away)
        touched = cylinder.reflector[1:3] - cylinder.reflector[3] * normal
        start = np.array([Kind.WALL, np.arctan2(normal[1], normal[0]), touched @ normal, 0.0])
        wall = explanation.propose(approach(soundings, explanation.hearing, start, own, course))
        wall = explanation.judged(wall, levels, [*others, *walls])
        if belief.holds(wall, levels):
            walls.append(wall)
    return walls
