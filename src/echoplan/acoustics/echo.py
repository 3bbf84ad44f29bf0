"""Echo laws: how strong the echo of an ideal reflector is, by geometrical acoustics.

Every law gives the pressure of the echo relative to that of the source at 1 m on its axis, without the absorption
of the air and without the beam.  Reflectors are hard and taller than the beam.
"""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray

__all__ = [
    "bistatic_cylinder_echo",
    "corner_echo",
    "cylinder_echo",
    "plane_echo",
    "plate_echo",
    "sphere_echo",
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


def corner_echo(distance: ArrayLike) -> FloatArray:
    """Echo of two planes that meet at a right angle, seen from within: as strong as that of a plane, 1 / (2 r).

    Two bounces make the source's image in the vertex, whatever the direction inside the quadrant.

    Parameters
    ----------
    distance : array_like
        Distance of the vertex r [m].

    Returns
    -------
    ndarray of float64
        Amplitude relative to 1 m.

    Examples
    --------
    >>> float(corner_echo(1.0))
    0.5
    """
    return plane_echo(distance)


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
    return plane_echo(distance) * np.sqrt(_curvature(distance, radius))


def sphere_echo(distance: ArrayLike, radius: ArrayLike) -> FloatArray:
    """Echo of a sphere: 1 / (2 r) R / (R + r).

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
    >>> float(sphere_echo(1.0, 0.1).round(4))
    0.0455
    """
    return plane_echo(distance) * _curvature(distance, radius)


def bistatic_cylinder_echo(
    incoming: ArrayLike, outgoing: ArrayLike, radius: ArrayLike, *, incidence: ArrayLike
) -> FloatArray:
    """Echo of an upright cylinder that is heard elsewhere than it was sent.

    The divergence of a ray bundle at a convex mirror: 1 / s1 sqrt(s1 / (s1 + s2)) sqrt(rho / (rho + s2)) with
    1 / rho = 1 / s1 + 2 / (R cos(i)); symmetric in s1 and s2.  Pierce, "Acoustics", section 8.5.

    Parameters
    ----------
    incoming, outgoing : array_like
        Lengths of the ways to the point of reflection and from it, s1 and s2 [m].
    radius : array_like
        Radius R [m].
    incidence : array_like
        Angle between either way and the normal, i [rad], less than a quarter turn.

    Returns
    -------
    ndarray of float64
        Amplitude relative to 1 m.

    Examples
    --------
    >>> float(bistatic_cylinder_echo(1.0, 1.0, 0.1, incidence=0.0).round(4))
    0.1508
    """
    s1, s2 = np.asarray(incoming, dtype=np.float64), np.asarray(outgoing, dtype=np.float64)
    bend = np.asarray(radius, dtype=np.float64) * np.cos(np.asarray(incidence, dtype=np.float64))
    amplitude: FloatArray = 1 / np.sqrt((s1 + s2) * (s1 + s2 + 2 * s1 * s2 / bend))
    return amplitude


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


def _curvature(distance: ArrayLike, radius: ArrayLike) -> FloatArray:
    bend = np.asarray(radius, dtype=np.float64)
    ratio: FloatArray = bend / (bend + np.asarray(distance, dtype=np.float64))
    return ratio


def _filling(distance: ArrayLike, width: ArrayLike, wavelength: ArrayLike) -> FloatArray:
    zone = np.sqrt(np.asarray(wavelength, dtype=np.float64) * np.asarray(distance, dtype=np.float64) / 2)
    return np.minimum(1.0, np.asarray(width, dtype=np.float64) / zone)
