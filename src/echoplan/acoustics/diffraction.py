"""Diffraction at a straight edge by the uniform theory of Kouyoumjian and Pathak.

R. G. Kouyoumjian and P. H. Pathak, "A uniform geometrical theory of diffraction for an edge in a perfectly
conducting surface", Proc. IEEE 62 (1974) 1448, in its acoustically hard form.  Away from the boundaries of
reflection and shadow it becomes Keller's geometrical theory; across them it compensates the jump of the rays.
"""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import ComplexArray, FloatArray

__all__ = ["edge_echo", "fresnel_tail", "wedge_coefficient"]

# Directions nearer to a boundary than this are on it [rad]: half of the ray is there, and no diffraction.
_ON_BOUNDARY = 1e-9


def fresnel_tail(argument: ArrayLike) -> ComplexArray:
    """Auxiliary Fresnel functions f + j g, which fall from (1 + j) / 2 at 0 as 1 / (pi z).

    Abramowitz and Stegun 7.3.5 and 7.3.6.

    Parameters
    ----------
    argument : array_like
        z, not negative.

    Returns
    -------
    ndarray of complex128
        f(z) + j g(z).

    Examples
    --------
    >>> fresnel_tail([0.0, 10.0]).round(4)
    array([0.5   +5.e-01j, 0.0318+1.e-04j])
    """
    from scipy.special import wofz  # noqa: PLC0415 - SciPy is slow to import, and most commands diffract nothing

    z = np.asarray(argument, dtype=np.float64)
    turn = np.exp(0.25j * np.pi)
    tail: ComplexArray = turn / np.sqrt(2) * wofz(1j * turn * np.sqrt(np.pi / 2) * z)
    return tail


def wedge_coefficient(
    incident: ArrayLike,
    observed: ArrayLike,
    *,
    opening: ArrayLike,
    wavenumber: ArrayLike,
    distance_parameter: ArrayLike,
    reflection: tuple[ArrayLike, ArrayLike] = (1.0, 1.0),
) -> ComplexArray:
    """Diffraction coefficient of a wedge, Eq. 25 of Kouyoumjian and Pathak.

    Faces that do not reflect everything are weighted after Luebbers, IEEE Trans. Antennas Propag. 32 (1984) 70.

    Parameters
    ----------
    incident, observed : array_like
        Directions of source and receiver from the edge, counted from the first face into the air [rad].
    opening : array_like
        Angle of the air between the faces [rad]: 3 pi / 2 for the outside of a box, 2 pi for a thin wall's end.
    wavenumber : array_like
        Wavenumber [rad/m].
    distance_parameter : array_like
        Distance parameter s s' / (s + s') of the ways to and from the edge [m].
    reflection : tuple of array_like, optional
        Amplitude reflection coefficients of the first and the second face.

    Returns
    -------
    ndarray of complex128
        Coefficient [m^(1/2)], for time going as e^(j omega t).

    Examples
    --------
    >>> bisector = 0.75 * np.pi
    >>> coefficient = wedge_coefficient(
    ...     bisector, bisector, opening=1.5 * np.pi, wavenumber=732.3, distance_parameter=0.5
    ... )
    >>> float(abs(coefficient).round(4))
    0.0113
    """
    phi, phi0 = np.asarray(observed, dtype=np.float64), np.asarray(incident, dtype=np.float64)
    width = np.asarray(opening, dtype=np.float64)
    k = np.asarray(wavenumber, dtype=np.float64)
    kl = k * np.asarray(distance_parameter, dtype=np.float64)
    first, second = (np.asarray(face, dtype=np.float64) for face in reflection)
    # Inside a corner the rays beyond this boundary have met both faces; outside they are the direct ones.
    through = np.where(width < np.pi, first * second, 1.0)
    terms = through * (_term(np.pi + phi - phi0, width, kl) + _term(np.pi - phi + phi0, width, kl))
    terms = terms + first * _term(np.pi - phi - phi0, width, kl) + second * _term(np.pi + phi + phi0, width, kl)
    coefficient: ComplexArray = -np.exp(-0.25j * np.pi) / (2 * width / np.pi * np.sqrt(2 * np.pi * k)) * terms
    return coefficient


def edge_echo(distance: ArrayLike, *, angle: ArrayLike, opening: ArrayLike, wavenumber: ArrayLike) -> ComplexArray:
    """Echo that an edge sends back to where the sound came from: D / (r sqrt(2 r)).

    Parameters
    ----------
    distance : array_like
        Distance of the edge r [m].
    angle : array_like
        Direction of the sonar from the edge, counted from the first face into the air [rad].
    opening : array_like
        Angle of the air between the faces [rad].
    wavenumber : array_like
        Wavenumber [rad/m].

    Returns
    -------
    ndarray of complex128
        Amplitude relative to 1 m, for time going as e^(j omega t).

    Examples
    --------
    >>> echo = edge_echo(1.0, angle=0.75 * np.pi, opening=1.5 * np.pi, wavenumber=732.3)
    >>> round(float(20 * np.log10(abs(echo) / 0.5)))  # against a plane at the same distance [dB]
    -36
    """
    r = np.asarray(distance, dtype=np.float64)
    coefficient = wedge_coefficient(angle, angle, opening=opening, wavenumber=wavenumber, distance_parameter=r / 2)
    echo: ComplexArray = coefficient / (r * np.sqrt(2 * r))
    return echo


def _term(angle: FloatArray, opening: FloatArray, kl: FloatArray) -> ComplexArray:
    # cot(angle / 2n) F(k L a), written with the deviation from the nearest boundary so that 0 * inf never occurs.
    deviation = angle - 2 * opening * np.round(angle / (2 * opening))
    on_boundary = np.abs(deviation) < _ON_BOUNDARY
    safe = np.where(on_boundary, 1.0, deviation)
    leaning = np.where(on_boundary, 0.0, np.abs(np.sin(safe / 2)) / np.tan(safe * np.pi / (2 * opening)))
    z = 2 * np.sqrt(kl / np.pi) * np.abs(np.sin(deviation / 2))
    term: ComplexArray = 2 * np.sqrt(np.pi * kl) * leaning * fresnel_tail(z)
    return term
