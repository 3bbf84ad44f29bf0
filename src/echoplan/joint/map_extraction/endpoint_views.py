"""What each station says of where a wall ends: log-likelihood ratios of its pings, by the place of the end."""

import math

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing, Ping, Shape, excess_of, look, shape_of, walk_of
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.geometry import directions
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import BEYOND, log_density, log_non_detection, noise_of
from echoplan.joint.likelihood.track_history import LineEvidence
from echoplan.joint.optimisation.edge_diffraction import diffracted
from echoplan.preprocessing.measurements import Measurements

__all__ = ["OFFSETS", "line_evidence"]

# How far the end of a wall may lie before the foot of a perpendicular (positive: the station stands past the end) [m].
# A Fresnel zone before the end the whole echo comes back, and 0.4 m past it none that a sonar of this kind detects.
OFFSETS = np.linspace(-0.10, 0.40, 26)
# TrackHistory the end of a wall the echo depends on what the wall ends in: a screen and a wedge differ by so much [dB].
_JAMB = 6.0


def line_evidence(likelihood: PingLikelihood, wall: Hypothesis, count: int, log_densities: FloatArray) -> LineEvidence:
    """Collect what the first stations say of where a line is wall.

    Parameters
    ----------
    likelihood : PingLikelihood
        The pings.
    wall : Hypothesis
        The wall, with fresh evidence.
    count : int
        Only the first so many stations are asked.
    log_densities : ndarray, shape (n,)
        Log density of each reading by its best explanation without the wall [log 1/m].

    Returns
    -------
    LineEvidence
        One row a station that could detect a wall somewhere on the line.
    """
    measurements = likelihood.measurements
    pings = wall.ping_scores.pings[measurements.stations[wall.ping_scores.pings] < count]
    feet = measurements.centers[:count] @ directions(wall.line[0] + math.pi / 2)
    ratios = _log_ratios(measurements, likelihood.hearing, wall.reflector, pings, log_densities, feet, likelihood.noise)
    asked = np.unique(measurements.stations[pings])
    return LineEvidence(feet[asked], measurements.centers[asked], ratios[asked])


@compiled
def _log_ratios(
    measurements: Measurements,
    hearing: Hearing,
    reflector: FloatArray,
    pings: IntArray,
    log_densities: FloatArray,
    feet: FloatArray,
    noise: float,
) -> FloatArray:
    """Log-likelihood ratios of a wall that ends at each offset against none, by station and end, shape (s, 2, m)."""
    shape, ratios = shape_of(reflector), np.zeros((len(feet), 2, len(OFFSETS)))
    limits = measurements.min_range * hearing.scale, measurements.max_range * hearing.scale
    for ping in pings:
        station, weight = measurements.stations[ping], measurements.weights[ping]
        place = measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping]
        reading = measurements.readings[ping] * hearing.scale
        foot = shape[1] * place[1] - shape[2] * place[0]
        for side in range(2):
            # How much farther past the end the foot of this ping lies than that of its station.
            further = feet[station] - foot if side == 0 else foot - feet[station]
            for index in range(len(OFFSETS)):
                over = OFFSETS[index] + further
                ratio = _log_ratio(hearing, shape, place, (side, over), reading, limits, noise, log_densities[ping])
                ratios[station, side, index] += weight * ratio
    return ratios


@compiled
def _log_ratio(
    hearing: Hearing,
    shape: Shape,
    place: Ping,
    end: tuple[int, float],
    measured: float,
    limits: tuple[float, float],
    noise: float,
    level: float,
) -> float:
    """Return what one reading says of a wall whose lower (0) or upper (1) end lies so far before the foot [nats]."""
    side, over = end
    beyond = -math.inf
    sight = diffracted(
        look(shape, place), over if side == 0 else beyond, over if side == 1 else beyond, hearing.wavelength
    )
    excess = excess_of(hearing, sight)
    expected = sight[0] + walk_of(hearing, excess)
    if not limits[0] <= expected <= limits[1]:
        return 0.0
    late, sigma = measured - expected, noise_of(excess, noise)
    ratio = max(log_density(late, sigma, excess) - level, 0.0)
    if late > BEYOND * sigma and expected < limits[1] - BEYOND * sigma:
        ratio += log_non_detection(excess if over <= 0.0 else excess - _JAMB)
    return ratio
