"""Partial occlusion: the attenuation of each landmark as seen from each station.

An unmapped object may cover part of a landmark, or the perpendicular may meet a wall at its end: half of the amplitude
remains at the end, a tenth one Fresnel zone past it (Keller 1962). A weak echo reads long, so a wall that is detected
past its end is estimated at a wrong angle unless its attenuation is estimated first, from the angles off the beam axis
up to which it is detected. Where a nearer landmark masks the wall at large angles, or is detected there instead, these
angles do not determine the attenuation. Its effect on the range is then an unknown error that all readings of the wall
from that station share, which lowers their weight.
"""

import math

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, Shape, SonarTables, excess_of, shape_of, walk_of
from echoplan.arrays import BoolArray, FloatArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.optimisation.edge_diffraction import WallExtent
from echoplan.joint.optimisation.hit_window import RIM, log_chance, outcome_of
from echoplan.joint.optimisation.range_factors import Features, extent_of, predict_and_residual
from echoplan.preprocessing.measurements import Measurements

__all__ = ["shadowed"]

_WALL = int(Kind.WALL)
# Number of candidate attenuations: 0 to 30 dB in steps of 1 dB.
_ATTENUATIONS = 31
# Gain in log-likelihood from which an attenuation replaces none [nats]: beams differ by 1 to 2 dB.
_COST = 4.0
# Negative log prior of each attenuation [nats]: 2 % of the walls that a station detects are attenuated, each value
# equally likely (a guess). Near or past their ends 0.7 % are (benchmarks/shadows.py); others are partly occluded.
_RARE = math.log(_ATTENUATIONS / 0.02)
# A wall is soft if it returns less than about half of the amplitude [dB].
_SOFT = 5


def shadowed(measurements: Measurements, tables: SonarTables, features: Features, may_be_soft: BoolArray) -> Features:
    """Return the landmarks with reflection losses of soft walls, and the attenuation of each from each station.

    The attenuation is 0 unless another value is likelier by a margin, and ``inf`` for stations that did not detect the
    landmark or that stand past the end of a wall. Its remaining uncertainty is stored in ``bias_variances``.
    ``may_be_soft``, shape (f,), selects the walls of which the loss is estimated.
    """
    reflectors = features.reflectors.copy()
    reflectors[may_be_soft, 3] = 0.0
    losses = _losses(measurements, tables, features._replace(reflectors=reflectors), may_be_soft)
    # If most walls seem soft, the sonar is fainter than assumed, and none is softer than the others.
    if 2 * np.count_nonzero(losses) <= np.count_nonzero(may_be_soft):
        reflectors[may_be_soft, 3] = losses[may_be_soft]
        features = features._replace(reflectors=reflectors)
    attenuations, bias_variances = _attenuations(measurements, tables, features)
    return features._replace(attenuations=attenuations, bias_variances=bias_variances)


@compiled
def _losses(measurements: Measurements, tables: SonarTables, features: Features, may_be_soft: BoolArray) -> FloatArray:
    """Return the reflection losses of walls that may be soft [dB], shape (f,); 0 elsewhere."""
    losses = np.zeros(len(may_be_soft))
    for feature in range(len(losses)):
        if may_be_soft[feature]:
            log_likelihoods, _ = _likelihoods(measurements, tables, features, feature)
            losses[feature] = _reflection_loss(log_likelihoods)
    return losses


@compiled
def _attenuations(measurements: Measurements, tables: SonarTables, features: Features) -> tuple[FloatArray, FloatArray]:
    """Return attenuations [dB] and bias variances [m^2], shape (f, s)."""
    attenuations, bias_variances = features.attenuations.copy(), features.bias_variances.copy()
    for feature in range(len(attenuations)):
        log_likelihoods, excesses = _likelihoods(measurements, tables, features, feature)
        past = _past(measurements, features, feature)
        if features.reflectors[feature, 0] == _WALL:
            _bias_variances(bias_variances[feature], tables, log_likelihoods, excesses)
        for station in range(len(log_likelihoods)):
            if past[station]:
                attenuations[feature, station] = np.inf
                continue
            best = 0
            for attenuation in range(_ATTENUATIONS):
                if log_likelihoods[station, attenuation] > log_likelihoods[station, best]:
                    best = attenuation
            if log_likelihoods[station, best] > log_likelihoods[station, 0] + _COST:
                attenuations[feature, station] = best
    return attenuations, bias_variances


