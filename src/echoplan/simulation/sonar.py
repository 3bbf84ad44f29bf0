"""Transducer and air as the ray tracer wants them: numbers, and special functions as tables."""

from typing import NamedTuple

import numpy as np

from echoplan.acoustics import directivity, fresnel_tail, piston_ka, wavenumber
from echoplan.arrays import ComplexArray, FloatArray
from echoplan.model import Transducer
from echoplan.simulation.settings import SimulationSettings

__all__ = ["Sonar", "build_sonar"]

# Echoes 40 dB below the threshold change the range of others by 0.1 mm where these are 10 dB above it.
_FLOOR = 0.01
# Linear interpolation in tables of this fineness is good to 1e-6.
_NODES = 4097


class Sonar(NamedTuple):
    """What the tracer knows of the transducer and the air.

    Attributes
    ----------
    gain : float
        Pressure at 1 m on the axis over the threshold.
    damping : float
        Absorption [1/m].
    speed, wavenumber : float
        Speed of sound [m/s] and wavenumber of the carrier [rad/m].
    floor : float
        Echoes fainter than this share of the threshold are left out.
    beam : ndarray, shape (n,)
        Directivity at even steps of the sine off the axis from 0 to 1.
    tail : ndarray of complex, shape (n,)
        ``fresnel_tail`` of z at even steps of z / (1 + z) from 0 to 1.
    order : int
        How often sound may be reflected.
    diffraction, crosstalk : bool
        Whether edges scatter, and whether sensors receive each other's bursts.
    """

    gain: float
    damping: float
    speed: float
    wavenumber: float
    floor: float
    beam: FloatArray
    tail: ComplexArray
    order: int
    diffraction: bool
    crosstalk: bool


def build_sonar(transducer: Transducer, settings: SimulationSettings) -> Sonar:
    """Prepare transducer and air for the ray tracer.

    Parameters
    ----------
    transducer : Transducer
        The transducer.
    settings : SimulationSettings
        The air and what is to be traced.

    Returns
    -------
    Sonar
        Numbers and tables.

    Examples
    --------
    >>> round(build_sonar(Transducer(), SimulationSettings()).gain, 2)
    31.26
    """
    air = settings.air
    sines = np.linspace(0.0, 1.0, _NODES)
    shares = sines[:-1]
    return Sonar(
        gain=10 ** (transducer.figure_of_merit / 20),
        damping=air.absorption(transducer.frequency) * np.log(10) / 20,
        speed=air.speed_of_sound,
        wavenumber=float(wavenumber(transducer.frequency, air.speed_of_sound)),
        floor=_FLOOR,
        beam=directivity(np.arcsin(sines), piston_ka(transducer, air)),
        tail=np.append(fresnel_tail(shares / (1 - shares)), 0.0),
        order=settings.reflection_order,
        diffraction=settings.diffraction,
        crosstalk=settings.crosstalk,
    )
