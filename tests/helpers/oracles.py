"""Textbook formulas that only tests need: independent references of what the package computes otherwise."""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.acoustics import fresnel_tail
from echoplan.arrays import ComplexArray, FloatArray


def bistatic_cylinder_echo(
    incoming: ArrayLike, outgoing: ArrayLike, radius: ArrayLike, *, incidence: ArrayLike
) -> FloatArray:
    """Amplitude, relative to 1 m, of the echo of an upright cylinder whose source and receiver are apart.

    The divergence of a ray bundle at a convex mirror: 1 / s1 sqrt(s1 / (s1 + s2)) sqrt(rho / (rho + s2)) with
    1 / rho = 1 / s1 + 2 / (R cos(i)), path lengths s1 and s2 [m] and incidence i [rad].  Pierce, "Acoustics", 8.5.
    """
    s1, s2 = np.asarray(incoming, dtype=np.float64), np.asarray(outgoing, dtype=np.float64)
    bend = np.asarray(radius, dtype=np.float64) * np.cos(np.asarray(incidence, dtype=np.float64))
    amplitude: FloatArray = 1 / np.sqrt((s1 + s2) * (s1 + s2 + 2 * s1 * s2 / bend))
    return amplitude


def first_null(ka: ArrayLike) -> FloatArray:
    """Angle of the first null of a piston [rad]: sin(angle) = 3.832 / ka; a quarter turn if there is none."""
    return np.arcsin(np.minimum(3.8317059702075125 / np.asarray(ka, dtype=np.float64), 1.0))


def transition(argument: ArrayLike) -> ComplexArray:
    """Transition function F(x) of Kouyoumjian and Pathak, Eq. 27, for x that is not negative."""
    z = np.sqrt(2 * np.asarray(argument, dtype=np.float64) / np.pi)
    return np.pi * z * fresnel_tail(z)
