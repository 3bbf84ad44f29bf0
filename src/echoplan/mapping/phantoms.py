"""Phantoms: walls that may be no more than echoes over two walls, one of which nobody heard itself.

What one sensor sends to a known wall and another hears from an unknown one looks, from one station, like a wall beyond.
Two things tell it: sound that met two walls comes from farther than either, and seldom does it leave and come back just
along the axes of both beams, so that it is heard over a smaller angle than a wall is.
"""

import math
from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classification.explanation import Explanation
from echoplan.classification.hypotheses import Hypothesis
from echoplan.classification.multipath import STRETCH
from echoplan.geometry import along, signed_distances
from echoplan.mapping.belief import Belief
from echoplan.preprocessing.soundings import Soundings

__all__ = ["without_phantoms"]

# From fewer stations many a wall is heard from one of them only.
_FEWEST = 3
# From a wall at right angles on to another that is as near, and back: half of two sides and the diagonal of a square.
_OVER_TWO_WALLS = 1.0 + math.sqrt(0.5)


def without_phantoms(explanation: Explanation, features: Sequence[Hypothesis], belief: Belief) -> list[Hypothesis]:
    """Leave out walls of one station that others may have cast.

    Parameters
    ----------
    explanation : Explanation
        The pings.
    features : sequence of Hypothesis
        The features, judged beside each other.
    belief : Belief
        How fully a wall must be heard.

    Returns
    -------
    list of Hypothesis
        The others.
    """
    walls, soundings = [each for each in features if each.is_wall], explanation.soundings
    if not walls or len(soundings.centers) < _FEWEST or not _has_volleys(soundings):
        return list(features)
    bare = np.zeros(len(soundings.readings))
    least = belief.settings.usual_share * float(np.median([belief.hears(each, bare) for each in walls]))
    return [
        each
        for each, levels in zip(features, explanation.levels_without(features), strict=True)
        if not (_may_be_cast(each, walls, soundings, belief) and belief.hears(each, levels) < least)
    ]


def _has_volleys(soundings: Soundings) -> bool:
    """Whether sensors fire together."""
    return bool(((soundings.mates >= 0) & (soundings.lags == 0.0)).any())


def _may_be_cast(feature: Hypothesis, walls: Sequence[Hypothesis], soundings: Soundings, belief: Belief) -> bool:
    """Whether a wall of one station stands so far off that sound may have met two walls on its way."""
    if not feature.is_wall or feature.is_known or not belief.is_lone(feature):
        return False
    center_xy = soundings.centers[np.argmax(feature.gains)]
    nearest = np.sort(_distances([each for each in walls if each is not feature], center_xy))[:2]
    return len(nearest) > 1 and abs(float(signed_distances(feature.line, center_xy))) > _OVER_TWO_WALLS * nearest[1]


def _distances(walls: Sequence[Hypothesis], point_xy: FloatArray) -> FloatArray:
    """How far walls are from a point, as far as they may reflect [m]."""
    lines = np.array([each.line for each in walls]).reshape(-1, 2)
    ends = np.array([each.extent for each in walls]).reshape(-1, 2)
    place = along(lines, point_xy)
    beyond = np.maximum(0.0, np.maximum(ends[:, 0] - place, place - ends[:, 1]) - STRETCH)
    distances: FloatArray = np.hypot(signed_distances(lines, point_xy), beyond)
    return distances
