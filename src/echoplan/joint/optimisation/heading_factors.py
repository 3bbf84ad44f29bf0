"""Heading factors: the directions of walls as seen from stations, by the angles at which they are detected.

Ranges hardly depend on the angle off the beam axis, least of all those rounded to centimetres, so they do not determine
the yaw of a robot that was placed by hand. The angles at which a wall is detected, and beyond which it is not,
determine it to a few degrees.
"""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import EchoGeometry, Kind, SonarTables, excess_of, shape_of, walk_of
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.geometry import wrap
from echoplan.joint.optimisation.factors import LinearFactor
from echoplan.joint.optimisation.hit_window import RIM, log_chance, outcome_of
from echoplan.joint.optimisation.layout import SONAR_UNKNOWNS
from echoplan.joint.optimisation.range_factors import Features, extent_of, predict_and_residual
from echoplan.joint.optimisation.values import Values
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.servo import AS_RECORDED, ServoError

__all__ = ["NO_HEADINGS", "HeadingMeasurements", "heading_factor", "heading_measurements_of"]

_WALL = int(Kind.WALL)
# Candidate turns of a station [rad], and half of their variance: a posterior variance above it is uninformative.
_TURNS = np.radians(np.arange(-15.0, 15.1, 1.5))
_OPEN = 0.5 * float(np.var(_TURNS))  # Half of the variance [rad²].
# Standard deviation of a heading, however many pings determine it [rad]: beams are irregular, and arcs of walls that
# meet mask each other's sides (a guess).
_UNEVEN = math.radians(6.0)
_SERVO = ("servo_gain", "servo_offset")
# No detection is expected farther off the axis (cosine).
_STEEP = math.cos(1.2)


class HeadingMeasurements(NamedTuple):
    """Measured directions of walls as seen from stations."""

    # Indices of wall and station, shape (b,).
    walls: IntArray
    stations: IntArray
    # Yaw of the station minus the normal angle of the wall [rad], shape (b,).
    headings: FloatArray
    # Mean recorded servo angle of the pings that detected the wall [rad], shape (b,).
    angles: FloatArray
    # Variances of the headings [rad^2], shape (b,).
    variances: FloatArray
    # Gain and offset of the servo for which the headings hold.
    servo: ServoError = AS_RECORDED


# Without candidates.
NO_HEADINGS = HeadingMeasurements(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0))


def heading_measurements_of(
    measurements: Measurements,
    tables: SonarTables,
    features: Features,
    headings: FloatArray,
    *,
    servo: ServoError | None = None,
) -> HeadingMeasurements:
    r"""Measure the directions of all walls as seen from the stations that detected them.

    Each unmasked ping that faces a wall is a detection or a non-detection. :math:`L(\tau)` is their Bernoulli
    likelihood if the station is turned by :math:`\tau`, up to 15 degrees. Its mean is the measurement; its variance,
    plus that of irregular beams, is the variance of the measurement. ``headings``, shape (s,) [rad], are the present
    yaws of the stations. If the servo is calibrated, ``servo`` is the gain and offset by which the pings are placed,
    and each sensor has measurements of its own.
    """
    sensors = 1 if servo is None else int(measurements.sensors.max(initial=0)) + 1
    groups = measurements.stations if servo is None else sensors * measurements.stations + measurements.sensors
    likelihoods, angles = _likelihoods(measurements, tables, features, groups, sensors * len(measurements.centers))
    chances = np.exp(likelihoods - likelihoods.max(axis=2, keepdims=True))
    chances /= chances.sum(axis=2, keepdims=True)
    turns = chances @ _TURNS
    variances = chances @ _TURNS**2 - turns**2
    walls, members = np.nonzero(variances < _OPEN)
    stations = members // sensors
    return HeadingMeasurements(
        walls=walls,
        stations=stations,
        headings=headings[stations] + turns[walls, members] - features.reflectors[walls, 1],
        angles=angles[walls, members],
        variances=variances[walls, members] + _UNEVEN**2,
        servo=servo or AS_RECORDED,
    )


def heading_factor(bearings: HeadingMeasurements, now: Values) -> LinearFactor:
    """Return the factor of the heading measurements: one row each, by wall, yaw, servo gain and servo offset."""
    walls, stations, layout = bearings.walls, bearings.stations, now.layout
    headings = now.poses[stations, 2] if len(now.poses) else np.zeros(len(walls))
    turned = headings + (now.servo.gain - bearings.servo.gain) * bearings.angles
    residuals = wrap(
        bearings.headings - turned + bearings.servo.offset - now.servo.offset + now.features.reflectors[walls, 1]
    )
    gain, offset = (np.full(len(walls), layout.sonar + SONAR_UNKNOWNS.index(each)) for each in _SERVO)
    facing = layout.pose + 3 * stations + 2 if len(now.poses) else np.full(len(walls), -1)
    columns = np.column_stack([layout.starts[walls], facing, gain, offset])
    ones = np.ones(len(walls))
    jacobian = np.column_stack([-ones, ones, bearings.angles, ones])
    return LinearFactor(columns, jacobian, residuals, 1.0 / bearings.variances)


@compiled
def _likelihoods(
    measurements: Measurements, tables: SonarTables, features: Features, groups: IntArray, count: int
) -> tuple[FloatArray, FloatArray]:
    """Return log-likelihoods by wall, group of pings and turn, and the mean servo angles of the detections [rad]."""
    likelihoods = np.zeros((len(features.reflectors), count, len(_TURNS)))
    angles, hits = np.zeros((len(features.reflectors), count)), np.full((len(features.reflectors), count), 1e-9)
    faintest = walk_of(tables, 0.0)
    for feature in range(len(likelihoods)):
        shape, reach = shape_of(features.reflectors[feature]), extent_of(features, feature)
        for ping in range(len(measurements.readings) if shape[0] == _WALL else 0):
            attenuation = features.attenuations[feature, measurements.stations[ping]]
            if math.isinf(attenuation):
                continue
            place = (measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping])
            geometry, late = predict_and_residual(
                shape, reach, place, measurements.readings[ping] * tables.scale, tables.wavelength
            )
            outcome = outcome_of(late, faintest)
            if outcome != 0.0 and geometry[1] > _STEEP and geometry[0] < measurements.max_range - RIM:
                log_likelihoods = likelihoods[feature, groups[ping]]
                if outcome > 0.0:
                    angles[feature, groups[ping]] += measurements.angles[ping]
                    hits[feature, groups[ping]] += 1.0
                _add(log_likelihoods, tables, geometry, (outcome, measurements.weights[ping], attenuation))
    return likelihoods, angles / hits


@inlined
def _add(
    log_likelihoods: FloatArray, tables: SonarTables, geometry: EchoGeometry, asked: tuple[float, float, float]
) -> None:
    """Add the log-likelihood of a ping for each turn; ``asked`` is its outcome, weight and attenuation [dB]."""
    outcome, weight, attenuation = asked
    for number, turn in enumerate(_TURNS):
        cosine, sine = math.cos(turn), math.sin(turn)
        turned = (cosine * geometry[1] - sine * geometry[2], sine * geometry[1] + cosine * geometry[2])
        excess = excess_of(tables, (geometry[0], turned[0], turned[1], geometry[3], geometry[4])) - attenuation
        log_likelihoods[number] += weight * log_chance(outcome * excess)
