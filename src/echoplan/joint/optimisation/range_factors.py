"""Range factors: association of readings with landmarks, their residuals and their Jacobian."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import (
    EchoGeometry,
    Kind,
    Ping,
    Shape,
    SonarTables,
    differentiate,
    echo_geometry,
    excess_of,
    shape_of,
    walk_of,
)
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.optimisation.edge_diffraction import WallExtent, diffracted, diffracted_jacobian, edges_of, is_ended
from echoplan.joint.optimisation.layout import (
    LANDMARK_COLUMNS,
    NEIGHBOUR_COLUMNS,
    POSE_COLUMNS,
    READING_COLUMNS,
    SONAR_COLUMNS,
)
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
# Columns of the parameters of the sonar in the Jacobian of a reading.
(
    _RANGE_OFFSET,
    _WALK_GAIN,
    _RANGE_SCALE,
    _SERVO_LATENCY,
    _SERVO_GAIN,
    _SERVO_OFFSET,
    _FIGURE_OF_MERIT,
    _LOG_KA,
    _WALK_EXPONENT,
) = range(SONAR_COLUMNS, POSE_COLUMNS)
# No detection is expected below this signal excess [dB].
_FAINT = -2.0
# A wall may explain readings this far beyond its detected extent; upper bound of the range walk [m].
_BORDER, _WALK = 0.1, 0.1


class Features(NamedTuple):
    """Landmarks as arrays."""

    # Kind and parameters, shape (f, 4).
    reflectors: FloatArray
    # Lower and upper bound of the detected extent of walls, along them [m], shape (f, 2).
    extents: FloatArray
    # Attenuation of each landmark from each station [dB], shape (f, s); ``inf`` for stations that did not detect it.
    attenuations: FloatArray
    # Variance of the range error that uncertain attenuation causes, shared by all readings of a station [m^2], shape
    # (f, s).
    bias_variances: FloatArray
    # Edges at which walls end, as ``edges_of`` returns them, shape (f, 2, 6).
    ends: FloatArray


class Association(NamedTuple):
    """Landmark that explains each of n pings."""

    # Index of the landmark, shape (n,); -1 for none.
    owners: IntArray
    # Reading minus predicted reading [m], shape (n,).
    residuals: FloatArray
    # Predicted signal excess [dB], shape (n,).
    excesses: FloatArray


def as_arrays(features: Sequence[Hypothesis], stations: int) -> Features:
    """Return landmarks as arrays; stations that contribute no positive LLR to a landmark did not detect it."""
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
def associate(measurements: Measurements, tables: SonarTables, features: Features, band: float) -> Association:
    """Associate each reading with the nearest prediction of landmarks that its station detected, within a band [m]."""
    count = len(measurements.readings)
    owners, residuals, excesses = np.full(count, -1), np.zeros(count), np.zeros(count)
    for feature in range(len(features.reflectors)):
        shape, reach = shape_of(features.reflectors[feature]), extent_of(features, feature)
        for ping in range(count):
            attenuation = features.attenuations[feature, measurements.stations[ping]]
            if math.isinf(attenuation):
                continue
            place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
            geometry, late = predict_and_residual(
                shape, reach, place, measurements.readings[ping] * tables.scale, tables.wavelength
            )
            if not abs(late) < band + _WALK:
                continue
            excess = excess_of(tables, geometry) - attenuation
            late -= walk_of(tables, excess)
            if excess > _FAINT and abs(late) < min(band, abs(residuals[ping]) if owners[ping] >= 0 else band):
                owners[ping], residuals[ping], excesses[ping] = feature, late, excess
    return Association(owners, residuals, excesses)


@compiled
def residuals_of(measurements: Measurements, tables: SonarTables, features: Features, owners: IntArray) -> FloatArray:
    """Return the residuals of all m pings with an owner: reading minus predicted reading, shape (m,) [m].

    If the sensor does not face its landmark any more, the whole reading is the residual.
    """
    residuals, row = np.empty(len(owners)), 0
    for ping, owner in enumerate(owners):
        if owner < 0:
            continue
        reading = measurements.readings[ping] * tables.scale
        shape, attenuation = (
            shape_of(features.reflectors[owner]),
            features.attenuations[owner, measurements.stations[ping]],
        )
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        geometry, late = predict_and_residual(shape, extent_of(features, owner), place, reading, tables.wavelength)
        residuals[row] = (
            reading if math.isinf(late) else late - walk_of(tables, excess_of(tables, geometry) - attenuation)
        )
        row += 1
    return residuals[:row].copy()


@inlined
def extent_of(features: Features, number: int) -> WallExtent:
    """Return the bounds of the detected extent of a wall, and the positions of its edges [m]."""
    extent, ends = features.extents[number], features.ends[number]
    return extent[0], extent[1], ends[0, 0], ends[1, 0]


@inlined
def predict_and_residual(
    shape: Shape, reach: WallExtent, place: Ping, reading: float, wavelength: float
) -> tuple[EchoGeometry, float]:
    """Return the sight of a landmark, including edge diffraction, and reading minus depth [m].

    ``reading`` includes the range scale; the difference is ``-inf`` if the sensor does not face the landmark.
    """
    geometry = echo_geometry(shape, place)
    foot, is_wall = shape[1] * place[1] - shape[2] * place[0], shape[0] == _WALL
    if geometry[0] <= 0.0 or (is_wall and not reach[0] - _BORDER < foot < reach[1] + _BORDER):
        return geometry, -math.inf
    if is_ended(shape, place, reach):
        geometry = diffracted(geometry, reach[2] - foot, foot - reach[3], wavelength)
    return geometry, reading - geometry[0]


@compiled
def range_jacobian(
    measurements: Measurements,
    tables: SonarTables,
    features: Features,
    association: Association,
    explained: IntArray,
    walk: tuple[float, float, float, float],
) -> tuple[FloatArray, IntArray]:
    """Return the derivatives of predicted readings, shape (m, 17), and the wall that forms an edge with each landmark.

    The columns are: three parameters of the landmark; normal angle and offset of the other wall of the edge; range
    offset, walk gain, range scale, servo latency, servo gain, servo offset, figure of merit, log ``ka``, walk exponent;
    x, y and yaw of the sensor. The second result, shape (m,), is the index of the other wall, -1 for none. ``walk``
    holds range offset [m], walk gain [m], the walk of an aimed plane at 1 m as a share of that at the threshold, and
    the walk exponent.
    """
    jacobian, neighbours, own = np.zeros((len(explained), READING_COLUMNS)), np.full(len(explained), -1), np.zeros(8)
    offset, gain, reference, exponent = walk
    bent_reference = _bend(reference)
    for row, ping in enumerate(explained):
        place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
        owner = association.owners[ping]
        shape, attenuation = (
            shape_of(features.reflectors[owner]),
            features.attenuations[owner, measurements.stations[ping]],
        )
        if is_ended(shape, place, extent_of(features, owner)):
            end, filled = (features.ends[owner], attenuation), (own, jacobian[row, NEIGHBOUR_COLUMNS:SONAR_COLUMNS])
            neighbours[row] = diffracted_jacobian(tables, shape, place, end, filled)
        else:
            differentiate(tables, shape, place, own, attenuation)
        for axis in range(3):
            jacobian[row, LANDMARK_COLUMNS + axis], jacobian[row, POSE_COLUMNS + axis] = own[axis], own[3 + axis]
        walk_per_gain = (walk_of(tables, association.excesses[ping]) - offset) / gain
        jacobian[row, _RANGE_OFFSET] = 1.0
        jacobian[row, _WALK_GAIN] = walk_per_gain
        jacobian[row, _RANGE_SCALE] = -measurements.readings[ping]
        turning = own[4] * measurements.arms_x[ping] - own[3] * measurements.arms_y[ping] + own[5]
        jacobian[row, _SERVO_LATENCY] = -measurements.rates[ping] * turning
        jacobian[row, _SERVO_GAIN], jacobian[row, _SERVO_OFFSET] = measurements.angles[ping] * turning, turning
        # The range offset is the error of an aimed plane at 1 m, so the change of the range walk there is subtracted.
        jacobian[row, _FIGURE_OF_MERIT], jacobian[row, _LOG_KA] = own[6] - tables.reference, own[7]
        # The derivative of w^k by k is w^k ln w = w^k ln(w^k) / k.
        jacobian[row, _WALK_EXPONENT] = gain * (_bend(walk_per_gain + reference) - bent_reference) / exponent
    return jacobian, neighbours


@inlined
def _bend(walk: float) -> float:
    return walk * math.log(walk) if walk > 0.0 else 0.0
