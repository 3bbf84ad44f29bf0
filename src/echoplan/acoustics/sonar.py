"""The sonar equation: by how much an echo exceeds the threshold, and what follows for angle and reach."""

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from echoplan.acoustics.air import Air
from echoplan.acoustics.beam import half_angle, ka_for, wavenumber
from echoplan.acoustics.echo import plane_echo
from echoplan.arrays import FloatArray
from echoplan.model import Sensor, Transducer

__all__ = ["audible_half_angle", "piston_ka", "reach", "signal_excess", "typical_transducer"]

# What a plane has to spare at the reach that a maker states: the reach is for ordinary objects.
_SPARE = 6.0
_FARTHEST = 100.0


def piston_ka(transducer: Transducer, air: Air) -> float:
    """Circumference of the piston in wavelengths, k a.

    Parameters
    ----------
    transducer : Transducer
        The transducer.
    air : Air
        What the sound travels in.

    Returns
    -------
    float
        Wavenumber times radius.

    Examples
    --------
    >>> round(piston_ka(Transducer(), Air()), 2)
    5.92
    """
    return float(wavenumber(transducer.frequency, air.speed_of_sound) * transducer.piston_radius)


def signal_excess(
    amplitude: ArrayLike, path_length: ArrayLike, *, transducer: Transducer, air: Air, beams: ArrayLike = 1.0
) -> FloatArray:
    """Signal excess of an echo: figure of merit + 20 lg A - alpha L + 20 lg(D_t D_r).

    For a plane, A = 1 / (2 r) and L = 2 r.  The echo is detected if the excess is positive.

    Parameters
    ----------
    amplitude : array_like
        Amplitude A of the echo by its law, relative to 1 m.
    path_length : array_like
        Length L of the way there and back [m].
    transducer : Transducer
        The transducer.
    air : Air
        What the sound travels in.
    beams : array_like, optional
        Product D_t D_r of the directivities on sending and on receiving.

    Returns
    -------
    ndarray of float64
        Height of the echo's peak above the threshold [dB]; ``-inf`` for silence.

    Examples
    --------
    >>> signal_excess(plane_echo([1.0, 4.0]), [2.0, 8.0], transducer=Transducer(), air=Air()).round(1)
    array([21.2,  1.3])
    """
    with np.errstate(divide="ignore"):
        gain = 20 * np.log10(np.abs(np.asarray(amplitude, dtype=np.float64) * np.asarray(beams, dtype=np.float64)))
    lost = air.absorption(transducer.frequency) * np.asarray(path_length, dtype=np.float64)
    excess: FloatArray = transducer.figure_of_merit + gain - lost
    return excess


def audible_half_angle(amplitude: ArrayLike, path_length: ArrayLike, *, transducer: Transducer, air: Air) -> FloatArray:
    """How far off its axis a sonar still detects an echo that returns along the path it took.

    Parameters
    ----------
    amplitude : array_like
        Amplitude of the echo by its law, relative to 1 m.
    path_length : array_like
        Length of the way there and back [m].
    transducer : Transducer
        The transducer.
    air : Air
        What the sound travels in.

    Returns
    -------
    ndarray of float64
        Half of the visible width [rad]; 0 for what is not detected even on the axis.

    Examples
    --------
    >>> angle = audible_half_angle(plane_echo(2.0), 4.0, transducer=Transducer(), air=Air())
    >>> float(np.degrees(angle).round(1))
    22.4
    """
    excess = signal_excess(amplitude, path_length, transducer=transducer, air=air)
    return half_angle(excess, piston_ka(transducer, air))


def reach(law: Callable[[float], ArrayLike], *, transducer: Transducer, air: Air) -> float:
    """Greatest distance at which a sonar detects an object on its axis.

    Parameters
    ----------
    law : callable
        The echo's amplitude at a distance [m], which must fall with it.
    transducer : Transducer
        The transducer.
    air : Air
        What the sound travels in.

    Returns
    -------
    float
        Distance [m], at most 100 m; 0 for what is never detected.

    Examples
    --------
    >>> round(reach(plane_echo, transducer=Transducer(), air=Air()), 1)
    4.3
    """
    from scipy.optimize import brentq  # noqa: PLC0415 - SciPy is slow to import

    def excess(distance: float) -> float:
        """Return the signal excess at a distance [m] in dB."""
        return float(signal_excess(law(distance), 2 * distance, transducer=transducer, air=air))

    if excess(1e-3) <= 0:
        return 0.0
    if excess(_FARTHEST) >= 0:
        return _FARTHEST
    return float(brentq(excess, 1e-3, _FARTHEST))


def typical_transducer(sensor: Sensor, *, frequency: float = 40_000.0) -> Transducer:
    """Guess the transducer behind the data sheet of a sensor.

    A maker states the reach for ordinary objects, so a plane at that distance is taken to have 6 dB to spare; and
    the opening angle is taken to be that within which a plane is detected at half the reach, in air of 20 degrees
    Celsius and 50 % humidity.

    Parameters
    ----------
    sensor : Sensor
        Values of the data sheet.
    frequency : float, optional
        Carrier [Hz].

    Returns
    -------
    Transducer
        Figure of merit and piston to match; the rest as usual.

    Examples
    --------
    >>> sensor = Sensor(sensor_id=0, half_aperture=0.61, min_range=0.03, max_range=3.0, resolution=0.005)
    >>> guess = typical_transducer(sensor)
    >>> round(guess.figure_of_merit, 1), round(guess.piston_radius * 1000, 1)
    (29.5, 6.0)
    """
    air = Air()
    lost = air.absorption(frequency) * 2 * sensor.max_range
    figure = _SPARE + 20 * np.log10(2 * sensor.max_range) + lost
    halfway = signal_excess(
        plane_echo(sensor.max_range / 2),
        sensor.max_range,
        transducer=Transducer(frequency=frequency, figure_of_merit=figure),
        air=air,
    )
    ka = ka_for(min(sensor.half_aperture, np.pi / 2), halfway)
    radius = float(ka / wavenumber(frequency, air.speed_of_sound))
    return Transducer(frequency=frequency, piston_radius=radius, figure_of_merit=float(figure))
