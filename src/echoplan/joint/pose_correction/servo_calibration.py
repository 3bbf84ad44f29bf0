"""Servo calibration: gain and offset for which the arcs of all stations and sensors agree, before any search.

A hobby servo turns a few percent less or more than commanded, and its horn is off by some degrees. Ranges hardly depend
on that; the directions of arcs do. With the right gain and offset as many arcs as possible of different stations lie on
common planes or about common points.
"""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.geometry import directions, rotation_step
from echoplan.joint.arcs import arc_planes
from echoplan.joint.estimate import Estimate
from echoplan.joint.optimisation.optimiser import OptimiserSettings
from echoplan.joint.search.refinement import refine
from echoplan.preprocessing.measurements import Measurements
from echoplan.preprocessing.servo import ServoError

__all__ = ["find_servo"]

# Standard deviations of the normal of a complete arc, of one that is cut off, and of the depth, including headings of
# stations placed by hand: on simulated heads of gain 1 arcs scatter by 2 degrees, headings by 3 [rad, rad, m].
_WHOLE, _CUT, _DEPTH = math.radians(3.0), math.radians(6.0), 0.02
# Share of arcs of landmarks that no other station detected.
_ALONE = 0.3
# Grid of gains and offsets [rad], in steps of about the standard deviation that 30 arcs achieve.
_GAINS, _OFFSETS = np.linspace(0.85, 1.15, 13), np.radians(np.linspace(-14.0, 14.0, 15))
# Arcs farther from each other than this are not of one landmark [sigmas].
_FAR = 6.0
# A gap of this many steps without a ping is the end of a sweep.
_GAP = 3.0
# Log-likelihood ratio of positive evidence [nats] (Kass and Raftery 1995): trying a calibrated servo in vain costs only
# time.
_POSITIVE = 1.0
# Minimum number of arcs that determine gain and offset.
_FEWEST = 10
# Standard deviation of readings and gate on residuals when a plane is fitted to a single arc [m].
_SINGLE_ARC = (0.006, 0.03)


class _Planes(NamedTuple):
    """Planes that explain single arcs."""

    # Index of the station, shape (a,).
    stations: IntArray
    # Axis of the servo, and vector from it to the acoustic centre, as complex numbers [m], shape (a,).
    hubs: FloatArray
    arms: FloatArray
    # Normal angle of the plane and its distance from the acoustic centre [rad, m], shape (a,).
    normals: FloatArray
    depths: FloatArray
    # Recorded servo angle [rad], shape (a,).
    angles: FloatArray
    # Weight, up to 1, shape (a,).
    weights: FloatArray
    # Standard deviations of the normals [rad], shape (a,).
    sigmas: FloatArray


