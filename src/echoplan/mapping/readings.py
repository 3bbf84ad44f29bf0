"""Readings and the features that explain them: whose echo each is, and how it would change."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.expectation import (
    Hearing,
    Kind,
    Shape,
    Sight,
    differentiate,
    excess_of,
    look,
    shape_of,
    walk_of,
)
from echoplan.arrays import FloatArray, IntArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.compiled import compiled
from echoplan.preprocessing.soundings import Soundings

__all__ = ["Features", "Matched", "as_arrays", "differentiate_readings", "faced", "match_readings"]

_WALL = int(Kind.WALL)
# Fainter than this nothing is expected [dB].
_FAINT = -2.0
# A wall may explain readings this far beyond what was heard of it; no walk is longer than this [m].
_BORDER, _WALK = 0.1, 0.1


class Features(NamedTuple):
    """Features as plain arrays.

    Attributes
    ----------
    reflectors : ndarray, shape (f, 4)
        Kind and parameters.
    extents : ndarray, shape (f, 2)
        Ends of walls along them [m].
    shadows : ndarray, shape (f, s)
        How much fainter than all of it each station hears it [dB]; ``inf`` for stations that did not hear it.
    """

    reflectors: FloatArray
    extents: FloatArray
    shadows: FloatArray


class Matched(NamedTuple):
    """Which feature explains each of n pings.

    Attributes
    ----------
    owners : ndarray of int, shape (n,)
        Number of the feature; -1 for none.
    residuals : ndarray, shape (n,)
        Reading less expected reading [m].
    excesses : ndarray, shape (n,)
        Expected signal excess [dB].
    """

    owners: IntArray
    residuals: FloatArray
    excesses: FloatArray


def as_arrays(features: Sequence[Hypothesis], stations: int) -> Features:
    """Turn features into plain arrays.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there; those without gains were not heard from any station at hand.
    stations : int
        How many stations there are.

    Returns
    -------
    Features
        In the same order.
    """
    heard = np.zeros((len(features), stations), dtype=bool)
    for row, each in zip(heard, features, strict=True):
        row[: len(each.gains)] = each.gains > 0.0
    return Features(
        reflectors=np.array([each.reflector for each in features]).reshape(-1, 4),
        extents=np.array([each.extent for each in features]).reshape(-1, 2),
        shadows=np.where(heard, 0.0, np.inf),
    )


@compiled
def match_readings(soundings: Soundings, hearing: Hearing, features: Features, band: float) -> Matched:
    """Give each reading to the feature that comes nearest to it, of those that its station heard.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    features : Features
        What is there.
    band : float
        How far a reading may be off [m].

    Returns
    -------
    Matched
        One a ping.
    """
    count = len(soundings.readings)
    owners, residuals, excesses = np.full(count, -1), np.zeros(count), np.zeros(count)
    for feature in range(len(features.reflectors)):
        shape, extent = shape_of(features.reflectors[feature]), features.extents[feature]
        for ping in range(count):
            shadow = features.shadows[feature, soundings.stations[ping]]
            if math.isinf(shadow):
                continue
            sight, late = faced(soundings, hearing, shape, extent, ping)
            if not abs(late) < band + _WALK:
                continue
            excess = excess_of(hearing, sight) - shadow
            late -= walk_of(hearing, excess)
            if excess > _FAINT and abs(late) < min(band, abs(residuals[ping]) if owners[ping] >= 0 else band):
                owners[ping], residuals[ping], excesses[ping] = feature, late, excess
    return Matched(owners, residuals, excesses)


@compiled
def faced(soundings: Soundings, hearing: Hearing, shape: Shape, extent: FloatArray, ping: int) -> tuple[Sight, float]:
    """Look at a feature, and tell how much longer than its depth the reading is.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    shape : Shape
        The feature.
    extent : ndarray, shape (2,)
        Ends of a wall along it [m].
    ping : int
        Which ping.

    Returns
    -------
    sight : Sight
        The feature as the sensor sees it.
    late : float
        Reading less depth [m]; ``-inf`` if the sensor does not face the feature.
    """
    x, y = soundings.x[ping], soundings.y[ping]
    sight = look(shape, (x, y, soundings.ux[ping], soundings.uy[ping]))
    late = soundings.readings[ping] * hearing.scale - sight[0]
    foot = shape[1] * y - shape[2] * x
    beside = shape[0] == _WALL and not extent[0] - _BORDER < foot < extent[1] + _BORDER
    return sight, -math.inf if beside or sight[0] <= 0.0 else late


@compiled
def differentiate_readings(
    soundings: Soundings,
    hearing: Hearing,
    features: Features,
    matched: Matched,
    explained: IntArray,
    walk: tuple[float, float],
) -> FloatArray:
    """Differentiate readings by all that they depend on.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    features : Features
        What is there.
    matched : Matched
        Which feature explains each ping.
    explained : ndarray of int, shape (m,)
        The pings to differentiate.
    walk : tuple of float
        Range offset and walk gain [m].

    Returns
    -------
    ndarray, shape (m, 10)
        By the three parameters of the feature; by range offset, walk gain, range scale and servo latency; by place
        and direction of the sensor.
    """
    slopes, own = np.zeros((len(explained), 10)), np.zeros(6)
    for row, ping in enumerate(explained):
        place = (soundings.x[ping], soundings.y[ping], soundings.ux[ping], soundings.uy[ping])
        owner = matched.owners[ping]
        shadow = features.shadows[owner, soundings.stations[ping]]
        differentiate(hearing, shape_of(features.reflectors[owner]), place, own, shadow)
        slopes[row, :3] = own[:3]
        slopes[row, 3] = 1.0
        slopes[row, 4] = (walk_of(hearing, matched.excesses[ping]) - walk[0]) / walk[1]
        slopes[row, 5] = -soundings.readings[ping]
        turning = own[4] * soundings.arms_x[ping] - own[3] * soundings.arms_y[ping] + own[5]
        slopes[row, 6] = -soundings.rates[ping] * turning
        slopes[row, 7:] = own[3:]
    return slopes
