"""Readings and the features that explain them: whose echo each is, and how it would change."""

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

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

__all__ = ["Features", "Matched", "as_arrays", "differentiate_readings", "faced", "match_readings", "reach_of"]

_WALL = int(Kind.WALL)
# Fainter than this nothing is expected [dB].
_FAINT = -2.0
# A wall may explain readings this far beyond what was heard of it; no walk is longer than this [m].
_BORDER, _WALK = 0.1, 0.1
# Fresnel's parameter from which on an edge takes nothing away.
_CLEAR = -0.78
# At 4 m an edge takes something away from 7 cm before it on [m].
_ZONE = 0.1
# Step of a central difference [m].
_STEP = 1e-4


# Between which places a wall was heard, and where it ends [m].
Reach: TypeAlias = tuple[float, float, float, float]


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
        shape, reach = shape_of(features.reflectors[feature]), reach_of(features, feature)
        for ping in range(count):
            shadow = features.shadows[feature, soundings.stations[ping]]
            if math.isinf(shadow):
                continue
            place = (soundings.x[ping], soundings.y[ping], soundings.ux[ping], soundings.uy[ping])
            sight, late = faced(shape, reach, place, soundings.readings[ping] * hearing.scale, hearing.wavelength)
            if not abs(late) < band + _WALK:
                continue
            excess = excess_of(hearing, sight) - shadow
            late -= walk_of(hearing, excess)
            if excess > _FAINT and abs(late) < min(band, abs(residuals[ping]) if owners[ping] >= 0 else band):
                owners[ping], residuals[ping], excesses[ping] = feature, late, excess
    return Matched(owners, residuals, excesses)


@compiled
def reach_of(features: Features, number: int) -> Reach:
    """Tell how far a wall reaches.

    Parameters
    ----------
    features : Features
        What is there.
    number : int
        Which feature.

    Returns
    -------
    Reach
        Between which places it was heard, and where it ends [m].
    """
    extent, ends = features.extents[number], features.ends[number]
    return extent[0], extent[1], ends[0, 0], ends[1, 0]


@compiled
def faced(shape: Shape, reach: Reach, place: Ping, reading: float, wavelength: float) -> tuple[Sight, float]:
    """Look at a feature, and tell how much longer than its depth a reading is.

    Parameters
    ----------
    shape : Shape
        The feature.
    reach : Reach
        How far it reaches, if it is a wall.
    place : Ping
        Where the sensor is and where it looks.
    reading : float
        What it reads, scaled [m].
    wavelength : float
        Of the carrier [m].

    Returns
    -------
    sight : Sight
        The feature as the sensor sees it.
    late : float
        Reading less depth [m]; ``-inf`` if the sensor does not face the feature.
    """
    sight = look(shape, place)
    foot, is_wall = shape[1] * place[1] - shape[2] * place[0], shape[0] == _WALL
    if sight[0] <= 0.0 or (is_wall and not reach[0] - _BORDER < foot < reach[1] + _BORDER):
        return sight, -math.inf
    below, above = reach[2] - foot, foot - reach[3]
    if is_wall and max(below, above) > -_ZONE:
        sight = _at_end(sight, below, above, wavelength)
    return sight, reading - sight[0]


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
def _is_ended(shape: Shape, place: Ping, reach: Reach) -> bool:
    """Whether a sensor stands so near to the end of a wall, or past it, that this may matter."""
    foot = shape[1] * place[1] - shape[2] * place[0]
    return shape[0] == _WALL and max(reach[2] - foot, foot - reach[3]) > -_ZONE


@compiled
def _differentiate_at_end(
    hearing: Hearing, shape: Shape, place: Ping, end: tuple[FloatArray, float], slopes: tuple[FloatArray, FloatArray]
) -> int:
    """Differentiate a reading by its own wall and the one that this meets at its end; return the number of that."""
    (ends, shadow), (own, neighbours) = end, slopes
    sight, foot = look(shape, place), shape[1] * place[1] - shape[2] * place[0]
    below, above = ends[0, 0] - foot, foot - ends[1, 0]
    lost = sight[4] - _at_end(sight, below, above, hearing.wavelength)[4]
    differentiate(hearing, shape, place, own, shadow + lost)
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
        shape, shadow = shape_of(features.reflectors[owner]), features.shadows[owner, soundings.stations[ping]]
        if _is_ended(shape, place, reach_of(features, owner)):
            end, filled = (features.ends[owner], shadow), (own, slopes[row, 3:5])
            neighbours[row] = _differentiate_at_end(hearing, shape, place, end, filled)
        else:
            differentiate(hearing, shape, place, own, shadow)
        slopes[row, :3] = own[:3]
        slopes[row, 5] = 1.0
        slopes[row, 6] = (walk_of(hearing, matched.excesses[ping]) - walk[0]) / walk[1]
        slopes[row, 7] = -soundings.readings[ping]
        turning = own[4] * soundings.arms_x[ping] - own[3] * soundings.arms_y[ping] + own[5]
        slopes[row, 8] = -soundings.rates[ping] * turning
        slopes[row, 9:] = own[3:]
    return slopes, neighbours
