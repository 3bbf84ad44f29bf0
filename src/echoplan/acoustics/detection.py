"""Detection by a threshold: what shape an echo has when it reaches the comparator, and when it trips it.

A burst of n cycles passes the resonator of the sender and that of the receiver.  Both have the time constant
tau = Q / (pi f), so a step of carrier comes out as 1 - (1 + t / tau) e^(-t / tau) and a burst as that step less the
same step one burst later.  A weak echo trips the threshold later on this slope than a strong one: its range is
read too long.  The closed forms below invert the slope by Lambert's W.
"""

import math

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import BoolArray, FloatArray
from echoplan.model import Transducer

__all__ = ["burst_envelope", "carrier_delay", "crossing_delay", "peak_delay", "range_walk", "time_constant"]


def time_constant(transducer: Transducer) -> float:
    """Time constant of each resonator, Q / (pi f).

    Parameters
    ----------
    transducer : Transducer
        The transducer.

    Returns
    -------
    float
        Time constant [s].

    Examples
    --------
    >>> round(time_constant(Transducer()) * 1e6)
    159
    """
    return float(transducer.quality_factor / (np.pi * transducer.frequency))


def peak_delay(transducer: Transducer) -> float:
    """Time from the arrival of an echo to the peak of its envelope.

    Parameters
    ----------
    transducer : Transducer
        The transducer.

    Returns
    -------
    float
        Delay [s].

    Examples
    --------
    >>> round(peak_delay(Transducer()) * 1e6)
    280
    """
    length = _burst_length(transducer)
    return float(time_constant(transducer) * length / -np.expm1(-length))


def burst_envelope(times: ArrayLike, transducer: Transducer) -> FloatArray:
    """Envelope of an echo at the comparator.

    Parameters
    ----------
    times : array_like
        Time since the echo arrived [s].
    transducer : Transducer
        The transducer.

    Returns
    -------
    ndarray of float64
        Envelope relative to its peak; 0 before the arrival.

    Examples
    --------
    >>> burst_envelope([-1e-4, 1e-4, 2.8e-4, 1e-3], Transducer()).round(2)
    array([0.  , 0.3 , 1.  , 0.06])
    """
    since = np.asarray(times, dtype=np.float64) / time_constant(transducer)
    envelope: FloatArray = (_step(since) - _step(since - _burst_length(transducer))) / _peak(transducer)
    return envelope


def crossing_delay(excess: ArrayLike, transducer: Transducer) -> FloatArray:
    """Time from the arrival of an echo until its envelope reaches the threshold.

    Parameters
    ----------
    excess : array_like
        Signal excess: how far the peak of the envelope lies above the threshold [dB].
    transducer : Transducer
        The transducer.

    Returns
    -------
    ndarray of float64
        Delay [s]; ``inf`` where the threshold is not reached.

    Examples
    --------
    >>> (crossing_delay([30.0, 10.0, 0.0, -1.0], Transducer()) * 1e6).round()
    array([ 28., 103., 280.,  inf])
    """
    above = np.asarray(excess, dtype=np.float64)
    length = _burst_length(transducer)
    level = 10 ** (-np.maximum(above, 0.0) / 20) * _peak(transducer)
    # During the burst: (1 + x) e^-x = 1 - level.
    rising = -1 - _lambert(-(1 - np.minimum(level, _step(length))) / math.e, branch=-1)
    # After it: e^-x (growth (1 + x) - length e^length) = level, with growth = e^length - 1.
    growth = np.expm1(length)
    lead = length * np.exp(length) / growth
    after = lead - 1 - _lambert(-level / growth * np.exp(lead - 1), branch=0)
    delay = time_constant(transducer) * np.where(level <= _step(length), rising, after)
    return np.where(above >= 0, delay, np.inf)


def carrier_delay(excess: ArrayLike, transducer: Transducer) -> FloatArray:
    """Time from the arrival of an echo until its carrier itself reaches the threshold.

    A comparator without a rectifier trips on the first crest that is high enough, so that the delay jumps by whole
    periods of the carrier as the echo grows weaker.

    Parameters
    ----------
    excess : array_like
        Signal excess [dB].
    transducer : Transducer
        The transducer.

    Returns
    -------
    ndarray of float64
        Delay [s]; ``inf`` where the threshold is not reached.

    Examples
    --------
    >>> (carrier_delay([30.0, 20.0, 10.0, -1.0], Transducer()) * 1e6).round()
    array([ 45.,  71., 122.,  inf])
    """
    reached = crossing_delay(excess, transducer)
    crest = np.ceil(np.where(np.isfinite(reached), reached, 0.0) * transducer.frequency) / transducer.frequency
    height = 10 ** (np.asarray(excess, dtype=np.float64) / 20) * burst_envelope(crest, transducer)
    early = np.arccos(1 / np.maximum(height, 1.0)) / (2 * np.pi * transducer.frequency)
    tripped: BoolArray = np.isfinite(reached) & (height >= 1)
    return np.where(tripped, np.maximum(crest - early, reached), np.inf)


def range_walk(excess: ArrayLike, *, reference: ArrayLike, transducer: Transducer, speed_of_sound: float) -> FloatArray:
    """How much too long the range of an echo is read, against the echo for which the module was set right.

    Parameters
    ----------
    excess : array_like
        Signal excess of the echo [dB].
    reference : array_like
        Signal excess of the echo whose range is read right [dB].
    transducer : Transducer
        The transducer.
    speed_of_sound : float
        With which the module turns time into range [m/s].

    Returns
    -------
    ndarray of float64
        Extra range [m], negative for louder echoes; ``inf`` for echoes below the threshold.

    Examples
    --------
    >>> walk = range_walk([18.8, 5.1], reference=21.2, transducer=Transducer(), speed_of_sound=344.0)
    >>> (walk * 1000).round(1)
    array([ 1.4, 17.3])
    """
    late = crossing_delay(excess, transducer) - crossing_delay(reference, transducer)
    walk: FloatArray = 0.5 * speed_of_sound * late
    return walk


def _burst_length(transducer: Transducer) -> float:
    # In time constants.
    return float(transducer.burst_cycles * np.pi / transducer.quality_factor)


def _lambert(argument: FloatArray, *, branch: int) -> FloatArray:
    from scipy.special import lambertw  # noqa: PLC0415 - SciPy is slow to import

    inside = np.maximum(argument, -np.exp(-1) * (1 - 1e-15))  # rounding must not push it past the branch point
    value: FloatArray = lambertw(inside, branch).real
    return value


def _step(since: ArrayLike) -> FloatArray:
    x = np.maximum(np.asarray(since, dtype=np.float64), 0.0)
    response: FloatArray = -np.expm1(-x) - x * np.exp(-x)
    return response


def _peak(transducer: Transducer) -> float:
    length = _burst_length(transducer)
    since = peak_delay(transducer) / time_constant(transducer)
    return float(_step(since) - _step(since - length))
