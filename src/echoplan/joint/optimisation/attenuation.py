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
from echoplan.joint.optimisation.edge_diffraction import Reach
from echoplan.joint.optimisation.hit_window import RIM, log_chance, outcome_of
from echoplan.joint.optimisation.range_factors import Features, faced, reach_of
from echoplan.preprocessing.ping_arrays import Soundings

__all__ = ["shadowed"]

_WALL = int(Kind.WALL)
# Shadows asked about: so many, a decibel apart.
_SHADOWS = 31
# What a shadow must explain better than none does [nats]: beams differ by a decibel or two.
_COST = 4.0
# Two in a hundred walls that a station hears are taken to be in shadow, in any of these as likely as in another [nats]:
# a guess.  Near or past their ends seven in a thousand are (benchmarks/shadows.py); others have something before them.
_RARE = math.log(_SHADOWS / 0.02)


def shadowed(soundings: Soundings, hearing: Hearing, features: Features) -> Features:
    """Find the shadows of all features from who heard what: the greatest likelihood of hits and misses.

    Parameters
    ----------
    soundings : Soundings
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
    shadows, doubts = _shadows(soundings, hearing, features)
    return features._replace(shadows=shadows, doubts=doubts)


@compiled
def _shadows(soundings: Soundings, hearing: Hearing, features: Features) -> tuple[FloatArray, FloatArray]:
    shadows, doubts = features.shadows.copy(), features.doubts.copy()
    for feature in range(len(shadows)):
        gains, excesses = _likelihoods(soundings, hearing, features, feature)
        past = _past(soundings, features, feature)
        if features.reflectors[feature, 0] == _WALL:
            doubts[feature] = _doubts(hearing, gains, excesses)
        for station in range(len(gains)):
            if past[station]:
                shadows[feature, station] = np.inf
                continue
            best = np.argmax(gains[station])
            if gains[station, best] > gains[station, 0] + _COST:
                shadows[feature, station] = best
    return shadows, doubts


@compiled
def _doubts(hearing: Hearing, gains: FloatArray, excesses: FloatArray) -> FloatArray:
    """Variances of walks for all that who heard what leaves open of the shadows of a wall [m^2], by station."""
    doubts = np.zeros(len(gains))
    for station in range(len(gains)):
        total, mean, square = 0.0, 0.0, 0.0
        for shadow in range(_SHADOWS):
            chance = math.exp(gains[station, shadow] - gains[station].max() - (_RARE if shadow else 0.0))
            walk = walk_of(hearing, excesses[station] - shadow)
            total, mean, square = total + chance, mean + chance * walk, square + chance * walk * walk
        doubts[station] = max(square / total - (mean / total) ** 2, 0.0)
    return doubts


@compiled
def _past(soundings: Soundings, features: Features, feature: int) -> BoolArray:
    """Tell which stations stand past the end of a wall; of one that only such stations heard none is left out."""
    shape, reach = shape_of(features.reflectors[feature]), reach_of(features, feature)
    past, others = np.zeros(len(soundings.centers), dtype=np.bool_), 0
    for station in range(len(past)):
        past[station] = _is_past(shape, reach, soundings.centers[station])
        others += not past[station] and not math.isinf(features.shadows[feature, station])
    return past if others else np.zeros_like(past)


@compiled
def _is_past(shape: Shape, reach: Reach, center_xy: FloatArray) -> bool:
    """Whether a station stands past the end of a wall: what it hears from there may be the edge."""
    foot = shape[1] * center_xy[1] - shape[2] * center_xy[0]
    return bool(shape[0] == _WALL and not reach[2] <= foot <= reach[3])


@compiled
def _likelihoods(
    soundings: Soundings, hearing: Hearing, features: Features, feature: int
) -> tuple[FloatArray, FloatArray]:
    """Logarithms of the likelihood of all hits and misses of each station, by shadow; the mean excess of the hits."""
    shape, reach = shape_of(features.reflectors[feature]), reach_of(features, feature)
    faintest, gains = walk_of(hearing, 0.0), np.zeros((len(soundings.centers), _SHADOWS))
    excesses, hits = np.zeros(len(gains)), np.zeros(len(gains))
    for ping in range(len(soundings.readings)):
        station = soundings.stations[ping]
        if math.isinf(features.shadows[feature, station]):
            continue
        place = (soundings.x[ping], soundings.y[ping], soundings.ux[ping], soundings.uy[ping])
        sight, late = faced(shape, reach, place, soundings.readings[ping] * hearing.scale, hearing.wavelength)
        excess = excess_of(hearing, sight)
        if excess <= 0.0 or sight[0] > soundings.max_range - RIM:
            continue
        outcome = outcome_of(late, faintest)
        if outcome != 0.0:
            _add(gains[station], outcome, excess, soundings.weights[ping])
        if outcome > 0.0:
            excesses[station], hits[station] = excesses[station] + excess, hits[station] + 1.0
    return gains, excesses / np.maximum(hits, 1.0)


@compiled
def _add(gains: FloatArray, outcome: float, excess: float, weight: float) -> None:
    """Add what a hit or a miss says of each shadow."""
    for shadow in range(_SHADOWS):
        gains[shadow] += weight * log_chance(outcome * (excess - shadow))
