"""Line evidence of stations: log-likelihood ratios of their pings as a function of where a wall ends."""

import math

import numpy as np

from echoplan.acoustics.predicted_echo import Ping, Shape, SonarTables, echo_geometry, excess_of, shape_of, walk_of
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.geometry import directions
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.ping_scores import BEYOND, log_density, log_non_detection, noise_of
from echoplan.joint.likelihood.track_history import LineEvidence
from echoplan.joint.optimisation.edge_diffraction import diffracted
from echoplan.preprocessing.measurements import Measurements

__all__ = ["OFFSETS", "line_evidence"]

# Distance of the end of a wall before the foot of a perpendicular (positive: the station stands past the end) [m]. One
# Fresnel zone before the end the echo has its full strength; 0.4 m past the end no sonar of this kind detects it.
OFFSETS = np.linspace(-0.10, 0.40, 26)
# Past the end of a wall the echo depends on the shape of the end: a screen and a wedge differ by this much [dB].
_JAMB = 6.0


def line_evidence(likelihood: PingLikelihood, wall: Hypothesis, count: int, log_densities: FloatArray) -> LineEvidence:
    """Return the line evidence of a wall from the first ``count`` stations, one row per station that could detect it.

    ``log_densities`` are those of the readings under their best association without the wall, shape (n,) [log 1/m].
    """
    measurements = likelihood.measurements
    pings = wall.ping_scores.pings[measurements.stations[wall.ping_scores.pings] < count]
    feet = measurements.centers[:count] @ directions(wall.line[0] + math.pi / 2)
    ratios = _log_ratios(measurements, likelihood.tables, wall.reflector, pings, log_densities, feet, likelihood.noise)
    asked = np.unique(measurements.stations[pings])
    return LineEvidence(feet[asked], measurements.centers[asked], ratios[asked])


@compiled
def _log_ratios(
    measurements: Measurements,
    tables: SonarTables,
    reflector: FloatArray,
    pings: IntArray,
    log_densities: FloatArray,
    feet: FloatArray,
    noise: float,
) -> FloatArray:
    """Return log-likelihood ratios of a wall with an end at each offset against no wall, shape (s, 2, m) [nats]."""
    shape, ratios = shape_of(reflector), np.zeros((len(feet), 2, len(OFFSETS)))
    limits = measurements.min_range * tables.scale, measurements.max_range * tables.scale
    for ping in pings:
        station, weight = measurements.stations[ping], measurements.weights[ping]
        place = measurements.x[ping], measurements.y[ping], measurements.ux[ping], measurements.uy[ping]
        reading = measurements.readings[ping] * tables.scale
        foot = shape[1] * place[1] - shape[2] * place[0]
        for side in range(2):
            # Distance of the foot of this ping past that of its station, as sensors are off the center of the robot.
            further = feet[station] - foot if side == 0 else foot - feet[station]
            for index in range(len(OFFSETS)):
                over = OFFSETS[index] + further
                ratio = _log_ratio(tables, shape, place, (side, over), reading, limits, noise, log_densities[ping])
                ratios[station, side, index] += weight * ratio
    return ratios


@inlined
def _log_ratio(
    tables: SonarTables,
    shape: Shape,
    place: Ping,
    end: tuple[int, float],
    measured: float,
    limits: tuple[float, float],
    noise: float,
    level: float,
) -> float:
    """Return the log-likelihood ratio of one reading for a wall against its best other association [nats].

    ``end`` holds which end of the wall is varied (0 lower, 1 upper) and how far it lies before the foot of the
    perpendicular [m]; ``level`` is the log density of the reading without the wall.
    """
    side, over = end
    beyond = -math.inf
    geometry = diffracted(
        echo_geometry(shape, place), over if side == 0 else beyond, over if side == 1 else beyond, tables.wavelength
    )
    excess = excess_of(tables, geometry)
    expected = geometry[0] + walk_of(tables, excess)
    if not limits[0] <= expected <= limits[1]:
        return 0.0
    late, sigma = measured - expected, noise_of(excess, noise)
    ratio = max(log_density(late, sigma, excess) - level, 0.0)
    if late > BEYOND * sigma and expected < limits[1] - BEYOND * sigma:
        ratio += log_non_detection(excess if over <= 0.0 else excess - _JAMB)
    return ratio
