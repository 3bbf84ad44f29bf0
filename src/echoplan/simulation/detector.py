"""Echoes, and what trips on them, as the search for the threshold wants them."""

import math
from typing import NamedTuple

from echoplan.acoustics import peak_delay, time_constant
from echoplan.arrays import ComplexArray, FloatArray, IntArray
from echoplan.model import Transducer
from echoplan.simulation.settings import SimulationSettings

__all__ = ["Detector", "Echoes", "build_detector"]


class Echoes(NamedTuple):
    """Echoes of several pings, one after the other.

    Attributes
    ----------
    times : ndarray, shape (e,)
        Arrival after the ping was sent [s].
    strengths : ndarray of complex, shape (e,)
        Peak of the envelope over the threshold, with the phase of the carrier at time 0.
    reflectors : ndarray of int, shape (e,)
        Face, or cylinder counted on behind the faces, that alone reflected it; else -1.
    bounds : ndarray of int, shape (n + 1,)
        Echoes of ping i are ``bounds[i]`` to ``bounds[i + 1]``.
    """

    times: FloatArray
    strengths: ComplexArray
    reflectors: IntArray
    bounds: IntArray


class Detector(NamedTuple):
    """What trips on the echoes.

    Attributes
    ----------
    tau : float
        Time constant of the resonators [s].
    burst : float
        Length of the burst [time constants].
    peak_delay : float
        Time of the envelope's peak [s].
    peak : float
        Its height before it is scaled to 1.
    omega : float
        Angular frequency of the carrier [rad/s].
    coherent, carrier : bool
        Whether pressures add or powers, and whether the carrier must cross the threshold or its envelope.
    """

    tau: float
    burst: float
    peak_delay: float
    peak: float
    omega: float
    coherent: bool
    carrier: bool


def build_detector(transducer: Transducer, settings: SimulationSettings) -> Detector:
    """Prepare the detector.

    Parameters
    ----------
    transducer : Transducer
        What shapes the echoes.
    settings : SimulationSettings
        How they add and what trips.

    Returns
    -------
    Detector
        Numbers for the detector.

    Examples
    --------
    >>> round(build_detector(Transducer(), SimulationSettings()).tau * 1e6)
    159
    """
    tau = time_constant(transducer)
    burst = transducer.burst_cycles * math.pi / transducer.quality_factor
    at_peak = peak_delay(transducer) / tau
    rise = 1 - (1 + at_peak) * math.exp(-at_peak)
    fall = 1 - (1 + at_peak - burst) * math.exp(burst - at_peak)
    return Detector(
        tau=tau,
        burst=burst,
        peak_delay=at_peak * tau,
        peak=rise - fall,
        omega=2 * math.pi * transducer.frequency,
        coherent=settings.superposition == "coherent",
        carrier=settings.detector == "carrier",
    )
