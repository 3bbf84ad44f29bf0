"""Echo laws: how strong the echo of an ideal reflector is, by geometrical acoustics.

Every law gives the pressure of the echo relative to that of the source at 1 m on its axis, without the absorption
of the air and without the beam.  Reflectors are hard and taller than the beam.
"""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray

__all__ = [
    "cylinder_echo",
    "plane_echo",
    "plate_echo",
    "strip_echo",
]


def plane_echo(distance: ArrayLike) -> FloatArray:
    """Echo of a plane: that of the source's mirror image, 1 / (2 r).

    Parameters
    ----------
    distance : array_like
        Perpendicular distance r [m].

    Returns
    -------
    ndarray of float64
        Amplitude relative to 1 m.

    Examples
    --------
    >>> float(plane_echo(1.0))
    0.5
    """
    amplitude: FloatArray = 0.5 / np.asarray(distance, dtype=np.float64)
    return amplitude


def cylinder_echo(distance: ArrayLike, radius: ArrayLike) -> FloatArray:
    """Echo of an upright cylinder: 1 / (2 r) sqrt(R / (R + r)), for radii of several wavelengths.

    Parameters
    ----------
    distance : array_like
        Distance of its surface r [m].
    radius : array_like
        Radius R [m].

    Returns
    -------
    ndarray of float64
        Amplitude relative to 1 m.

    Examples
    --------
    >>> float(cylinder_echo(1.0, 0.1).round(4))
    0.1508
    """
    bend = np.asarray(radius, dtype=np.float64)
    return plane_echo(distance) * np.sqrt(bend / (bend + np.asarray(distance, dtype=np.float64)))


def strip_echo(distance: ArrayLike, width: ArrayLike, *, wavelength: ArrayLike) -> FloatArray:
    """Echo of an upright strip seen face on: 1 / (2 r) min(1, w sqrt(2 / (lambda r))).

    Narrower than a Fresnel zone a strip scatters in proportion to its width; a wider one is a plane.

    Parameters
    ----------
    distance : array_like
        Distance r [m].
    width : array_like
        Width w [m].
    wavelength : array_like
        Wavelength lambda [m].

    Returns
    -------
    ndarray of float64
        Amplitude relative to 1 m.

    Examples
    --------
    >>> float(strip_echo(2.0, 0.0254, wavelength=0.0086).round(4))
    0.0685
    """
    return plane_echo(distance) * _filling(distance, width, wavelength)


def plate_echo(distance: ArrayLike, width: ArrayLike, height: ArrayLike, *, wavelength: ArrayLike) -> FloatArray:
    """Echo of a rectangular plate seen face on: the law of the strip in both directions.

    Parameters
    ----------
    distance : array_like
        Distance r [m].
    width, height : array_like
        Sides [m].
    wavelength : array_like
        Wavelength [m].

    Returns
    -------
    ndarray of float64
        Amplitude relative to 1 m.

    Examples
    --------
    >>> float(plate_echo(1.7, 0.033, 0.038, wavelength=0.0086).round(4))
    0.0505
    """
    return plane_echo(distance) * _filling(distance, width, wavelength) * _filling(distance, height, wavelength)


def _filling(distance: ArrayLike, width: ArrayLike, wavelength: ArrayLike) -> FloatArray:
    zone = np.sqrt(np.asarray(wavelength, dtype=np.float64) * np.asarray(distance, dtype=np.float64) / 2)
    return np.minimum(1.0, np.asarray(width, dtype=np.float64) / zone)
