"""Alternatives to a landmark in its place, and the class probabilities that result."""

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import directions
from echoplan.joint.landmarks import LANDMARKS, reflector_at
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.search.refinement import approach
from echoplan.model import ClassProbabilities, FeatureClass

__all__ = ["alternatives_to", "class_probabilities"]

# Initial radius of an alternative cylinder [m].
_RADIUS = 0.12
# Annealing schedule of alternatives: noise in standard deviations, gate [m], steps.
_SCHEDULE = ((4.0, 0.06, 4), (1.0, 0.03, 4))
# Prior probability that a landmark of two stations or fewer is an echo of a class that the model lacks. Source: all
# false landmarks of `benchmarks/joint.py 30`, 3 of 82 with so few stations and none of 304 with more. Each further
# station would have to agree by chance, which is assumed to be ten times rarer.
_UNMODELLED, _PER_STATION, _FEW = 0.04, 0.1, 2
# A station clearly supports a landmark if it contributes more than this [nats].
_CLEARLY = 5.0


def class_probabilities(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], *, radius_cost: float
) -> list[ClassProbabilities]:
    """Return the probabilities of wall, corner and cylinder for each landmark.

    They are the likelihoods of the three, each refined in place, over their sum, mixed with a third each for an
    unmodelled echo. ``radius_cost`` is the cost of the third parameter of a cylinder [nats].
    """
    return [_probabilities(likelihood, features, number, radius_cost) for number in range(len(features))]


def _probabilities(
    likelihood: PingLikelihood, features: Sequence[Hypothesis], number: int, radius_cost: float
) -> ClassProbabilities:
    """Return the class probabilities of one landmark."""
    feature = features[number]
    rescored = alternatives_to(likelihood, feature, [each for each in features if each is not feature])
    llrs = dict.fromkeys(FeatureClass, -np.inf)
    # Alternatives have no track history, so that of the landmark does not count either.
    for each in [replace(feature, llr=feature.llr - feature.history.llr), *rescored]:
        cost = radius_cost if each.type.has_radius else 0.0
        llrs[each.type.feature_class] = max(llrs[each.type.feature_class], each.llr - cost)
    scores = np.array([llrs[FeatureClass.WALL], llrs[FeatureClass.CORNER], llrs[FeatureClass.CYLINDER]])
    chances = np.exp(scores - scores.max())
    # For an unmodelled echo the likeliest class is wrong with the prior probability.
    unmodelled = 1.5 * _UNMODELLED * _PER_STATION ** max(feature.supporting(_CLEARLY) - _FEW, 0)
    wall, corner, cylinder = ((1.0 - unmodelled) * chances / chances.sum() + unmodelled / 3.0).tolist()
    return ClassProbabilities(wall=wall, corner=corner, cylinder=cylinder)


def alternatives_to(
    likelihood: PingLikelihood,
    feature: Hypothesis,
    others: Sequence[Hypothesis],
    kinds: Collection[Kind] = tuple(Kind),
) -> list[Hypothesis]:
    """Return a landmark of each other class in ``kinds`` in the place of a landmark, scored beside the others.

    Each is refined on the pings that the landmark explains better than the others do.
    """
    log_densities = likelihood.log_densities(others)
    spoken = feature.ping_scores.pings[feature.ping_scores.densities > log_densities[feature.ping_scores.pings]]
    starts = [row for row in _alternatives(likelihood, feature) if row[0] in kinds and row[0] != feature.kind]
    alternatives = [_moved(likelihood, row, spoken) for row in starts]
    return likelihood.score_all([likelihood.score(row) for row in alternatives], log_densities, others)


def _alternatives(likelihood: PingLikelihood, feature: Hypothesis) -> FloatArray:
    """Return reflectors of all classes at the point of a landmark that is nearest to its supporting stations."""
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
    return np.array([reflector_at(kind, nearest, away, radius=_RADIUS) for kind in LANDMARKS if kind is not Kind.ROUND])


def _moved(likelihood: PingLikelihood, reflector: FloatArray, pings: IntArray) -> FloatArray:
    """Refine a reflector on pings by the annealing schedule."""
    noise = likelihood.noise
    schedule = [(deviations * noise, max(band, 4 * noise), rounds) for deviations, band, rounds in _SCHEDULE]
    return approach(likelihood.measurements, likelihood.tables, reflector, pings, schedule)
