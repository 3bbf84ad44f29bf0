"""Shadowing: how much fainter than all of a feature the part is that a station hears.

Something may stand before half of it, or the echo would come from beyond its end: at the very end of a wall half of
the amplitude is left, a Fresnel zone beyond it a tenth (Keller 1962).  A faint echo is read too far, so a wall heard
past its end comes out askew unless its loudness is asked first: by the angles off the axis up to which it is heard.
Where something nearer masks what is far off the axis, or is heard there instead, these do not tell: then nobody knows
how late all that this station says of the wall may be, and it counts for less.
"""

import math

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing, Kind, Shape, excess_of, shape_of, walk_of
from echoplan.arrays import BoolArray, FloatArray
from echoplan.compiled import compiled
from echoplan.joint.optimisation.edge_diffraction import WallExtent
from echoplan.joint.optimisation.hit_window import RIM, log_chance, outcome_of
from echoplan.joint.optimisation.range_factors import Features, extent_of, predict_and_residual
from echoplan.preprocessing.measurements import Measurements

__all__ = ["shadowed"]

_WALL = int(Kind.WALL)
# Shadows asked about: so many, a decibel apart.
_SHADOWS = 31
# What a shadow must explain better than none does [nats]: beams differ by a decibel or two.
_COST = 4.0
# Two in a hundred walls that a station hears are taken to be in shadow, in any of these as likely as in another [nats]:
# a guess.  Near or past their ends seven in a thousand are (benchmarks/shadows.py); others have something before them.
_RARE = math.log(_SHADOWS / 0.02)


def shadowed(measurements: Measurements, hearing: Hearing, features: Features) -> Features:
    """Find the shadows of all features from who heard what: the greatest likelihood of hits and misses.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    hearing : Hearing
        The sonar.
    features : Features
        What is there, not in shadow.

    Returns
    -------
    Features
        The same with their shadows, 0 wherever none explains much better, ``inf`` where they were; and with what is not
        known of them.
    """
    attenuations, bias_variances = _attenuations(measurements, hearing, features)
    return features._replace(attenuations=attenuations, bias_variances=bias_variances)


@compiled
def _attenuations(measurements: Measurements, hearing: Hearing, features: Features) -> tuple[FloatArray, FloatArray]:
    attenuations, bias_variances = features.attenuations.copy(), features.bias_variances.copy()
    for feature in range(len(attenuations)):
        llr_by_station, excesses = _likelihoods(measurements, hearing, features, feature)
        history = _past(measurements, features, feature)
        if features.reflectors[feature, 0] == _WALL:
            bias_variances[feature] = _bias_variances(hearing, llr_by_station, excesses)
        for station in range(len(llr_by_station)):
            if history[station]:
                attenuations[feature, station] = np.inf
                continue
            best = np.argmax(llr_by_station[station])
            if llr_by_station[station, best] > llr_by_station[station, 0] + _COST:
                attenuations[feature, station] = best
    return attenuations, bias_variances


@compiled
def _bias_variances(hearing: Hearing, llr_by_station: FloatArray, excesses: FloatArray) -> FloatArray:
    """Variances of walks for all that who heard what leaves open of the shadows of a wall [m^2], by station."""
    bias_variances = np.zeros(len(llr_by_station))
    for station in range(len(llr_by_station)):
        total, mean, square = 0.0, 0.0, 0.0
        for attenuation in range(_SHADOWS):
            chance = math.exp(
                llr_by_station[station, attenuation] - llr_by_station[station].max() - (_RARE if attenuation else 0.0)
            )
            walk = walk_of(hearing, excesses[station] - attenuation)
            total, mean, square = total + chance, mean + chance * walk, square + chance * walk * walk
        bias_variances[station] = max(square / total - (mean / total) ** 2, 0.0)
    return bias_variances


@compiled
def _past(measurements: Measurements, features: Features, feature: int) -> BoolArray:
    """Tell which stations stand past the end of a wall; of one that only such stations heard none is left out."""
    shape, reach = shape_of(features.reflectors[feature]), extent_of(features, feature)
    history, others = np.zeros(len(measurements.centers), dtype=np.bool_), 0
    for station in range(len(history)):
        history[station] = _is_past(shape, reach, measurements.centers[station])
        others += not history[station] and not math.isinf(features.attenuations[feature, station])
    return history if others else np.zeros_like(history)


@compiled
def _is_past(shape: Shape, reach: WallExtent, center_xy: FloatArray) -> bool:
    """Whether a station stands past the end of a wall: what it hears from there may be the edge."""
    foot = shape[1] * center_xy[1] - shape[2] * center_xy[0]
    return bool(shape[0] == _WALL and not reach[2] <= foot <= reach[3])


@compiled
def _likelihoods(
    measurements: Measurements, hearing: Hearing, features: Features, feature: int
) -> tuple[FloatArray, FloatArray]:
    """Logarithms of the likelihood of all hits and misses of each station, by shadow; the mean excess of the hits."""
    shape, reach = shape_of(features.reflectors[feature]), extent_of(features, feature)
    faintest, llr_by_station = walk_of(hearing, 0.0), np.zeros((len(measurements.centers), _SHADOWS))
    excesses, hits = np.zeros(len(llr_by_station)), np.zeros(len(llr_by_station))
    for ping in range(len(measurements.readings)):
        station = measurements.stations[ping]
        if math.isinf(features.attenuations[feature, station]):
            continue
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        sight, late = predict_and_residual(
            shape, reach, place, measurements.readings[ping] * hearing.scale, hearing.wavelength
        )
        excess = excess_of(hearing, sight)
        if excess <= 0.0 or sight[0] > measurements.max_range - RIM:
            continue
        outcome = outcome_of(late, faintest)
        if outcome != 0.0:
            _add(llr_by_station[station], outcome, excess, measurements.weights[ping])
        if outcome > 0.0:
            excesses[station], hits[station] = excesses[station] + excess, hits[station] + 1.0
    return llr_by_station, excesses / np.maximum(hits, 1.0)


@compiled
def _add(llr_by_station: FloatArray, outcome: float, excess: float, weight: float) -> None:
    """Add what a hit or a miss says of each shadow."""
    for attenuation in range(_SHADOWS):
        llr_by_station[attenuation] += weight * log_chance(outcome * (excess - attenuation))
