"""PingScores: what every ping says for and against a reflector."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.echo_model import COSINE_LIMIT
from echoplan.acoustics.predicted_echo import Hearing, Kind, Sight, excess_of, look, shape_of, walk_of
from echoplan.acoustics.views import in_view, views_of
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.preprocessing.measurements import Measurements

__all__ = [
    "BEYOND",
    "MASKING",
    "NO_PING_SCORES",
    "UNCERTAIN",
    "UNHEARD",
    "PingScores",
    "detection_probability",
    "log_density",
    "log_non_detection",
    "noise_of",
    "score_pings",
]

_WALL = int(Kind.WALL)

# Logarithm of a density that is none.
UNHEARD = -99.0

# Echoes fade into noise over this many decibels about the threshold (logistic).
_FADING = 1.2
# Fainter than this nothing is expected [dB].
_INAUDIBLE = -4.0
# Below this excess a detector scatters more, by this factor [dB].
UNCERTAIN, _SCATTER = 6.0, 1.6
# Readings within so many deviations may be echoes of the reflector; later by so many, it was not heard.
_NEAR, BEYOND = 6.0, 4.0
# Chance to hear even the loudest echo, and chance that a reading is wrong whatever is there.
_HEARD, _WRONG = 0.97, 0.06
# From this excess on a miss cannot count for more [dB, nats].
_SURE, _SURE_MISS = _FADING * math.log((1.0 - _WRONG) / (_HEARD - 1.0 + _WRONG)), math.log(_WRONG)
# Readings earlier than expected by more than this come from something nearer that masks the reflector [m].
MASKING = 0.03
_ROOT_TAU = math.sqrt(2.0 * math.pi)


class PingScores(NamedTuple):
    """What m pings say about a reflector; all others can say nothing about it.

    Attributes
    ----------
    pings : ndarray of int, shape (m,)
        Indices into the soundings.
    densities : ndarray, shape (m,)
        Logarithm of the density of the reading if it is the reflector's echo [log 1/m]; ``UNHEARD`` if it is none.
    misses : ndarray, shape (m,)
        Logarithm of the chance not to hear the reflector, where it was not heard; 0 elsewhere [nats].
    audible : ndarray of bool, shape (m,)
        Whether the echo should be above the threshold.
    unmasked : ndarray of bool, shape (m,)
        Whether nothing nearer was heard.
    feet : ndarray, shape (m,)
        Where along a wall the perpendicular from the sensor meets it [m]; 0 for other reflectors.
    """

    pings: IntArray
    densities: FloatArray
    misses: FloatArray
    audible: BoolArray
    unmasked: BoolArray
    feet: FloatArray


# Of a feature that no ping at hand was asked about.
NO_PING_SCORES = PingScores(
    np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0, np.bool_), np.zeros(0, np.bool_), np.zeros(0)
)


@compiled
def detection_probability(excess: float) -> float:
    """Chance that an echo crosses the threshold.

    Parameters
    ----------
    excess : float
        Signal excess [dB].

    Returns
    -------
    float
        Logistic in the excess: the noise of amplitudes, of beams and of surfaces together.
    """
    return 1.0 / (1.0 + math.exp(-min(max(excess / _FADING, -30.0), 30.0)))


@compiled
def score_pings(measurements: Measurements, hearing: Hearing, reflector: FloatArray, noise: float) -> PingScores:
    """Ask all pings about a reflector.

    A ping speaks for it by the density of its reading about the one expected, and against it if it should have heard
    it and heard something farther away or nothing.  Readings of something nearer say nothing: it may be masked.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    hearing : Hearing
        The sonar.
    reflector : ndarray, shape (4,)
        Kind and parameters.
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    PingScores
        Of the pings that could hear it.
    """
    count, shape = len(measurements.readings), shape_of(reflector)
    pings = np.empty(count, np.int64)
    densities, misses, feet = np.empty(count), np.empty(count), np.zeros(count)
    audible, unmasked = np.empty(count, np.bool_), np.empty(count, np.bool_)
    limits = measurements.min_range * hearing.scale, measurements.max_range * hearing.scale
    kept, views = 0, views_of(hearing, shape, _INAUDIBLE, limits[1])
    for ping in range(count):
        view = measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping]
        if not in_view(views, shape, view):
            continue
        detected, audible[kept], unmasked[kept], densities[kept], misses[kept] = _ask(
            hearing, look(shape, view), measurements.readings[ping] * hearing.scale, limits, noise
        )
        if not detected:
            continue
        pings[kept] = ping
        if shape[0] == _WALL:
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


@compiled
def _ask(
    hearing: Hearing, sight: Sight, detected: float, limits: tuple[float, float], noise: float
) -> tuple[bool, bool, bool, float, float]:
    """Ask one ping: whether it could hear the reflector, should hear it, was not masked; its hit and its miss."""
    if sight[1] < COSINE_LIMIT or sight[0] <= 0.0 or sight[0] > limits[1]:
        return False, False, False, 0.0, 0.0
    excess = excess_of(hearing, sight)
    reading = sight[0] + walk_of(hearing, excess)
    if excess <= _INAUDIBLE or not limits[0] <= reading <= limits[1]:
        return False, False, False, 0.0, 0.0
    late = detected - reading
    scatter = noise_of(excess, noise)
    within = reading < limits[1] - BEYOND * scatter
    miss = log_non_detection(excess) if late > BEYOND * scatter else 0.0
    return True, within and excess > 0.0, late > -MASKING, log_density(late, scatter, excess), within * miss


@compiled
def noise_of(excess: float, noise: float) -> float:
    """Return the standard deviation of readings of this signal excess [m]: more near the threshold."""
    return noise * _SCATTER if excess < UNCERTAIN else noise


@compiled
def log_density(late: float, scatter: float, excess: float) -> float:
    """Return the log density of a reading that is so much later than expected, with its detection [log 1/m]."""
    if abs(late) >= _NEAR * scatter:
        return UNHEARD
    return math.log(detection_probability(excess) / (_ROOT_TAU * scatter)) - 0.5 * (late / scatter) ** 2


@compiled
def log_non_detection(excess: float) -> float:
    """Return the log probability that an echo of this signal excess [dB] is not detected."""
    return _SURE_MISS if excess > _SURE else math.log(max(1.0 - _HEARD * detection_probability(excess), _WRONG))
