"""Ping scores: log-likelihoods of detections and non-detections of a landmark."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.echo_model import COSINE_LIMIT
from echoplan.acoustics.predicted_echo import (
    EchoGeometry,
    Kind,
    Ping,
    Shape,
    SonarTables,
    echo_geometry,
    excess_of,
    shape_of,
    walk_of,
)
from echoplan.acoustics.views import in_view, views_of
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.kernels import log_gaussian
from echoplan.preprocessing.measurements import Measurements

__all__ = [
    "BEYOND",
    "MASKING",
    "NO_ECHO",
    "NO_PING_SCORES",
    "UNCERTAIN",
    "PingScores",
    "detection_probability",
    "log_density",
    "log_non_detection",
    "noise_of",
    "score_pings",
]

_WALL, _ROUND = int(Kind.WALL), int(Kind.ROUND)

# Log density of a reading that an association does not explain.
NO_ECHO = -99.0

# Scale of the logistic detection probability [dB].
_FADING = 1.2
# Signal excess below which no detection is possible [dB].
_INAUDIBLE = -4.0
# Signal excess below which readings scatter more [dB], and the factor on their standard deviation.
UNCERTAIN, _SCATTER = 6.0, 1.6
# Gates in standard deviations: a reading within the first may belong to the landmark; a reading later by the second is
# a non-detection.
_NEAR, BEYOND = 6.0, 4.0
# Detection probability of the strongest echo; least probability of a non-detection, as any reading may be wrong.
_DETECTED, _WRONG = 0.97, 0.06
# Signal excess [dB] above which a non-detection has its least log probability [nats].
_SURE, _SURE_MISS = _FADING * math.log((1.0 - _WRONG) / (_DETECTED - 1.0 + _WRONG)), math.log(_WRONG)
# A reading shorter than expected by more than this is that of a nearer object, which masks the landmark [m].
MASKING = 0.03


class PingScores(NamedTuple):
    """Log-likelihoods of a landmark for the m pings that can detect it."""

    # Indices of the pings, shape (m,).
    pings: IntArray
    # Log density of the reading as an echo of the landmark [log 1/m], shape (m,); ``NO_ECHO`` outside the gate.
    densities: FloatArray
    # Log probability of a non-detection [nats], shape (m,); 0 for pings that are none.
    misses: FloatArray
    # Whether the echo is expected above the threshold and within range, shape (m,).
    audible: BoolArray
    # Whether nothing nearer was detected, shape (m,).
    unmasked: BoolArray
    # Foot of the perpendicular from the sensor, along a wall [m], or bearing of the specular point from the centre of a
    # round wall [rad], shape (m,); 0 for other landmarks.
    feet: FloatArray


# Of a landmark that is not scored on any ping of the window.
NO_PING_SCORES = PingScores(
    np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0, np.bool_), np.zeros(0, np.bool_), np.zeros(0)
)


@inlined
def detection_probability(excess: float) -> float:
    """Return the probability that an echo of this signal excess [dB] crosses the threshold.

    It is logistic in the excess, for the noise of amplitudes, of beams and of surfaces together.
    """
    return 1.0 / (1.0 + math.exp(-min(max(excess / _FADING, -30.0), 30.0)))


@compiled
def score_pings(measurements: Measurements, tables: SonarTables, reflector: FloatArray, noise: float) -> PingScores:
    """Score all pings for a landmark; ``noise`` is the standard deviation of readings [m].

    A reading near the expected one is scored by its density as a detection. A ping that should detect the landmark and
    reads something farther, or nothing, is a non-detection. A nearer reading is not informative, since the landmark may
    be masked.
    """
    count, shape = len(measurements.readings), shape_of(reflector)
    pings = np.empty(count, np.int64)
    densities, misses, feet = np.empty(count), np.empty(count), np.zeros(count)
    audible, unmasked = np.empty(count, np.bool_), np.empty(count, np.bool_)
    limits = measurements.min_range * tables.scale, measurements.max_range * tables.scale
    kept, views = 0, views_of(tables, shape, _INAUDIBLE, limits[1])
    for ping in range(count):
        view = measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping]
        if not in_view(views, shape, view):
            continue
        detected, audible[kept], unmasked[kept], densities[kept], misses[kept] = _ask(
            tables, echo_geometry(shape, view), measurements.readings[ping] * tables.scale, limits, noise
        )
        if not detected:
            continue
        pings[kept] = ping
        if shape[0] == _ROUND:
            feet[kept] = _bearing(shape, view)
        elif shape[0] == _WALL:
            feet[kept] = shape[1] * measurements.y[ping] - shape[2] * measurements.x[ping]
        kept += 1
    return PingScores(
        pings[:kept].copy(),
        densities[:kept].copy(),
        misses[:kept].copy(),
        audible[:kept].copy(),
        unmasked[:kept].copy(),
        feet[:kept].copy(),
    )


@inlined
def _ask(
    tables: SonarTables, geometry: EchoGeometry, detected: float, limits: tuple[float, float], noise: float
) -> tuple[bool, bool, bool, float, float]:
    """Score one ping: whether it can detect, should detect and is unmasked; log density; log non-detection."""
    if geometry[1] < COSINE_LIMIT or geometry[0] <= 0.0 or geometry[0] > limits[1]:
        return False, False, False, 0.0, 0.0
    excess = excess_of(tables, geometry)
    reading = geometry[0] + walk_of(tables, excess)
    if excess <= _INAUDIBLE or not limits[0] <= reading <= limits[1]:
        return False, False, False, 0.0, 0.0
    late = detected - reading
    scatter = noise_of(excess, noise)
    within = reading < limits[1] - BEYOND * scatter
    miss = log_non_detection(excess) if late > BEYOND * scatter else 0.0
    return True, within and excess > 0.0, late > -MASKING, log_density(late, scatter, excess), within * miss


@inlined
def noise_of(excess: float, noise: float) -> float:
    """Return the standard deviation of readings of this signal excess [dB], which is greater near the threshold [m]."""
    return noise * _SCATTER if excess < UNCERTAIN else noise


@inlined
def log_density(late: float, scatter: float, excess: float) -> float:
    """Return the log density of a reading later than expected by ``late`` [m], including its detection [log 1/m]."""
    if abs(late) >= _NEAR * scatter:
        return NO_ECHO
    return log_gaussian(detection_probability(excess), late, scatter)


@inlined
def log_non_detection(excess: float) -> float:
    """Return the log probability that an echo of this signal excess [dB] is not detected."""
    return _SURE_MISS if excess > _SURE else math.log(max(1.0 - _DETECTED * detection_probability(excess), _WRONG))


@inlined
def _bearing(shape: Shape, ping: Ping) -> float:
    """Return the bearing of the specular point of a round wall from its centre [rad]: ahead of the sensor."""
    dx, dy = shape[1] - ping[0], shape[2] - ping[1]
    return math.atan2(dy, dx) if ping[2] * dx + ping[3] * dy > 0.0 else math.atan2(-dy, -dx)
