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
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import UNHEARD
from echoplan.joint.search.acceptance import AcceptanceTest
from echoplan.joint.search.latent_walls import log_densities_over_latent_walls
from echoplan.joint.trace import Decision, Reason, record_event
from echoplan.preprocessing.measurements import Measurements

__all__ = ["without_multipath_walls"]

# From fewer stations many a wall is heard from one of them only.
_FEWEST = 3
# What more stations speak for no echo over an unknown wall explains by chance.
_FEW_STATIONS = 3


def without_multipath_walls(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Leave out walls of few stations that others may have cast.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    features : sequence of Hypothesis
        The features, judged beside each other.
    acceptance : AcceptanceTest
        How fully a wall must be heard.

    Returns
    -------
    list of Hypothesis
        The others.
    """
    measurements = likelihood.measurements
    if len(measurements.centers) < _FEWEST:
        return list(features)
    if likelihood.hearing.cone:
        for each in features:
            if _is_lone_wall(each, acceptance):
                record_event(Decision.REMOVED, each, reason=Reason.SINGLE_STATION)
        return [each for each in features if not _is_lone_wall(each, acceptance)]
    kept = _without_unheard(likelihood, features, acceptance)
    return _without_cast(likelihood, kept, acceptance) if _has_volleys(measurements) else kept


def _is_lone_wall(feature: Hypothesis, acceptance: AcceptanceTest) -> bool:
    return feature.is_wall and not feature.is_known and acceptance.has_single_station(feature)


def _without_unheard(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Leave out walls, the weakest first, that are not believed beside an echo over one that nobody heard."""
    kept = list(features)
    for feature in sorted(features, key=lambda each: each.total):
        others = [each for each in kept if each is not feature]
        if _is_weak(feature, acceptance) and not _stands_beside_unheard(likelihood, feature, others, acceptance):
            record_event(Decision.REMOVED, feature, reason=Reason.MULTIPATH)
            kept = others
    return kept


def _is_weak(feature: Hypothesis, acceptance: AcceptanceTest) -> bool:
    supporting = feature.supporting(acceptance.settings.second_station)
    return feature.is_wall and not feature.is_known and supporting <= _FEW_STATIONS


def _stands_beside_unheard(
    likelihood: PingLikelihood, wall: Hypothesis, others: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> bool:
    log_densities = likelihood.log_densities(others)
    rescored = likelihood.rescored(wall, log_densities, others)
    echoes = log_densities_over_latent_walls(likelihood, rescored, others, log_densities)
    if echoes.max() == UNHEARD:
        return True
    beside = likelihood.rescored(wall, np.maximum(log_densities, echoes), others)
    return beside.total > acceptance.settings.second_station


def _without_cast(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Leave out walls that one sensor may have heard of what another sent."""
    walls = [each for each in features if each.is_wall]
    shares = [
        acceptance.detection_rate(*each)
        for each in zip(features, likelihood.log_densities_without(features), strict=True)
    ]
    least = acceptance.settings.usual_share * _usual(features, shares)
    kept = []
    for each, share in zip(features, shares, strict=True):
        if share >= least or not _may_be_cast(each, walls, likelihood.measurements, acceptance):
            kept.append(each)
        else:
            record_event(Decision.REMOVED, each, reason=Reason.MULTIPATH)
    return kept


def _usual(features: Sequence[Hypothesis], shares: Sequence[float]) -> float:
    """Tell how fully walls are heard in the median; 0 where none is heard."""
    detected = [share for each, share in zip(features, shares, strict=True) if each.is_wall and each.best > 0.0]
    return float(np.median(detected)) if detected else 0.0


def _has_volleys(measurements: Measurements) -> bool:
    """Whether sensors fire together."""
    return bool(((measurements.crosstalk_sources >= 0) & (measurements.lags == 0.0)).any())


def _may_be_cast(
    feature: Hypothesis, walls: Sequence[Hypothesis], measurements: Measurements, acceptance: AcceptanceTest
) -> bool:
    """Whether a wall of one station is as far off as the image of a station in two walls, or farther.

    In two walls at right angles it is as far as where they meet: the root of the sum of the squares of their distances.
    """
    if not _is_lone_wall(feature, acceptance):
        return False
    center_xy = measurements.centers[np.argmax(feature.llr_by_station)]
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
