"""The beam of a circular piston in a baffle: how loud it sends, and how sensitive it is, off its axis.

``ka`` is the circumference of the piston in wavelengths: wavenumber times radius.
"""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray

__all__ = ["directivity", "half_angle", "ka_for", "two_way_loss", "wavenumber"]

_FIRST_ZERO = 3.831705970207512  # of the Bessel function J1
_NODES = 16_385


def wavenumber(frequency: ArrayLike, speed_of_sound: ArrayLike) -> FloatArray:
    """Wavenumber k = 2 pi f / c.

    Parameters
    ----------
    frequency : array_like
        Frequency [Hz].
    speed_of_sound : array_like
        Speed of sound [m/s].

    Returns
    -------
    ndarray of float64
        Wavenumber [rad/m].

    Examples
    --------
    >>> round(float(wavenumber(40_000.0, 344.0)), 1)
    730.6
    """
    speed = np.asarray(speed_of_sound, dtype=np.float64)
    return 2 * np.pi * np.asarray(frequency, dtype=np.float64) / speed


def directivity(angles: ArrayLike, ka: ArrayLike) -> FloatArray:
    """Directivity of a circular piston in a rigid baffle: 2 J1(x) / x with x = ka sin(angle).

    Kinsler et al., "Fundamentals of Acoustics", 4th ed., Eq. 7.4.17.  The baffle leaves nothing behind it.

    Parameters
    ----------
    angles : array_like
        Angles off the axis [rad].
    ka : array_like
        Wavenumber times radius.

    Returns
    -------
    ndarray of float64
        Pressure relative to the axis, negative in every second side lobe, 0 behind.

    Examples
    --------
    >>> directivity(np.radians([0.0, 18.4, 90.0, 120.0]), 5.13).round(2)
    array([ 1.  ,  0.71, -0.13,  0.  ])
    """
    off = np.asarray(angles, dtype=np.float64)
    x = np.asarray(ka, dtype=np.float64) * np.sin(off)
    return np.where(np.cos(off) > -1e-12, _piston(x), 0.0)


def two_way_loss(angles: ArrayLike, ka: ArrayLike) -> FloatArray:
    """Loss of an echo that leaves and returns at the same angle off the axis.

    Parameters
    ----------
    angles : array_like
        Angles off the axis [rad].
    ka : array_like
        Wavenumber times radius.

    Returns
    -------
    ndarray of float64
        Loss against the axis [dB], not negative; ``inf`` in a null and behind.

    Examples
    --------
    >>> float(two_way_loss(np.radians(16.0), 5.86).round(1))
    6.0
    """
    with np.errstate(divide="ignore"):
        loss: FloatArray = -40 * np.log10(np.abs(directivity(angles, ka)))
    return loss + 0.0


def half_angle(loss: ArrayLike, ka: ArrayLike) -> FloatArray:
    """Angle off the axis at which the two-way loss of the main lobe reaches a value.

    Parameters
    ----------
    loss : array_like
        Two-way loss [dB]; a signal excess gives the angle up to which its echo is detected.
    ka : array_like
        Wavenumber times radius.

    Returns
    -------
    ndarray of float64
        Angle [rad]: 0 for a loss below 0, a quarter turn where the loss is not reached in front.

    Examples
    --------
    >>> np.degrees(half_angle([6.0, 20.0], 4.39)).round(1)
    array([21.6, 38.5])
    """
    return np.arcsin(np.minimum(_argument(loss) / np.asarray(ka, dtype=np.float64), 1.0))


def ka_for(angle: ArrayLike, loss: ArrayLike) -> FloatArray:
    """Piston whose main lobe has a given two-way loss at a given angle.

    Parameters
    ----------
    angle : array_like
        Angle off the axis [rad], at most a quarter turn.
    loss : array_like
        Two-way loss [dB].

    Returns
    -------
    ndarray of float64
        Wavenumber times radius.

    Examples
    --------
    >>> float(ka_for(np.radians(38.4), 20.0).round(2))
    4.4
    """
    return _argument(loss) / np.sin(np.asarray(angle, dtype=np.float64))


def _piston(x: FloatArray) -> FloatArray:
    from scipy.special import j1  # noqa: PLC0415 - SciPy is slow to import, and most commands ask for no beam

    safe = np.where(np.abs(x) < 1e-6, 1.0, x)
    pattern: FloatArray = np.where(np.abs(x) < 1e-6, 1.0, 2 * j1(safe) / safe)
    return pattern


def _argument(loss: ArrayLike) -> FloatArray:
    # The x of the main lobe whose two-way loss this is.  The square of x is a smooth function of the pattern,
    # at the axis too, so that linear interpolation is good to 1e-7.
    x = np.linspace(0.0, _FIRST_ZERO, _NODES)
    pattern = 10 ** (-np.maximum(np.asarray(loss, dtype=np.float64), 0.0) / 40)
    return np.sqrt(np.interp(pattern, _piston(x)[::-1], x[::-1] ** 2))
