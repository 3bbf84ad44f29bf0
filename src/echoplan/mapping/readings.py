"""Readings and the features that explain them: whose echo each is, and how it would change."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.expectation import (
    Hearing,
    Kind,
    Ping,
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
from echoplan.mapping.edges import edges_of
from echoplan.preprocessing.soundings import Soundings

__all__ = ["Features", "Matched", "as_arrays", "differentiate_readings", "faced", "match_readings"]

_WALL = int(Kind.WALL)
# Fainter than this nothing is expected [dB].
_FAINT = -2.0
# A wall may explain readings this far beyond what was heard of it; no walk is longer than this [m].
_BORDER, _WALK = 0.1, 0.1
# Fresnel's parameter from which on an edge takes nothing away.
_CLEAR = -0.78
# Step of a central difference [m].
_STEP = 1e-4


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
    ends : ndarray, shape (f, 2, 6)
        Where walls end because another goes on around a corner [m], as ``edges_of`` tells.
    """

    reflectors: FloatArray
    extents: FloatArray
    shadows: FloatArray
    ends: FloatArray


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
    reflectors = np.array([each.reflector for each in features]).reshape(-1, 4)
    extents = np.array([each.extent for each in features]).reshape(-1, 2)
    return Features(
        reflectors=reflectors,
        extents=extents,
        shadows=np.where(heard, 0.0, np.inf),
        ends=edges_of(reflectors, extents),
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
        shape, extent, ends = shape_of(features.reflectors[feature]), features.extents[feature], features.ends[feature]
        for ping in range(count):
            shadow = features.shadows[feature, soundings.stations[ping]]
            if math.isinf(shadow):
                continue
            sight, late = faced(soundings, hearing, shape, (extent, ends), ping)
            if not abs(late) < band + _WALK:
                continue
            excess = excess_of(hearing, sight) - shadow
            late -= walk_of(hearing, excess)
            if excess > _FAINT and abs(late) < min(band, abs(residuals[ping]) if owners[ping] >= 0 else band):
                owners[ping], residuals[ping], excesses[ping] = feature, late, excess
    return Matched(owners, residuals, excesses)


@compiled
def faced(
    soundings: Soundings, hearing: Hearing, shape: Shape, reach: tuple[FloatArray, FloatArray], ping: int
) -> tuple[Sight, float]:
    """Look at a feature, and tell how much longer than its depth the reading is.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    shape : Shape
        The feature.
    reach : tuple of ndarray, shapes (2,) and (2, 6)
        What was heard of a wall along it [m], and where it ends.
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
    extent, ends = reach
    foot = shape[1] * y - shape[2] * x
    beside = shape[0] == _WALL and not extent[0] - _BORDER < foot < extent[1] + _BORDER
    if beside or sight[0] <= 0.0:
        return sight, -math.inf
    if shape[0] == _WALL:
        sight = _at_end(sight, ends[0, 0] - foot, foot - ends[1, 0], hearing.wavelength)
    return sight, soundings.readings[ping] * hearing.scale - sight[0]


@compiled
def _at_end(sight: Sight, below: float, above: float, wavelength: float) -> Sight:
    """See a wall from before, or past, its end: a knife edge (ITU-R P.526), whence what is left of the sound comes."""
    depth, cosine, sine, distance, strength = sight
    over = max(below, above)
    passing = 2.0 * over / math.sqrt(depth * wavelength)
    if passing <= _CLEAR:
        return sight
    grazing = passing - 0.1
    strength -= 6.9 + 20.0 * math.log10(math.sqrt(grazing * grazing + 1.0) + grazing)
    if over <= 0.0:
        return depth, cosine, sine, distance, strength
    away = math.hypot(depth, over)
    aside, ahead = (over if below > above else -over) / away, depth / away
    return away, cosine * ahead + sine * aside, sine * ahead - cosine * aside, distance, strength


@compiled
def _add_end(
    hearing: Hearing, shape: Shape, place: Ping, end: tuple[FloatArray, float], slopes: tuple[FloatArray, FloatArray]
) -> int:
    """Add how a reading changes with the end of a wall; return the number of the wall that it meets there, or -1."""
    (ends, shadow), (own, neighbours) = end, slopes
    sight, foot = look(shape, place), shape[1] * place[1] - shape[2] * place[0]
    below, above = ends[0, 0] - foot, foot - ends[1, 0]
    if 2.0 * max(below, above) <= _CLEAR * math.sqrt(sight[0] * hearing.wavelength):
        return -1
    near = _read(hearing, _at_end(sight, below - _STEP, above - _STEP, hearing.wavelength), shadow)
    far = _read(hearing, _at_end(sight, below + _STEP, above + _STEP, hearing.wavelength), shadow)
    side, sign = (0, 1.0) if below > above else (1, -1.0)
    slope = sign * (far - near) / (2.0 * _STEP)
    # The foot of the sensor moves the other way, as the wall turns and as the sensor moves.
    own[0] += slope * (ends[side, 1] + shape[3] - sight[0])
    own[1] += slope * ends[side, 2]
    own[3] += slope * shape[2]
    own[4] -= slope * shape[1]
    neighbours[0], neighbours[1] = slope * ends[side, 3], slope * ends[side, 4]
    return int(ends[side, 5])


@compiled
def _read(hearing: Hearing, sight: Sight, shadow: float) -> float:
    return sight[0] + walk_of(hearing, excess_of(hearing, sight) - shadow)


@compiled
def differentiate_readings(
    soundings: Soundings,
    hearing: Hearing,
    features: Features,
    matched: Matched,
    explained: IntArray,
    walk: tuple[float, float],
) -> tuple[FloatArray, IntArray]:
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
    slopes : ndarray, shape (m, 12)
        By the three parameters of the feature; by angle and offset of the wall where it ends; by range offset, walk
        gain, range scale and servo latency; by place and direction of the sensor.
    neighbours : ndarray of int, shape (m,)
        Which wall that is; -1 for none.
    """
    slopes, neighbours, own = np.zeros((len(explained), 12)), np.full(len(explained), -1), np.zeros(6)
    for row, ping in enumerate(explained):
        place = (soundings.x[ping], soundings.y[ping], soundings.ux[ping], soundings.uy[ping])
        owner = matched.owners[ping]
        shape, ends = shape_of(features.reflectors[owner]), features.ends[owner]
        shadow = features.shadows[owner, soundings.stations[ping]]
        sight, _ = faced(soundings, hearing, shape, (features.extents[owner], ends), ping)
        differentiate(hearing, shape, place, own, shadow + look(shape, place)[4] - sight[4])
        if shape[0] == _WALL:
            neighbours[row] = _add_end(hearing, shape, place, (ends, shadow), (own, slopes[row, 3:5]))
        slopes[row, :3] = own[:3]
        slopes[row, 5] = 1.0
        slopes[row, 6] = (walk_of(hearing, matched.excesses[ping]) - walk[0]) / walk[1]
        slopes[row, 7] = -soundings.readings[ping]
        turning = own[4] * soundings.arms_x[ping] - own[3] * soundings.arms_y[ping] + own[5]
        slopes[row, 8] = -soundings.rates[ping] * turning
        slopes[row, 9:] = own[3:]
    return slopes, neighbours
