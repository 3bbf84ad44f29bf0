"""Numbers in a wrong unit, as far as they give themselves away."""

from math import pi
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator

from echoplan.arrays import FloatArray
from echoplan.model import UNITS

__all__ = ["HalfAperture", "Lever", "Metres", "Radians", "looks_like_degrees", "possible_length_units"]


def looks_like_degrees(angles: ArrayLike) -> bool:
    """Tell whether angles are surely degrees.

    Radians may grow beyond a turn where they are not wrapped, but beyond two turns they are never all written
    to one decimal.  Small or finely divided angles in degrees do not give themselves away.

    Parameters
    ----------
    angles : array_like, shape (n,)
        Angles that should be radians.

    Returns
    -------
    bool
        True if some lie beyond two turns and all are multiples of a tenth.

    Examples
    --------
    >>> looks_like_degrees([-45.0, 0.0, 45.0]), looks_like_degrees([0.0, 1.6, 3.1, 4.7, 6.3])
    (True, False)
    """
    with np.errstate(over="ignore"):
        tenths = 10.0 * np.atleast_1d(np.asarray(angles, dtype=np.float64))
    beyond = np.abs(tenths).max(initial=0.0) > 10.0 * 4.0 * pi
    return bool(beyond and np.allclose(tenths, np.rint(tenths), rtol=0.0, atol=1e-6))


def possible_length_units(ranges: FloatArray, *, min_ranges: FloatArray, max_ranges: FloatArray) -> tuple[str, ...]:
    """Name the units in which readings may be, if they are surely no metres.

    Parameters
    ----------
    ranges : ndarray, shape (n,)
        Readings that should be metres.
    min_ranges, max_ranges : ndarray, shape (n,)
        Dead distance and reach of the sensor of each [m].

    Returns
    -------
    tuple of str
        Units as ``rig.toml`` has them, in which more than half of the readings lie within reach; empty if the readings
        may be metres: if one in twenty lies within reach, or the middle one less than twice beyond it.

    Examples
    --------
    >>> dead, reach = np.full(3, 0.2), np.full(3, 3.0)
    >>> possible_length_units(np.array([120.0, 45.5, 81.0]), min_ranges=dead, max_ranges=reach)
    ('cm', 'in')
    """
    heard = np.isfinite(ranges)
    readings, reaches = ranges[heard], max_ranges[heard]

    def share(metres: float) -> float:
        """Share of the readings within reach, if their unit has so many metres."""
        return float(np.mean((min_ranges[heard] <= readings * metres) & (readings * metres <= reaches)))

    if not heard.any() or share(1.0) > 0.05 or np.median(readings / reaches) <= 2.0:
        return ()
    return tuple(unit for unit, metres in UNITS.items() if share(metres) > 0.5)


def _checked_angle(angle: float) -> float:
    if looks_like_degrees([angle]):
        raise _degrees(angle)
    return angle


def _checked_aperture(angle: float) -> float:
    if angle > pi:
        raise _degrees(angle)
    return angle


def _degrees(angle: float) -> ValueError:
    return ValueError(f"{angle:g} looks like degrees; write radians: {np.deg2rad(angle):.6f}")


def _checked_length(length: float) -> float:
    if length > 50.0:
        raise ValueError(f"{length:g} m is farther than ultrasound is heard in air; write metres")
    return length


def _checked_lever(length: float) -> float:
    if abs(length) > 50.0:
        raise ValueError(f"{length:g} m is larger than a robot; write metres")
    return length


HalfAperture = Annotated[float, AfterValidator(_checked_aperture)]
Lever = Annotated[float, AfterValidator(_checked_lever)]
Radians = Annotated[float, AfterValidator(_checked_angle)]
Metres = Annotated[float, AfterValidator(_checked_length)]
