"""Rivals: what else a feature could be, and so how sure its class is."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import directions
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.search.refinement import approach
from echoplan.model import ClassProbabilities

__all__ = ["alternatives_to", "class_probabilities"]

# A cylinder that is to explain something else starts out this thick [m].
_RADIUS = 0.12
# Rivals may start as far off as this from where the pings want them: deviations, band [m], steps.
_COURSE = ((4.0, 0.06, 4), (1.0, 0.03, 4))
# Prior probability that a feature known from two stations or fewer is an echo of a kind that the model lacks: all false
# features of `benchmarks/joint.py 30`, 3 of 82 known from so few, and none of 304 known from more. Each further station
# would have to agree by chance, too: that is taken to be ten times rarer.
_UNMODELLED, _PER_STATION, _FEW = 0.04, 0.1, 2
# A station speaks clearly for a feature by more than this [nats].
_CLEARLY = 5.0


def class_probabilities(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], *, radius_cost: float
) -> list[ClassProbabilities]:
    """Let every feature stand against a wall, a corner and a cylinder in its place.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    features : sequence of Hypothesis
        What is there.
    radius_cost : float
        Cost of the third parameter of a cylinder [nats].

    Returns
    -------
    list of ClassProbabilities
        One a feature: the likelihoods of the three, each moved to where the pings want it, over their sum, and an equal
        share of the three for an echo that is none of what the model knows.
    """
    return [_probabilities(likelihood, features, number, radius_cost) for number in range(len(features))]


def _probabilities(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], number: int, radius_cost: float
) -> ClassProbabilities:
    feature = features[number]
    rescored = alternatives_to(likelihood, feature, [each for each in features if each is not feature])
    log_evidence_without_bias = np.full(3, -np.inf)
    # Rivals were not there to be heard before: what is known from then decides nothing here.
    for each in [replace(feature, total=feature.total - feature.history.total), *rescored]:
        cost = radius_cost if each.kind is Kind.CYLINDER else 0.0
        place = {Kind.WALL: 0, Kind.CYLINDER: 2}.get(each.kind, 1)
        log_evidence_without_bias[place] = max(log_evidence_without_bias[place], each.total - cost)
    chances = np.exp(log_evidence_without_bias - log_evidence_without_bias.max())
    unmodelled = _unmodelled(feature.supporting(_CLEARLY))
    wall, corner, cylinder = ((1.0 - unmodelled) * chances / chances.sum() + unmodelled / 3.0).tolist()
    return ClassProbabilities(wall=wall, corner=corner, cylinder=cylinder)


def _unmodelled(stations: int) -> float:
    """Weight of an echo of another kind: such that the likeliest class is wrong with its prior probability."""
    return 1.5 * _UNMODELLED * _PER_STATION ** max(stations - _FEW, 0)


def alternatives_to(
    likelihood: PingLikelihood,
    feature: Hypothesis,
    others: Sequence[Hypothesis],
    kinds: Collection[Kind] = tuple(Kind),
) -> list[Hypothesis]:
    """Find what could stand in the place of a feature.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    feature : Hypothesis
        The feature.
    others : sequence of Hypothesis
        What else is there.
    kinds : collection of Kind, optional
        What it could be.

    Returns
    -------
    list of Hypothesis
        One of each of these but its own, moved to where the pings of the feature want it, and judged beside the others.
    """
    log_densities = likelihood.log_densities(others)
    spoken = feature.ping_scores.pings[feature.ping_scores.densities > log_densities[feature.ping_scores.pings]]
    starts = [row for row in _alternatives(likelihood, feature) if row[0] in kinds and row[0] != feature.kind]
    alternatives = [_moved(likelihood, row, spoken) for row in starts]
    return likelihood.score_all([likelihood.score(row) for row in alternatives], log_densities, others)


def _alternatives(likelihood: PingLikelihood, feature: Hypothesis) -> FloatArray:
    """Stand-ins of all kinds near the part of a feature that most stations heard."""
    supporting = feature.llr_by_station > 0.0
    stations = likelihood.measurements.centers[supporting if supporting.any() else slice(None)]
    middle = stations.mean(axis=0)
    if feature.is_wall:
        normal = directions(feature.line[0])
        nearest, away = middle + (feature.line[1] - middle @ normal) * normal, normal
    else:
        away = feature.reflector[1:3] - middle
        away = away / (np.hypot(*away) + 1e-12)
        nearest = feature.reflector[1:3] - feature.reflector[3] * away
    return np.array(
        [
            [Kind.WALL, np.arctan2(away[1], away[0]), nearest @ away, 0.0],
            [Kind.CORNER, *nearest, 0.0],
            [Kind.EDGE, *nearest, 0.0],
            [Kind.CYLINDER, *(nearest + _RADIUS * away), _RADIUS],
        ]
    )


def _moved(likelihood: PingLikelihood, reflector: FloatArray, pings: IntArray) -> FloatArray:
    noise = likelihood.noise
    pose_model = [(deviations * noise, max(band, 4 * noise), rounds) for deviations, band, rounds in _COURSE]
    return approach(likelihood.measurements, likelihood.hearing, reflector, pings, pose_model)
