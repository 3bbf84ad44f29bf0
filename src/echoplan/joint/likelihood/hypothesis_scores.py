"""Verdicts: what the evidence for a reflector amounts to beside all that is known already."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import Kind, Shape, shape_of
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.joint.likelihood.ping_scores import MASKING, Evidence
from echoplan.preprocessing.ping_arrays import Soundings

__all__ = ["Frame", "Verdict", "judge", "missed"]

_WALL, _CYLINDER = int(Kind.WALL), int(Kind.CYLINDER)

# One station speaks against a reflector no louder than this [nats]: a robot may have stood behind something.
_LOUDEST_NO = 12.0
# A station that misses a reflector more often than it hears it anew does not speak for it.
_LEAST_HITS = 0.67
# A hit explains a ping three times better than anything so far; a miss is one that could hardly be chance.
_ANEW, _MISSED = math.log(3.0), -0.1
# Walls reach this far beyond what was heard of them [m], cylinders are this much thicker, when they block a view.
_MARGIN_WALL, _MARGIN_CYLINDER = 0.1, 0.02

# Of pings and stations: which station each is from, and how much it counts; where stations are.
_Heard: TypeAlias = tuple[IntArray, FloatArray, FloatArray]
# Of evidence: pings, densities, misses and feet.
_Told: TypeAlias = tuple[IntArray, FloatArray, FloatArray, FloatArray]


class Frame(NamedTuple):
    """Accepted features, as far as they can block a view.

    Attributes
    ----------
    reflectors : ndarray, shape (f, 4)
        Kind and parameters.
    extents : ndarray, shape (f, 2)
        Ends of walls along them [m].
    """

    reflectors: FloatArray
    extents: FloatArray


class Verdict(NamedTuple):
    """What the evidence for a reflector amounts to.

    Attributes
    ----------
    total : float
        Gain in log likelihood over what explains the pings without it [nats].
    low, high : float
        Ends of a wall along it [m]; 0 for other reflectors.
    gains : ndarray, shape (s,)
        The gain by station [nats]; 0 for stations that do not face this part of a wall.
    """

    total: float
    low: float
    high: float
    gains: FloatArray


def judge(
    soundings: Soundings,
    reflector: FloatArray,
    evidence: Evidence,
    levels: FloatArray,
    frame: Frame,
    known: tuple[float, float] = (math.inf, -math.inf),
) -> Verdict:
    """Sum up the evidence for a reflector, given what explains the pings without it.

    The better explanation counts, not the sum of both: a second copy of a wall explains nothing.  Of a wall, the best
    run of stations along it counts, and gives its extent.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    reflector : ndarray, shape (4,)
        Kind and parameters.
    evidence : Evidence
        What the pings say about it.
    levels : ndarray, shape (n,)
        Logarithm of the density of each reading by what explains it so far [log 1/m].
    frame : Frame
        The other features.
    known : tuple of float, optional
        Ends of what is known of a wall from other stations [m].

    Returns
    -------
    Verdict
        Gain, extent and gains by station.
    """
    # Handed over one by one: to count the references to all arrays of soundings takes longer than to judge.
    heard = soundings.stations, soundings.weights, soundings.centers
    told = evidence.pings, evidence.densities, evidence.misses, evidence.feet
    return Verdict(*_judged(heard, reflector, told, levels, (frame.reflectors, frame.extents), known))


def missed(soundings: Soundings, evidence: Evidence, extent: tuple[float, float]) -> float:
    """Sum up how unlikely it is that pings missed a reflector that is there.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    evidence : Evidence
        What they say about it.
    extent : tuple of float
        Ends of a wall along it, beyond which it may not go on [m]; 0 for other reflectors.

    Returns
    -------
    float
        Logarithm of the chance [nats]; no station counts for more than one that stood behind something.
    """
    within = (extent[0] <= evidence.feet) & (evidence.feet <= extent[1])
    misses = soundings.weights[evidence.pings] * evidence.misses * within
    by_station = np.bincount(soundings.stations[evidence.pings], misses)
    return float(np.maximum(by_station, -_LOUDEST_NO).sum())


@compiled
def _judged(
    heard: _Heard,
    reflector: FloatArray,
    told: _Told,
    levels: FloatArray,
    frame: tuple[FloatArray, FloatArray],
    known: tuple[float, float],
) -> tuple[float, float, float, FloatArray]:
    gains = _by_station(heard, told, levels)
    if len(frame[0]) and gains.min() < -1.0 and gains.max() > 4.0:
        _excuse(gains, shape_of(reflector), heard[2], frame)
    if reflector[0] != _WALL:
        return gains.sum(), 0.0, 0.0, gains
    _best_run(heard[0], told, gains, known)
    low, high = _extent(heard[0], told, gains)
    return gains.sum(), low, high, gains


@compiled
def _by_station(heard: _Heard, told: _Told, levels: FloatArray) -> FloatArray:
    stations, weights, centers = heard
    count = len(centers)
    gains, hits, misses = np.zeros(count), np.zeros(count), np.zeros(count)
    for ping, density, miss in zip(told[0], told[1], told[2]):  # noqa: B905 - numba knows no strict zip
        station = stations[ping]
        gains[station] += weights[ping] * (max(density - levels[ping], 0.0) + miss)
        hits[station] += density > levels[ping] + _ANEW
        misses[station] += miss < _MISSED
    for station in range(count):
        gains[station] = max(gains[station], -_LOUDEST_NO)
        if hits[station] < _LEAST_HITS * misses[station]:
            gains[station] = min(gains[station], 0.0)
    return gains


@compiled
def _best_run(stations: IntArray, told: _Told, gains: FloatArray, known: tuple[float, float]) -> None:
    """Keep the gains of the best run of stations along a wall, and clear the others."""
    count = len(gains)
    feet, pings = np.zeros(count), np.zeros(count)
    for ping, foot in zip(told[0], told[3]):  # noqa: B905 - numba knows no strict zip
        feet[stations[ping]] += foot
        pings[stations[ping]] += 1.0
    feet = np.where(pings > 0, feet / np.maximum(pings, 1.0), np.inf)
    order = np.argsort(feet)[: int((pings > 0).sum())]
    first, last = _greatest_run(gains[order]) if known[0] > known[1] else _run_about(gains[order], feet[order], known)
    kept = gains[order[first:last]]
    gains[:] = 0.0
    gains[order[first:last]] = kept


@compiled
def _greatest_run(gains: FloatArray) -> tuple[int, int]:
    """Find the run of the greatest sum (Kadane), from the first to before the last."""
    best, first, last, start, total = 0.0, 0, 0, 0, 0.0
    for number in range(len(gains)):
        total += gains[number]
        if total <= 0.0:
            total, start = 0.0, number + 1
        elif total > best:
            best, first, last = total, start, number + 1
    return first, last


@compiled
def _run_about(gains: FloatArray, feet: FloatArray, known: tuple[float, float]) -> tuple[int, int]:
    """Find the run of the greatest sum that takes in all that is known of a wall: nobody is left out who faces it."""
    first, last = int(np.searchsorted(feet, known[0])), int(np.searchsorted(feet, known[1]))
    best = total = 0.0
    for number in range(first - 1, -1, -1):
        total += gains[number]
        if total > best:
            best, first = total, number
    best = total = 0.0
    for number in range(last, len(gains)):
        total += gains[number]
        if total > best:
            best, last = total, number + 1
    return first, last


@compiled
def _extent(stations: IntArray, told: _Told, gains: FloatArray) -> tuple[float, float]:
    """Find the ends of what was heard of a wall from the stations that count."""
    low, high = math.inf, -math.inf
    for ping, density, foot in zip(told[0], told[1], told[3]):  # noqa: B905 - numba knows no strict zip
        if gains[stations[ping]] != 0.0 and density > 0.0:
            low, high = min(low, foot), max(high, foot)
    return (low, high) if low <= high else (0.0, 0.0)


@compiled
def _excuse(gains: FloatArray, shape: Shape, centers: FloatArray, frame: tuple[FloatArray, FloatArray]) -> None:
    """Let no station speak against a reflector that an accepted feature hides from it."""
    for other in range(len(frame[0])):
        screen, extent = shape_of(frame[0][other]), frame[1][other]
        for station in range(len(gains)):
            if gains[station] < 0.0:
                x, y = centers[station, 0], centers[station, 1]
                dx, dy = _view(shape, x, y)
                if _hides(screen, extent, (x, y, dx, dy)):
                    gains[station] = 0.0


@compiled
def _hides(screen: Shape, extent: FloatArray, way: tuple[float, float, float, float]) -> bool:
    if screen[0] == _WALL:
        return _crosses(screen, extent, way)
    return screen[0] == _CYLINDER and _touches(screen, way)


@compiled
def _view(shape: Shape, x: float, y: float) -> tuple[float, float]:
    """Return the way from a station to just before the reflector."""
    if shape[0] == _WALL:
        way = 0.97 * (shape[3] - shape[1] * x - shape[2] * y)
        return way * shape[1], way * shape[2]
    dx, dy = shape[1] - x, shape[2] - y
    length = math.sqrt(dx * dx + dy * dy) + 1e-12
    share = (length - shape[3] - MASKING) / length
    return share * dx, share * dy


@compiled
def _crosses(wall: Shape, extent: FloatArray, way: tuple[float, float, float, float]) -> bool:
    x, y, dx, dy = way
    slope = wall[1] * dx + wall[2] * dy
    if abs(slope) < 1e-9:
        return False
    share = (wall[3] - wall[1] * x - wall[2] * y) / slope
    place = wall[1] * (y + share * dy) - wall[2] * (x + share * dx)
    return 0.0 < share < 1.0 and extent[0] - _MARGIN_WALL < place < extent[1] + _MARGIN_WALL


@compiled
def _touches(cylinder: Shape, way: tuple[float, float, float, float]) -> bool:
    x, y, dx, dy = way
    ax, ay = cylinder[1] - x, cylinder[2] - y
    share = min(max((ax * dx + ay * dy) / max(dx * dx + dy * dy, 1e-9), 0.0), 1.0)
    distance = math.sqrt((ax - share * dx) ** 2 + (ay - share * dy) ** 2)
    return distance < cylinder[3] + _MARGIN_CYLINDER
