"""Readings and the features that explain them: whose echo each is, and how it would change."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import (
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
from echoplan.compiled import compiled
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.edge_diffraction import WallExtent, diffracted, diffracted_jacobian, edges_of, is_ended
from echoplan.preprocessing.measurements import Measurements

__all__ = [
    "Association",
    "Features",
    "as_arrays",
    "associate",
    "extent_of",
    "predict_and_residual",
    "range_jacobian",
    "residuals_of",
]

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
    attenuations : ndarray, shape (f, s)
        How much fainter than all of it each station hears it [dB]; ``inf`` for stations that did not hear it.
    bias_variances : ndarray, shape (f, s)
        Variance of what each station reads too far because nobody knows how much of it it hears [m^2].
    ends : ndarray, shape (f, 2, 6)
        Where walls end because another goes on around a corner [m], as ``edges_of`` tells.
    """

    reflectors: FloatArray
    extents: FloatArray
    attenuations: FloatArray
    bias_variances: FloatArray
    ends: FloatArray


class Association(NamedTuple):
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
    detected = np.zeros((len(features), stations), dtype=bool)
    for row, each in zip(detected, features, strict=True):
        row[: len(each.llr_by_station)] = each.llr_by_station > 0.0
    reflectors = np.array([each.reflector for each in features]).reshape(-1, 4)
    extents = np.array([each.extent for each in features]).reshape(-1, 2)
    return Features(
        reflectors=reflectors,
        extents=extents,
        attenuations=np.where(detected, 0.0, np.inf),
        bias_variances=np.zeros(detected.shape),
        ends=edges_of(reflectors, extents),
    )


@compiled
def associate(measurements: Measurements, hearing: Hearing, features: Features, band: float) -> Association:
    """Give each reading to the feature that comes nearest to it, of those that its station heard.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    hearing : Hearing
        The sonar.
    features : Features
        What is there.
    band : float
        How far a reading may be off [m].

    Returns
    -------
    Association
        One a ping.
    """
    count = len(measurements.readings)
    owners, residuals, excesses = np.full(count, -1), np.zeros(count), np.zeros(count)
    for feature in range(len(features.reflectors)):
        shape, reach = shape_of(features.reflectors[feature]), extent_of(features, feature)
        for ping in range(count):
            attenuation = features.attenuations[feature, measurements.stations[ping]]
            if math.isinf(attenuation):
                continue
            place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
            sight, late = predict_and_residual(
                shape, reach, place, measurements.readings[ping] * hearing.scale, hearing.wavelength
            )
            if not abs(late) < band + _WALK:
                continue
            excess = excess_of(hearing, sight) - attenuation
            late -= walk_of(hearing, excess)
            if excess > _FAINT and abs(late) < min(band, abs(residuals[ping]) if owners[ping] >= 0 else band):
                owners[ping], residuals[ping], excesses[ping] = feature, late, excess
    return Association(owners, residuals, excesses)


@compiled
def residuals_of(measurements: Measurements, hearing: Hearing, features: Features, owners: IntArray) -> FloatArray:
    """Return readings less those expected of the features that own them, shape (m,) [m], of all m pings with an owner.

    A sensor that does not face its feature any more makes the whole reading a residual.
    """
    explained = np.flatnonzero(owners >= 0)
    residuals = np.empty(len(explained))
    for row, ping in enumerate(explained):
        owner, reading = owners[ping], measurements.readings[ping] * hearing.scale
        shape, attenuation = (
            shape_of(features.reflectors[owner]),
            features.attenuations[owner, measurements.stations[ping]],
        )
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        sight, late = predict_and_residual(shape, extent_of(features, owner), place, reading, hearing.wavelength)
        residuals[row] = (
            reading if math.isinf(late) else late - walk_of(hearing, excess_of(hearing, sight) - attenuation)
        )
    return residuals


@compiled
def extent_of(features: Features, number: int) -> WallExtent:
    """Tell how far a wall reaches.

    Parameters
    ----------
    features : Features
        What is there.
    number : int
        Which feature.

    Returns
    -------
    WallExtent
        Between which places it was heard, and where it ends [m].
    """
    extent, ends = features.extents[number], features.ends[number]
    return extent[0], extent[1], ends[0, 0], ends[1, 0]


@compiled
def predict_and_residual(
    shape: Shape, reach: WallExtent, place: Ping, reading: float, wavelength: float
) -> tuple[Sight, float]:
    """Look at a feature, and tell how much longer than its depth a reading is.

    Parameters
    ----------
    shape : Shape
        The feature.
    reach : WallExtent
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
    if is_ended(shape, place, reach):
        sight = diffracted(sight, reach[2] - foot, foot - reach[3], wavelength)
    return sight, reading - sight[0]


@compiled
def range_jacobian(
    measurements: Measurements,
    hearing: Hearing,
    features: Features,
    matched: Association,
    explained: IntArray,
    walk: tuple[float, float, float, float],
) -> tuple[FloatArray, IntArray]:
    """Differentiate readings by all that they depend on.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    hearing : Hearing
        The sonar.
    features : Features
        What is there.
    matched : Association
        Which feature explains each ping.
    explained : ndarray of int, shape (m,)
        The pings to differentiate.
    walk : tuple of float
        Range offset and walk gain [m], walk of an aimed plane at 1 m as a share of that at the threshold, and exponent.

    Returns
    -------
    jacobian : ndarray, shape (m, 17)
        By the three parameters of the feature; by angle and offset of the wall where it ends; by range offset, walk
        gain, range scale, servo latency, servo gain, servo offset, figure of merit, the logarithm of ``ka`` and the
        exponent of the walk; by place and direction of the sensor.
    neighbours : ndarray of int, shape (m,)
        Which wall that is; -1 for none.
    """
    jacobian, neighbours, own = np.zeros((len(explained), 17)), np.full(len(explained), -1), np.zeros(8)
    offset, gain, reference, exponent = walk
    bent_reference = _bend(reference)
    for row, ping in enumerate(explained):
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        owner = matched.owners[ping]
        shape, attenuation = (
            shape_of(features.reflectors[owner]),
            features.attenuations[owner, measurements.stations[ping]],
        )
        if is_ended(shape, place, extent_of(features, owner)):
            end, filled = (features.ends[owner], attenuation), (own, jacobian[row, 3:5])
            neighbours[row] = diffracted_jacobian(hearing, shape, place, end, filled)
        else:
            differentiate(hearing, shape, place, own, attenuation)
        jacobian[row, :3] = own[:3]
        jacobian[row, 5] = 1.0
        jacobian[row, 6] = (walk_of(hearing, matched.excesses[ping]) - offset) / gain
        jacobian[row, 7] = -measurements.readings[ping]
        turning = own[4] * measurements.arms_x[ping] - own[3] * measurements.arms_y[ping] + own[5]
        jacobian[row, 8] = -measurements.rates[ping] * turning
        jacobian[row, 9], jacobian[row, 10] = measurements.angles[ping] * turning, turning
        # However loud a sonar is: where it was set right its readings stay.
        jacobian[row, 11], jacobian[row, 12] = own[6] - hearing.reference, own[7]
        # The derivative of w^k by k is w^k ln w, which is w^k ln w^k over k.
        jacobian[row, 13] = gain * (_bend(jacobian[row, 6] + reference) - bent_reference) / exponent
        jacobian[row, 14:] = own[3:6]
    return jacobian, neighbours


@compiled
def _bend(walk: float) -> float:
    return walk * math.log(walk) if walk > 0.0 else 0.0
