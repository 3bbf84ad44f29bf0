"""Evidence: what every ping says for and against a reflector, and what it adds to what is known already."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.echo_model import COSINE_LIMIT
from echoplan.acoustics.expectation import Hearing, Kind, Shape, Sight, excess_of, look, shape_of, walk_of
from echoplan.acoustics.views import in_view, views_of
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.preprocessing.soundings import Soundings

__all__ = ["NO_EVIDENCE", "UNCERTAIN", "UNHEARD", "Evidence", "Frame", "Verdict", "audibility", "judge", "weigh"]

_WALL, _CYLINDER = int(Kind.WALL), int(Kind.CYLINDER)

# Logarithm of a density that is none.
UNHEARD = -99.0

# Echoes fade into noise over this many decibels about the threshold (logistic).
_FADING = 1.2
# Fainter than this nothing is expected [dB].
_INAUDIBLE = -4.0
# Below this excess a detector scatters more, by this factor [dB].
UNCERTAIN, _SCATTER = 6.0, 1.6
# Readings within so many deviations may be echoes of the reflector; later by so many, it was not heard.
_NEAR, _BEYOND = 6.0, 4.0
# Chance to hear even the loudest echo, and chance that a reading is wrong whatever is there.
_HEARD, _WRONG = 0.97, 0.06
# From this excess on a miss cannot count for more [dB, nats].
_SURE, _SURE_MISS = _FADING * math.log((1.0 - _WRONG) / (_HEARD - 1.0 + _WRONG)), math.log(_WRONG)
# Readings earlier than expected by more than this come from something nearer that masks the reflector [m].
_MASKING = 0.03
_ROOT_TAU = math.sqrt(2.0 * math.pi)

# One station speaks against a reflector no louder than this [nats]: a robot may have stood behind something.
_LOUDEST_NO = 12.0
# A station that misses a reflector more often than it hears it anew does not speak for it.
_LEAST_HITS = 0.67
# A hit explains a ping three times better than anything so far; a miss is one that could hardly be chance.
_ANEW, _MISSED = math.log(3.0), -0.1
# Walls reach this far beyond what was heard of them [m], cylinders are this much thicker, when they block a view.
_MARGIN_WALL, _MARGIN_CYLINDER = 0.1, 0.02


class Evidence(NamedTuple):
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
NO_EVIDENCE = Evidence(
    np.zeros(0, np.int64), np.zeros(0), np.zeros(0), np.zeros(0, np.bool_), np.zeros(0, np.bool_), np.zeros(0)
)


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


@compiled
def audibility(excess: float) -> float:
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
def weigh(soundings: Soundings, hearing: Hearing, reflector: FloatArray, noise: float) -> Evidence:
    """Ask all pings about a reflector.

    A ping speaks for it by the density of its reading about the one expected, and against it if it should have heard
    it and heard something farther away or nothing.  Readings of something nearer say nothing: it may be masked.

    Parameters
    ----------
    soundings : Soundings
        The pings.
    hearing : Hearing
        The sonar.
    reflector : ndarray, shape (4,)
        Kind and parameters.
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    Evidence
        Of the pings that could hear it.
    """
    count, shape = len(soundings.readings), shape_of(reflector)
    pings = np.empty(count, np.int64)
    densities, misses, feet = np.empty(count), np.empty(count), np.zeros(count)
    audible, unmasked = np.empty(count, np.bool_), np.empty(count, np.bool_)
    limits = soundings.min_range * hearing.scale, soundings.max_range * hearing.scale
    kept, views = 0, views_of(hearing, shape, _INAUDIBLE, limits[1])
    for ping in range(count):
        view = soundings.x[ping], soundings.y[ping], soundings.ux[ping], soundings.uy[ping]
        if not in_view(views, shape, view):
            continue
        heard, audible[kept], unmasked[kept], densities[kept], misses[kept] = _ask(
            hearing, look(shape, view), soundings.readings[ping] * hearing.scale, limits, noise
        )
        if not heard:
            continue
        pings[kept] = ping
        if shape[0] == _WALL:
            feet[kept] = shape[1] * soundings.y[ping] - shape[2] * soundings.x[ping]
        kept += 1
    return Evidence(
        pings[:kept].copy(),
        densities[:kept].copy(),
        misses[:kept].copy(),
        audible[:kept].copy(),
        unmasked[:kept].copy(),
        feet[:kept].copy(),
    )


@compiled
def _ask(
    hearing: Hearing, sight: Sight, heard: float, limits: tuple[float, float], noise: float
) -> tuple[bool, bool, bool, float, float]:
    """Ask one ping: whether it could hear the reflector, should hear it, was not masked; its hit and its miss."""
    if sight[1] < COSINE_LIMIT or sight[0] <= 0.0 or sight[0] > limits[1]:
        return False, False, False, 0.0, 0.0
    excess = excess_of(hearing, sight)
    reading = sight[0] + walk_of(hearing, excess)
    if excess <= _INAUDIBLE or not limits[0] <= reading <= limits[1]:
        return False, False, False, 0.0, 0.0
    late = heard - reading
    scatter = noise * _SCATTER if excess < UNCERTAIN else noise
    within = reading < limits[1] - _BEYOND * scatter
    miss = _miss(excess) if late > _BEYOND * scatter else 0.0
    return True, within and excess > 0.0, late > -_MASKING, _density(late, scatter, excess), within * miss


@compiled
def _density(late: float, scatter: float, excess: float) -> float:
    if abs(late) >= _NEAR * scatter:
        return UNHEARD
    return math.log(audibility(excess) / (_ROOT_TAU * scatter)) - 0.5 * (late / scatter) ** 2


@compiled
def _miss(excess: float) -> float:
    return _SURE_MISS if excess > _SURE else math.log(max(1.0 - _HEARD * audibility(excess), _WRONG))


@compiled
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
    gains = _by_station(soundings, evidence, levels)
    if len(frame.reflectors) and gains.min() < -1.0 and gains.max() > 4.0:
        blocked = _blocked(shape_of(reflector), soundings.centers, frame)
        for station in range(len(gains)):
            if blocked[station]:
                gains[station] = max(gains[station], 0.0)
    if reflector[0] != _WALL:
        return Verdict(gains.sum(), 0.0, 0.0, gains)
    _best_run(soundings, evidence, gains, known)
    low, high = _extent(soundings, evidence, gains)
    return Verdict(gains.sum(), low, high, gains)


@compiled
def _by_station(soundings: Soundings, evidence: Evidence, levels: FloatArray) -> FloatArray:
    count = len(soundings.centers)
    gains, hits, misses = np.zeros(count), np.zeros(count), np.zeros(count)
    for number, ping in enumerate(evidence.pings):
        station, density, miss = soundings.stations[ping], evidence.densities[number], evidence.misses[number]
        gains[station] += soundings.weights[ping] * (max(density - levels[ping], 0.0) + miss)
        hits[station] += density > levels[ping] + _ANEW
        misses[station] += miss < _MISSED
    for station in range(count):
        gains[station] = max(gains[station], -_LOUDEST_NO)
        if hits[station] < _LEAST_HITS * misses[station]:
            gains[station] = min(gains[station], 0.0)
    return gains


@compiled
def _best_run(soundings: Soundings, evidence: Evidence, gains: FloatArray, known: tuple[float, float]) -> None:
    """Keep the gains of the best run of stations along a wall, and clear the others."""
    count = len(gains)
    feet, pings = np.zeros(count), np.zeros(count)
    for number, ping in enumerate(evidence.pings):
        feet[soundings.stations[ping]] += evidence.feet[number]
        pings[soundings.stations[ping]] += 1.0
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
def _extent(soundings: Soundings, evidence: Evidence, gains: FloatArray) -> tuple[float, float]:
    """Find the ends of what was heard of a wall from the stations that count."""
    low, high = math.inf, -math.inf
    for number, ping in enumerate(evidence.pings):
        if gains[soundings.stations[ping]] != 0.0 and evidence.densities[number] > 0.0:
            low, high = min(low, evidence.feet[number]), max(high, evidence.feet[number])
    return (low, high) if low <= high else (0.0, 0.0)


@compiled
def _blocked(shape: Shape, centers: FloatArray, frame: Frame) -> BoolArray:
    """Whether an accepted feature lies between each station and the reflector."""
    blocked = np.zeros(len(centers), np.bool_)
    for station in range(len(centers)):
        x, y = centers[station, 0], centers[station, 1]
        dx, dy = _view(shape, x, y)
        for other in range(len(frame.reflectors)):
            screen, extent = shape_of(frame.reflectors[other]), frame.extents[other]
            way = (x, y, dx, dy)
            if screen[0] == _WALL:
                blocked[station] |= _crosses(screen, extent, way)
            elif screen[0] == _CYLINDER:
                blocked[station] |= _touches(screen, way)
    return blocked


@compiled
def _view(shape: Shape, x: float, y: float) -> tuple[float, float]:
    """Return the way from a station to just before the reflector."""
    if shape[0] == _WALL:
        way = 0.97 * (shape[3] - shape[1] * x - shape[2] * y)
        return way * shape[1], way * shape[2]
    dx, dy = shape[1] - x, shape[2] - y
    length = math.sqrt(dx * dx + dy * dy) + 1e-12
    share = (length - shape[3] - _MASKING) / length
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
