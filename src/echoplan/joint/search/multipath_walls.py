"""Rejection of walls that may be multipath over a latent wall.

An echo over a known and a latent wall of a corner looks like a wall across it; but then the latent wall explains the
echo as well. Crosstalk from one sensor over a known wall and a latent wall to another sensor looks, from one station,
like a wall farther away. It differs from a wall in two ways: a path over two walls is longer than that to either, and
it seldom leaves and arrives along both beam axes, so it is detected over a smaller angle. Nothing is known of the
latent wall; it is assumed to be about as near as the walls that were detected. Rays have no second reflection; but an
edge, which hardly returns sound, is read by rays from one station like a wall across it.
"""

import math
from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import along, signed_distances
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.multipath import STRETCH
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.joint.search.acceptance import AcceptanceTest
from echoplan.joint.search.latent_walls import log_densities_over_latent_walls
from echoplan.joint.trace import Decision, Reason, record_event
from echoplan.preprocessing.measurements import Measurements

__all__ = ["without_multipath_walls"]

# With fewer stations, many walls are detected from only one of them.
_FEWEST = 3
# A wall of more supporting stations is not explained by multipath over a latent wall by chance.
_FEW_STATIONS = 3


def without_multipath_walls(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Remove walls of few stations that may be multipath."""
    measurements = likelihood.measurements
    if len(measurements.centers) < _FEWEST:
        return list(features)
    if likelihood.tables.cone:
        for each in features:
            if _is_lone_wall(each, acceptance):
                record_event(Decision.REMOVED, each, reason=Reason.SINGLE_STATION)
        return [each for each in features if not _is_lone_wall(each, acceptance)]
    kept = _without_latent(likelihood, features, acceptance)
    is_at_once = (measurements.crosstalk_sources >= 0) & (measurements.crosstalk_delays == 0.0)
    return _without_crosstalk(likelihood, kept, acceptance) if is_at_once.any() else kept


def _is_lone_wall(feature: Hypothesis, acceptance: AcceptanceTest) -> bool:
    """Return True for a wall of hardly more than one station and without a track history."""
    return feature.is_wall and not feature.is_known and acceptance.has_single_station(feature)


def _without_latent(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Remove walls, the weakest first, that gain too little beside multipath over a latent wall."""
    kept = list(features)
    for feature in sorted(features, key=lambda each: each.llr):
        others = [each for each in kept if each is not feature]
        if _is_weak(feature, acceptance) and not _gains_beside_latent(likelihood, feature, others, acceptance):
            record_event(Decision.REMOVED, feature, reason=Reason.MULTIPATH)
            kept = others
    return kept


def _is_weak(feature: Hypothesis, acceptance: AcceptanceTest) -> bool:
    """Return True for a wall of few supporting stations and without a track history."""
    supporting = feature.supporting(acceptance.settings.min_second_station_llr)
    return feature.is_wall and not feature.is_known and supporting <= _FEW_STATIONS


def _gains_beside_latent(
    likelihood: PingLikelihood, wall: Hypothesis, others: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> bool:
    """Return True if a wall gains enough beside the best latent wall."""
    log_densities = likelihood.log_densities(others)
    rescored = likelihood.rescored(wall, log_densities, others)
    echoes = log_densities_over_latent_walls(likelihood, rescored, others, log_densities)
    if echoes.max() == NO_ECHO:
        return True
    beside = likelihood.rescored(wall, np.maximum(log_densities, echoes), others)
    return beside.llr > acceptance.settings.min_second_station_llr


def _without_crosstalk(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], acceptance: AcceptanceTest
) -> list[Hypothesis]:
    """Remove walls that may be crosstalk between sensors."""
    walls = [each for each in features if each.is_wall]
    shares = [
        acceptance.detection_rate(*each)
        for each in zip(features, likelihood.log_densities_without(features), strict=True)
    ]
    least = acceptance.settings.min_relative_detection_rate * _usual(features, shares)
    kept = []
    for each, share in zip(features, shares, strict=True):
        if share >= least or not _may_be_cast(each, walls, likelihood.measurements, acceptance):
            kept.append(each)
        else:
            record_event(Decision.REMOVED, each, reason=Reason.MULTIPATH)
    return kept


def _usual(features: Sequence[Hypothesis], shares: Sequence[float]) -> float:
    """Return the median detection rate of walls; 0 without walls."""
    detected = [share for each, share in zip(features, shares, strict=True) if each.is_wall and each.best_llr > 0.0]
    return float(np.median(detected)) if detected else 0.0


def _may_be_cast(
    feature: Hypothesis, walls: Sequence[Hypothesis], measurements: Measurements, acceptance: AcceptanceTest
) -> bool:
    """Return True for a wall of one station that is farther away than the image of the station in two walls can be.

    In two walls at a right angle the image is as far as their crossing: the root sum of squares of their distances.
    """
    if not _is_lone_wall(feature, acceptance):
        return False
    center_xy = measurements.centers[np.argmax(feature.llr_by_station)]
    nearest = np.sort(_distances([each for each in walls if each is not feature], center_xy))[:2]
    return len(nearest) > 1 and -float(signed_distances(feature.line, center_xy)) > math.hypot(*nearest)


def _distances(walls: Sequence[Hypothesis], point_xy: FloatArray) -> FloatArray:
    """Return the distances of a point from the reflecting parts of the walls before which it lies [m]."""
    lines = np.array([each.line for each in walls]).reshape(-1, 2)
    ends = np.array([each.extent for each in walls]).reshape(-1, 2)
    place, depths = along(lines, point_xy), -signed_distances(lines, point_xy)
    beyond = np.maximum(0.0, np.maximum(ends[:, 0] - place, place - ends[:, 1]) - STRETCH)
    distances: FloatArray = np.hypot(depths, beyond)[depths > 0.0]
    return distances
