"""Phantoms: walls that may be no more than echoes over two walls, one of which nobody heard itself.

What a corner sends back over a known side and an unknown one looks like a wall across it; but then there is an unknown
side that explains the echo as well.  What one sensor sends to a known wall and another hears from an unknown one looks,
from one station, like a wall beyond.  Two things tell it: sound that met two walls comes from farther than either, and
seldom does it leave and come back just along the axes of both beams, so that it is heard over a smaller angle than a
wall is.  Of the wall that nobody heard nothing is known; it is taken to stand about as near as those that were heard.
Rays meet no second wall; but an edge, which returns hardly any sound, is read by them from one station as a wall across
it would be.
"""

import math
from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import along, signed_distances
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.multipath import STRETCH
from echoplan.joint.likelihood.ping_likelihood import Explanation
from echoplan.joint.likelihood.ping_scores import UNHEARD
from echoplan.joint.search.acceptance import Belief
from echoplan.joint.search.latent_walls import levels_over_unheard
from echoplan.joint.trace import Decision, Reason, record_event
from echoplan.preprocessing.ping_arrays import Soundings

__all__ = ["without_phantoms"]

# From fewer stations many a wall is heard from one of them only.
_FEWEST = 3
# What more stations speak for no echo over an unknown wall explains by chance.
_FEW_STATIONS = 3


def without_phantoms(explanation: Explanation, features: Sequence[Hypothesis], belief: Belief) -> list[Hypothesis]:
    """Leave out walls of few stations that others may have cast.

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
    soundings = explanation.soundings
    if len(soundings.centers) < _FEWEST:
        return list(features)
    if explanation.hearing.cone:
        for each in features:
            if _is_lone_wall(each, belief):
                record_event(Decision.REMOVED, each, reason=Reason.SINGLE_STATION)
        return [each for each in features if not _is_lone_wall(each, belief)]
    kept = _without_unheard(explanation, features, belief)
    return _without_cast(explanation, kept, belief) if _has_volleys(soundings) else kept


def _is_lone_wall(feature: Hypothesis, belief: Belief) -> bool:
    return feature.is_wall and not feature.is_known and belief.is_lone(feature)


def _without_unheard(explanation: Explanation, features: Sequence[Hypothesis], belief: Belief) -> list[Hypothesis]:
    """Leave out walls, the weakest first, that are not believed beside an echo over one that nobody heard."""
    kept = list(features)
    for feature in sorted(features, key=lambda each: each.total):
        others = [each for each in kept if each is not feature]
        if _is_weak(feature, belief) and not _stands_beside_unheard(explanation, feature, others, belief):
            record_event(Decision.REMOVED, feature, reason=Reason.MULTIPATH)
            kept = others
    return kept


def _is_weak(feature: Hypothesis, belief: Belief) -> bool:
    speaking = feature.speaking(belief.settings.second_station)
    return feature.is_wall and not feature.is_known and speaking <= _FEW_STATIONS


def _stands_beside_unheard(
    explanation: Explanation, wall: Hypothesis, others: Sequence[Hypothesis], belief: Belief
) -> bool:
    levels = explanation.levels(others)
    judged = explanation.judged(wall, levels, others)
    echoes = levels_over_unheard(explanation, judged, others, levels)
    if echoes.max() == UNHEARD:
        return True
    beside = explanation.judged(wall, np.maximum(levels, echoes), others)
    return beside.total > belief.settings.second_station


def _without_cast(explanation: Explanation, features: Sequence[Hypothesis], belief: Belief) -> list[Hypothesis]:
    """Leave out walls that one sensor may have heard of what another sent."""
    walls = [each for each in features if each.is_wall]
    shares = [belief.hears(*each) for each in zip(features, explanation.levels_without(features), strict=True)]
    least = belief.settings.usual_share * _usual(features, shares)
    kept = []
    for each, share in zip(features, shares, strict=True):
        if share >= least or not _may_be_cast(each, walls, explanation.soundings, belief):
            kept.append(each)
        else:
            record_event(Decision.REMOVED, each, reason=Reason.MULTIPATH)
    return kept


def _usual(features: Sequence[Hypothesis], shares: Sequence[float]) -> float:
    """Tell how fully walls are heard in the median; 0 where none is heard."""
    heard = [share for each, share in zip(features, shares, strict=True) if each.is_wall and each.best > 0.0]
    return float(np.median(heard)) if heard else 0.0


def _has_volleys(soundings: Soundings) -> bool:
    """Whether sensors fire together."""
    return bool(((soundings.mates >= 0) & (soundings.lags == 0.0)).any())


def _may_be_cast(feature: Hypothesis, walls: Sequence[Hypothesis], soundings: Soundings, belief: Belief) -> bool:
    """Whether a wall of one station is as far off as the image of a station in two walls, or farther.

    In two walls at right angles it is as far as where they meet: the root of the sum of the squares of their distances.
    """
    if not _is_lone_wall(feature, belief):
        return False
    center_xy = soundings.centers[np.argmax(feature.gains)]
    nearest = np.sort(_distances([each for each in walls if each is not feature], center_xy))[:2]
    return len(nearest) > 1 and -float(signed_distances(feature.line, center_xy)) > math.hypot(*nearest)


def _distances(walls: Sequence[Hypothesis], point_xy: FloatArray) -> FloatArray:
    """How far the walls before which a point lies are from it, as far as they may reflect [m]."""
    lines = np.array([each.line for each in walls]).reshape(-1, 2)
    ends = np.array([each.extent for each in walls]).reshape(-1, 2)
    place, depths = along(lines, point_xy), -signed_distances(lines, point_xy)
    beyond = np.maximum(0.0, np.maximum(ends[:, 0] - place, place - ends[:, 1]) - STRETCH)
    distances: FloatArray = np.hypot(depths, beyond)[depths > 0.0]
    return distances
