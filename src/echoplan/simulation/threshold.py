"""The instant at which the sum of all echoes of a ping first reaches the threshold, in machine code.

The envelope is that of ``echoplan.acoustics.burst_envelope``.  Importing this module imports numba, which takes its
time: import it where it is used.
"""

import math
from typing import NamedTuple

import numpy as np

from echoplan.arrays import ComplexArray, FloatArray
from echoplan.compiled import compiled, inlined
from echoplan.simulation.detector import Detector, Echoes

__all__ = ["first_crossings"]

# The envelope is looked at sixteen times in a time constant, and a crossing between two looks is found by halving.
_LOOKS = 16
_HALVINGS = 24
# Time constants after which a burst has died away.
_SPAN = 20.0


class _Signal(NamedTuple):
    times: FloatArray
    strengths: ComplexArray


@compiled
def first_crossings(detector: Detector, echoes: Echoes, openings: FloatArray, deadlines: FloatArray) -> FloatArray:
    """Find when each ping's threshold is first reached.

    Parameters
    ----------
    detector : Detector
        What trips.
    echoes : Echoes
        What n pings receive, in the order of time within each.
    openings, deadlines : ndarray, shape (n,)
        When each ping begins and ceases to listen [s].

    Returns
    -------
    ndarray, shape (n,)
        Instants after the pings [s]; ``-inf`` if the threshold is exceeded when listening begins, ``inf`` if never.
    """
    instants = np.empty(len(openings))
    for ping in range(len(openings)):
        begin, end = echoes.bounds[ping], echoes.bounds[ping + 1]
        signal = _Signal(echoes.times[begin:end], echoes.strengths[begin:end])
        if _level(detector, signal, openings[ping]) >= 1:
            instants[ping] = -np.inf
        elif detector.carrier:
            instants[ping] = _first_crest(detector, signal, openings[ping], deadlines[ping])
        else:
            instants[ping] = _first_rise(detector, signal, openings[ping], deadlines[ping])
    return instants


@inlined
def _first_crest(detector: Detector, signal: _Signal, begin: float, end: float) -> float:
    # The carrier trips on the first crest after the envelope has risen above the threshold, if it is still there.
    while True:
        risen = _first_rise(detector, signal, begin, end)
        if risen == np.inf:
            return np.inf
        phase = np.angle(_pressure(detector, signal, risen)) + detector.omega * risen
        crest = risen + (-phase % (2 * math.pi)) / detector.omega
        height = _level(detector, signal, crest)
        if height >= 1:
            return max(risen, crest - math.acos(1 / height) / detector.omega)
        begin = crest


@inlined
def _first_rise(detector: Detector, signal: _Signal, begin: float, end: float) -> float:
    for last in range(len(signal.times)):
        following = signal.times[last + 1] if last + 1 < len(signal.times) else np.inf
        stop = min(following, end)
        bound = _bound(detector, signal, last)
        if bound >= 1 and begin < stop:
            risen = _search(detector, signal, (max(signal.times[last], begin), stop), (signal.times[last], bound))
            if risen < np.inf:
                return risen
    return np.inf


@inlined
def _bound(detector: Detector, signal: _Signal, last: int) -> float:
    # The most that the echoes up to the last one can add up to before the next one arrives.
    total = 0.0
    for echo in range(last, -1, -1):
        if signal.times[last] - signal.times[echo] > _SPAN * detector.tau:
            break
        total += abs(signal.strengths[echo])
    return total


@inlined
def _search(detector: Detector, signal: _Signal, window: tuple[float, float], newest: tuple[float, float]) -> float:
    (low, stop), (arrival, bound), step = window, newest, detector.tau / _LOOKS
    if _level(detector, signal, low) >= 1:
        return low
    while low < stop:
        high = min(low + step, stop)
        if _level(detector, signal, high) >= 1:
            return _halve(detector, signal, low, high)
        # Once the last echo has passed its peak all of them fade, and at least as fast as it does.
        if high > arrival + detector.peak_delay and bound * _envelope(detector, high - arrival) < 1:
            break
        low = high
    return np.inf


@inlined
def _halve(detector: Detector, signal: _Signal, low: float, high: float) -> float:
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        if _level(detector, signal, middle) >= 1:
            high = middle
        else:
            low = middle
    return high


@inlined
def _level(detector: Detector, signal: _Signal, time: float) -> float:
    if detector.coherent:
        return abs(_pressure(detector, signal, time))
    power = 0.0
    for echo in range(len(signal.times)):
        if signal.times[echo] >= time:
            break
        power += (abs(signal.strengths[echo]) * _envelope(detector, time - signal.times[echo])) ** 2
    return math.sqrt(power)


@inlined
def _pressure(detector: Detector, signal: _Signal, time: float) -> complex:
    total = 0j
    for echo in range(len(signal.times)):
        if signal.times[echo] >= time:
            break
        total += signal.strengths[echo] * _envelope(detector, time - signal.times[echo])
    return total


@inlined
def _envelope(detector: Detector, since: float) -> float:
    x = since / detector.tau
    if x <= 0 or x >= _SPAN:
        return 0.0
    rise = 1 - (1 + x) * math.exp(-x)
    x -= detector.burst
    return (rise if x <= 0 else rise - 1 + (1 + x) * math.exp(-x)) / detector.peak