@inlined
def _reflection_loss(log_likelihoods: FloatArray) -> float:
    """Return the loss that explains all stations best [dB], each with an attenuation of its own or none; 0 if hard."""
    totals, best = np.zeros(_ATTENUATIONS), 0
    for station in range(len(log_likelihoods)):
        # From the faintest to the loudest: a station may be fainter than the loss of the wall, at a cost.
        fainter = -math.inf
        for loss in range(_ATTENUATIONS - 1, -1, -1):
            totals[loss] += max(log_likelihoods[station, loss], fainter - _COST)
            fainter = max(fainter, log_likelihoods[station, loss])
    for loss in range(_ATTENUATIONS):
        if totals[loss] > totals[best]:
            best = loss
    if best < _SOFT or totals[best] < totals[0] + _RARE:
        return 0.0
    if best == _ATTENUATIONS - 1:
        return float(best)
    # Between two whole decibels, by a parabola.
    below, above = totals[best] - totals[best - 1], totals[best] - totals[best + 1]
    return float(best + 0.5 * (below - above) / max(below + above, 1e-9))


@inlined
def _bias_variances(
    bias_variances: FloatArray, tables: SonarTables, log_likelihoods: FloatArray, excesses: FloatArray
) -> None:
    """Set the variance of the range walk of a wall under the posterior of its attenuation [m^2], shape (s,)."""
    for station in range(len(log_likelihoods)):
        total, mean, square, greatest = 0.0, 0.0, 0.0, log_likelihoods[station, 0]
        for attenuation in range(_ATTENUATIONS):
            greatest = max(greatest, log_likelihoods[station, attenuation])
        for attenuation in range(_ATTENUATIONS):
            chance = math.exp(log_likelihoods[station, attenuation] - greatest - (_RARE if attenuation else 0.0))
            walk = walk_of(tables, excesses[station] - attenuation)
            total, mean, square = total + chance, mean + chance * walk, square + chance * walk * walk
        bias_variances[station] = max(square / total - (mean / total) ** 2, 0.0)


@inlined
def _past(measurements: Measurements, features: Features, feature: int) -> BoolArray:
    """Return which stations stand past an end of a wall, shape (s,); none if no other station detected the wall."""
    shape, reach = shape_of(features.reflectors[feature]), extent_of(features, feature)
    past, others = np.zeros(len(measurements.centers), dtype=np.bool_), 0
    for station in range(len(past)):
        past[station] = _is_past(shape, reach, measurements.centers[station])
        others += not past[station] and not math.isinf(features.attenuations[feature, station])
    return past if others else np.zeros(len(past), dtype=np.bool_)


@inlined
def _is_past(shape: Shape, reach: WallExtent, center_xy: FloatArray) -> bool:
    """Return whether a station stands past the end of a wall, so that its echo may be diffraction at the edge."""
    foot = shape[1] * center_xy[1] - shape[2] * center_xy[0]
    return bool(shape[0] == _WALL and not reach[2] <= foot <= reach[3])


@inlined
def _likelihoods(
    measurements: Measurements, tables: SonarTables, features: Features, feature: int
) -> tuple[FloatArray, FloatArray]:
    """Return the log-likelihood of the pings by station and attenuation, and the mean signal excess of the detections.

    Shapes are (s, 31) [nats] and (s,) [dB]; pings are detections or non-detections of the landmark.
    """
    shape, reach = shape_of(features.reflectors[feature]), extent_of(features, feature)
    faintest, log_likelihoods = walk_of(tables, 0.0), np.zeros((len(measurements.centers), _ATTENUATIONS))
    excesses, hits = np.zeros(len(log_likelihoods)), np.zeros(len(log_likelihoods))
    for ping in range(len(measurements.readings)):
        station = measurements.stations[ping]
        if math.isinf(features.attenuations[feature, station]):
            continue
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        geometry, late = predict_and_residual(
            shape, reach, place, measurements.readings[ping] * tables.scale, tables.wavelength
        )
        excess = excess_of(tables, geometry)
        if excess <= 0.0 or geometry[0] > measurements.max_range - RIM:
            continue
        outcome = outcome_of(late, faintest)
        if outcome != 0.0:
            _add(log_likelihoods[station], outcome, excess, measurements.weights[ping])
        if outcome > 0.0:
            excesses[station], hits[station] = excesses[station] + excess, hits[station] + 1.0
    return log_likelihoods, excesses / np.maximum(hits, 1.0)


@inlined
def _add(log_likelihoods: FloatArray, outcome: float, excess: float, weight: float) -> None:
    """Add the log-likelihood of a detection (outcome 1) or non-detection (-1) under each attenuation."""
    for attenuation in range(_ATTENUATIONS):
        log_likelihoods[attenuation] += weight * log_chance(outcome * (excess - attenuation))