def find_servo(estimate: Estimate) -> ServoError | None:
    """Return the most likely gain and offset of the servo, or None without evidence that recorded angles are wrong."""
    if not estimate.has_servo or len(estimate.arcs) < _FEWEST:
        return None
    planes = _planes_of(estimate)
    scores = posterior(planes, estimate.recorded.max_range, estimate.settings.optimiser)
    gain, offset = np.unravel_index(np.argmax(scores), scores.shape)
    as_recorded = scores[len(_GAINS) // 2, len(_OFFSETS) // 2]
    if scores[gain, offset] < as_recorded + _POSITIVE:
        return None
    return ServoError(float(_GAINS[gain]), float(_OFFSETS[offset]))


def posterior(planes: _Planes, reach: float, settings: OptimiserSettings) -> FloatArray:
    """Return the log posterior density of gains (rows) and offsets (columns), up to a constant [nats]."""
    scores = np.array([[_log_likelihood(planes, reach, gain, offset) for offset in _OFFSETS] for gain in _GAINS])
    found: FloatArray = scores - settings.servo_strain(_GAINS[:, None], _OFFSETS)
    return found


def _planes_of(estimate: Estimate) -> _Planes:
    """Fit a plane to each arc; the normal is less certain for an arc that is cut off by the end of a sweep."""
    measurements, tables = estimate.recorded, estimate.model.tabulated()
    ends = _ends(measurements)
    rows = []
    for arc, plane in zip(estimate.arcs, arc_planes(estimate.arcs, measurements, tables), strict=True):
        wall = np.array([Kind.WALL, *plane, 0.0])
        wall = refine(measurements, tables, wall, arc.pings, _SINGLE_ARC, 4)
        center = np.array([measurements.x[arc.pings].mean(), measurements.y[arc.pings].mean()])
        arm = np.array([measurements.arms_x[arc.pings].mean(), measurements.arms_y[arc.pings].mean()])
        depth = wall[2] - center @ directions(wall[1])
        sigma = _CUT if ends[arc.pings].any() else _WHOLE
        weight = min(1.0, measurements.weights[arc.pings].sum() / 8.0)
        rows.append((*(center - arm), *arm, wall[1], depth, measurements.angles[arc.pings].mean(), weight, sigma))
    x, y, arms_x, arms_y, normals, depths, angles, weights, sigmas = np.array(rows).T.copy()
    return _Planes(
        stations=np.array([arc.station for arc in estimate.arcs]),
        hubs=x + 1j * y,
        arms=arms_x + 1j * arms_y,
        normals=normals,
        depths=depths,
        angles=angles,
        weights=weights,
        sigmas=sigmas,
    )


def _ends(measurements: Measurements) -> BoolArray:
    """Return which pings are the first or the last of a sweep, in the order of their bearings around a station."""
    ends = np.zeros(len(measurements.readings), dtype=bool)
    for station in np.unique(measurements.stations):
        own = np.flatnonzero(measurements.stations == station)
        around = own[np.argsort(measurements.bearings[own])]
        gaps = np.diff(measurements.bearings[around], append=measurements.bearings[around[:1]] + 2.0 * np.pi)
        wide = gaps > _GAP * rotation_step(measurements.bearings[own])
        ends[around[wide]] = ends[np.roll(around, -1)[wide]] = True
    return ends


@compiled
def _log_likelihood(planes: _Planes, reach: float, gain: float, offset: float) -> float:
    """Return the log-likelihood of the arcs: each is near an arc of another station, or anywhere.

    Each of two arcs of one landmark explains the other, so both are counted half.
    """
    turns = offset + (gain - 1.0) * planes.angles
    places = planes.hubs + planes.arms * np.exp(1j * turns)
    normals = np.exp(1j * (planes.normals + turns))
    depths, sigmas = planes.depths, planes.sigmas
    anywhere, total = 1.0 / (2.0 * math.pi * reach), 0.0
    densities, others = np.zeros(len(turns)), np.zeros(len(turns))
    for one in range(len(turns)):
        for other in range(one):
            if planes.stations[one] != planes.stations[other]:
                others[one] += 1.0
                others[other] += 1.0
                away = places[one] - places[other]
                pair = normals[one], normals[other]
                both, each = (depths[one], depths[other]), (sigmas[one], sigmas[other])
                wall, point = _of_one_wall(away, pair, both, each), _of_one_point(away, pair, both, each)
                densities[one] += max(wall, depths[one] * point)
                densities[other] += max(wall, depths[other] * point)
    for one in range(len(turns)):
        likely = _ALONE + (1.0 - _ALONE) * densities[one] / (max(others[one], 1.0) * anywhere)
        total += 0.5 * planes.weights[one] * math.log(likely)
    return total


@inlined
def _of_one_wall(
    away: complex, normals: tuple[complex, complex], depths: tuple[float, float], sigmas: tuple[float, float]
) -> float:
    """Return the density of an arc if it is of the same wall as another one of uncertain normal [1/(rad m)]."""
    turned, variance = np.angle(normals[0] * normals[1].conjugate()), sigmas[0] ** 2 + sigmas[1] ** 2
    if turned**2 > _FAR**2 * variance:
        return 0.0
    # The most likely common normal, and the distance of the planes along it.
    share = sigmas[0] ** 2 / variance
    middle = normals[0] * np.exp(-1j * share * turned)
    apart = away * middle.conjugate()
    nearer = depths[0] - depths[1] + apart.real
    between = 2.0 * _DEPTH**2 + share * sigmas[1] ** 2 * apart.imag**2
    exponent = 0.5 * turned**2 / variance + 0.5 * nearer**2 / between
    return math.exp(-exponent) / (2.0 * math.pi * math.sqrt(variance * between))


@inlined
def _of_one_point(
    away: complex, normals: tuple[complex, complex], depths: tuple[float, float], sigmas: tuple[float, float]
) -> float:
    """Return the density of an arc if it is of the same point as another one [1/m^2]; times its depth, [1/(rad m)]."""
    apart = away + depths[0] * normals[0] - depths[1] * normals[1]
    if abs(apart) > _FAR * (_DEPTH + sigmas[0] * depths[0] + sigmas[1] * depths[1]):
        return 0.0
    xx, xy, yy = 0.0, 0.0, 0.0
    for normal, depth, sigma in zip(normals, depths, sigmas):  # noqa: B905 - numba does not support strict
        along, across = _DEPTH**2, (sigma * depth) ** 2
        xx += along * normal.real**2 + across * normal.imag**2
        yy += along * normal.imag**2 + across * normal.real**2
        xy += (along - across) * normal.real * normal.imag
    determinant = xx * yy - xy**2
    square = (yy * apart.real**2 - 2.0 * xy * apart.real * apart.imag + xx * apart.imag**2) / determinant
    return math.exp(-0.5 * square) / (2.0 * math.pi * math.sqrt(determinant))
