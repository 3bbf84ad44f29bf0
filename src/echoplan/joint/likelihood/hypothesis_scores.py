"""Scores of hypotheses: the log-likelihood ratio of a landmark, given what other landmarks explain."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, Shape, shape_of
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled, inlined
from echoplan.joint.likelihood.ping_scores import MASKING, PingScores
from echoplan.kernels import order_of
from echoplan.preprocessing.measurements import Measurements

__all__ = ["STRONGEST_MISS", "HypothesisScore", "Occluders", "missed", "rescore"]

_WALL, _CYLINDER, _ROUND = int(Kind.WALL), int(Kind.CYLINDER), int(Kind.ROUND)

# Lower bound of the log-likelihood ratio of one station [nats]: it may have stood behind an unmapped object.
STRONGEST_MISS = 12.0
# A station with fewer new detections per non-detection than this cannot contribute a positive value.
_LEAST_HITS = 0.67
# A detection is new at three times the density of the best other association; a non-detection counts if its log
# probability is below the second value [nats].
_ANEW, _MISSED = math.log(3.0), -0.1
# Margins of occluders: beyond the extent of a wall, and around a cylinder [m].
_MARGIN_WALL, _MARGIN_CYLINDER = 0.1, 0.02

# Station and weight of each ping, and centers of the stations [m].
_PingArrays: TypeAlias = tuple[IntArray, FloatArray, FloatArray]
# Pings, densities, misses and feet of ``PingScores``.
_ScoreArrays: TypeAlias = tuple[IntArray, FloatArray, FloatArray, FloatArray]


class Occluders(NamedTuple):
    """Accepted landmarks that may block a view."""

    # Kind and parameters, shape (f, 4).
    reflectors: FloatArray
    # Ends of walls along their lines [m], shape (f, 2).
    extents: FloatArray


class HypothesisScore(NamedTuple):
    """Log-likelihood ratio of a landmark."""

    # Log-likelihood ratio over the best associations without the landmark [nats].
    llr: float
    # Ends of a wall along its line [m]; 0 for other landmarks.
    low: float
    high: float
    # Contribution of each station [nats], shape (s,); 0 for stations outside the best run along a wall.
    llr_by_station: FloatArray


def rescore(
    measurements: Measurements,
    reflector: FloatArray,
    ping_scores: PingScores,
    log_densities: FloatArray,
    frame: Occluders,
    known: tuple[float, float] = (math.inf, -math.inf),
) -> HypothesisScore:
    """Return the log-likelihood ratio of a landmark, given the log densities of all readings without it.

    The best association counts, not the sum of all, so a duplicate of a wall gains nothing. For a wall, only the
    contiguous run of stations along it with the greatest sum counts; it determines the extent. ``known`` is the extent
    of the wall from marginalised stations [m].
    """
    # The arrays are passed one by one: counting the references to all arrays of ``Measurements`` takes longer than
    # scoring.
    ping_arrays = measurements.stations, measurements.weights, measurements.centers
    scores = ping_scores.pings, ping_scores.densities, ping_scores.misses, ping_scores.feet
    return HypothesisScore(
        *_judged(ping_arrays, reflector, scores, log_densities, (frame.reflectors, frame.extents), known)
    )


def missed(measurements: Measurements, ping_scores: PingScores, extent: tuple[float, float]) -> float:
    """Return the log probability of the non-detections of a landmark within ``extent`` [nats].

    The contribution of each station is bounded, since it may have stood behind an unmapped object.
    """
    within = (extent[0] <= ping_scores.feet) & (ping_scores.feet <= extent[1])
    misses = measurements.weights[ping_scores.pings] * ping_scores.misses * within
    by_station = np.bincount(measurements.stations[ping_scores.pings], misses)
    return float(np.maximum(by_station, -STRONGEST_MISS).sum())


@compiled
def _judged(
    ping_arrays: _PingArrays,
    reflector: FloatArray,
    scores: _ScoreArrays,
    log_densities: FloatArray,
    frame: tuple[FloatArray, FloatArray],
    known: tuple[float, float],
) -> tuple[float, float, float, FloatArray]:
    """Return total, low, high and contributions by station, as in ``HypothesisScore``."""
    llr_by_station = _by_station(ping_arrays, scores, log_densities)
    least = most = 0.0
    for llr in llr_by_station:
        least, most = min(least, llr), max(most, llr)
    if len(frame[0]) and least < -1.0 and most > 4.0:
        _excuse(llr_by_station, shape_of(reflector), ping_arrays[2], frame)
    if reflector[0] != _WALL:
        return llr_by_station.sum(), 0.0, 0.0, llr_by_station
    _best_run(ping_arrays[0], scores, llr_by_station, known)
    low, high = _extent(ping_arrays[0], scores, llr_by_station)
    return llr_by_station.sum(), low, high, llr_by_station


@inlined
def _by_station(ping_arrays: _PingArrays, scores: _ScoreArrays, log_densities: FloatArray) -> FloatArray:
    """Return the log-likelihood ratio of each station before the occlusion test [nats], shape (s,)."""
    stations, weights, centers = ping_arrays
    count = len(centers)
    llr_by_station, hits, misses = np.zeros(count), np.zeros(count), np.zeros(count)
    for ping, density, miss in zip(scores[0], scores[1], scores[2]):  # noqa: B905 - numba does not support strict zip
        station = stations[ping]
        llr_by_station[station] += weights[ping] * (max(density - log_densities[ping], 0.0) + miss)
        hits[station] += density > log_densities[ping] + _ANEW
        misses[station] += miss < _MISSED
    for station in range(count):
        llr_by_station[station] = max(llr_by_station[station], -STRONGEST_MISS)
        if hits[station] < _LEAST_HITS * misses[station]:
            llr_by_station[station] = min(llr_by_station[station], 0.0)
    return llr_by_station


@inlined
def _best_run(stations: IntArray, scores: _ScoreArrays, llr_by_station: FloatArray, known: tuple[float, float]) -> None:
    """Keep the contributions of the best contiguous run of stations along a wall, and set the others to zero."""
    count = len(llr_by_station)
    feet, pings = np.zeros(count), np.zeros(count)
    for ping, foot in zip(scores[0], scores[3]):  # noqa: B905 - numba does not support strict zip
        feet[stations[ping]] += foot
        pings[stations[ping]] += 1.0
    detected = 0
    for station in range(count):
        feet[station] = feet[station] / pings[station] if pings[station] else math.inf
        detected += pings[station] > 0
    order = order_of(feet)
    first, last = (
        _greatest_run(llr_by_station[order[:detected]])
        if known[0] > known[1]
        else _run_about(llr_by_station[order[:detected]], feet[order[:detected]], known)
    )
    for place in range(count):
        if not first <= place < last:
            llr_by_station[order[place]] = 0.0


@inlined
def _greatest_run(llr_by_station: FloatArray) -> tuple[int, int]:
    """Return the start and end index of the run with the greatest sum (Kadane's algorithm)."""
    best, first, last, start, total = 0.0, 0, 0, 0, 0.0
    for number in range(len(llr_by_station)):
        total += llr_by_station[number]
        if total <= 0.0:
            total, start = 0.0, number + 1
        elif total > best:
            best, first, last = total, start, number + 1
    return first, last


@inlined
def _run_about(llr_by_station: FloatArray, feet: FloatArray, known: tuple[float, float]) -> tuple[int, int]:
    """Return the run with the greatest sum among those that contain all stations within the known extent."""
    first, last = 0, 0
    for foot in feet:
        first += foot < known[0]
        last += foot < known[1]
    best = total = 0.0
    for number in range(first - 1, -1, -1):
        total += llr_by_station[number]
        if total > best:
            best, first = total, number
    best = total = 0.0
    for number in range(last, len(llr_by_station)):
        total += llr_by_station[number]
        if total > best:
            best, last = total, number + 1
    return first, last


@inlined
def _extent(stations: IntArray, scores: _ScoreArrays, llr_by_station: FloatArray) -> tuple[float, float]:
    """Return the range of feet along a wall [m] that contributing stations detected; zeros if there are none."""
    low, high = math.inf, -math.inf
    for ping, density, foot in zip(scores[0], scores[1], scores[3]):  # noqa: B905 - numba does not support strict zip
        if llr_by_station[stations[ping]] != 0.0 and density > 0.0:
            low, high = min(low, foot), max(high, foot)
    return (low, high) if low <= high else (0.0, 0.0)


@inlined
def _excuse(
    llr_by_station: FloatArray, shape: Shape, centers: FloatArray, frame: tuple[FloatArray, FloatArray]
) -> None:
    """Set negative contributions to zero for stations whose view of a landmark is occluded by an accepted one."""
    for other in range(len(frame[0])):
        screen, extent = shape_of(frame[0][other]), frame[1][other]
        for station in range(len(llr_by_station)):
            if llr_by_station[station] < 0.0:
                x, y = centers[station, 0], centers[station, 1]
                dx, dy = _view(shape, x, y)
                if _hides(screen, extent, (x, y, dx, dy)):
                    llr_by_station[station] = 0.0


@inlined
def _hides(screen: Shape, extent: FloatArray, way: tuple[float, float, float, float]) -> bool:
    """Return True if a wall or cylinder blocks a segment (x, y, dx, dy) [m]."""
    if screen[0] == _WALL:
        return _crosses(screen, extent, way)
    return screen[0] == _CYLINDER and _touches(screen, way)


@inlined
def _view(shape: Shape, x: float, y: float) -> tuple[float, float]:
    """Return the vector from a station to a point just before the landmark [m]."""
    if shape[0] == _WALL:
        way = 0.97 * (shape[3] - shape[1] * x - shape[2] * y)
        return way * shape[1], way * shape[2]
    dx, dy = shape[1] - x, shape[2] - y
    length = math.sqrt(dx * dx + dy * dy) + 1e-12
    # From inside, a round wall is behind the station.
    share = (length - shape[3] + MASKING if shape[0] == _ROUND else length - shape[3] - MASKING) / length
    return share * dx, share * dy


@inlined
def _crosses(wall: Shape, extent: FloatArray, way: tuple[float, float, float, float]) -> bool:
    """Return True if a segment (x, y, dx, dy) crosses a wall within its extent and a margin [m]."""
    x, y, dx, dy = way
    slope = wall[1] * dx + wall[2] * dy
    if abs(slope) < 1e-9:
        return False
    share = (wall[3] - wall[1] * x - wall[2] * y) / slope
    place = wall[1] * (y + share * dy) - wall[2] * (x + share * dx)
    return 0.0 < share < 1.0 and extent[0] - _MARGIN_WALL < place < extent[1] + _MARGIN_WALL


@inlined
def _touches(cylinder: Shape, way: tuple[float, float, float, float]) -> bool:
    """Return True if a segment (x, y, dx, dy) passes a cylinder within its radius and a margin [m]."""
    x, y, dx, dy = way
    ax, ay = cylinder[1] - x, cylinder[2] - y
    share = min(max((ax * dx + ay * dy) / max(dx * dx + dy * dy, 1e-9), 0.0), 1.0)
    distance = math.sqrt((ax - share * dx) ** 2 + (ay - share * dy) ** 2)
    return distance < cylinder[3] + _MARGIN_CYLINDER
