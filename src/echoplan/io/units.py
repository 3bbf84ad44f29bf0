"""What numbers in files can be: their physical bounds, and wrong units where the numbers reveal them."""

from math import pi
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, Field

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.model import UNITS

__all__ = [
    "FARTHEST",
    "LARGEST_ANGLE",
    "WIDEST",
    "Coordinate",
    "Cycles",
    "Decibels",
    "Deviation",
    "HalfAperture",
    "Hertz",
    "Lever",
    "Metres",
    "Period",
    "Radians",
    "Radius",
    "Step",
    "Variance",
    "check_extent",
    "looks_like_degrees",
    "possible_length_units",
]

# No place is farther from the origin than half around the earth: coordinates of surveyors (UTM) fit.
FARTHEST = 20_000_000.0
# No robot turns so often in one recording, and beyond it the digits of an angle are those of its turns.
LARGEST_ANGLE = 100_000.0
# No building is wider; what memory and time grow with has an end.
WIDEST = 10_000.0


def looks_like_degrees(angles: ArrayLike) -> bool:
    """Return whether angles are surely degrees.

    Radians may grow beyond a turn where they are not wrapped, but beyond two turns they are never all written
    to one decimal.  Small or finely divided angles in degrees are not recognised.

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


def possible_length_units(
    ranges: FloatArray, *, min_ranges: FloatArray, max_ranges: FloatArray, unit: float = 1.0
) -> tuple[str, ...]:
    """Name the units in which readings may be, if they are surely not in the one they should be in.

    Parameters
    ----------
    ranges : ndarray, shape (n,)
        Readings as recorded.
    min_ranges, max_ranges : ndarray, shape (n,)
        Dead distance and reach of the sensor of each [m].
    unit : float, optional
        What they should be in [m].

    Returns
    -------
    tuple of str
        Units as ``rig.toml`` has them, in which more than half of the readings lie within reach; empty if the readings
        may be in the one they should be in: if one in twenty lies within reach, or the middle one less than twice
        beyond it.

    Examples
    --------
    >>> dead, reach = np.full(3, 0.2), np.full(3, 3.0)
    >>> possible_length_units(np.array([120.0, 45.5, 81.0]), min_ranges=dead, max_ranges=reach)
    ('cm', 'in')
    """
    detected = np.isfinite(ranges)
    readings, reaches = ranges[detected], max_ranges[detected]

    def share(metres: float) -> float:
        """Share of the readings within reach, if their unit has so many metres."""
        return float(np.mean((min_ranges[detected] <= readings * metres) & (readings * metres <= reaches)))

    if not detected.any() or share(unit) > 0.05 or np.median(unit * readings / reaches) <= 2.0:
        return ()
    return tuple(unit for unit, metres in UNITS.items() if share(metres) > 0.5)


def _checked_angle(angle: float) -> float:
    if abs(angle) > LARGEST_ANGLE:
        raise ValueError(f"{angle:g} rad is more than {LARGEST_ANGLE:g} rad; write radians within a few turns")
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
        raise ValueError(f"{length:g} m is beyond the range of ultrasound in air; write metres")
    return length


def _checked_lever(length: float) -> float:
    if abs(length) > 50.0:
        raise ValueError(f"{length:g} m is larger than a robot; write metres")
    return length


def check_extent(points_xy: ArrayLike, *, name: str) -> None:
    """Refuse what is wider than any building.

    Parameters
    ----------
    points_xy : array_like, shape (n, 2)
        Points [m].
    name : str
        Of what they are.

    Raises
    ------
    InvalidValueError
        If they lie too far from each other.
    """
    points = np.asarray(points_xy, dtype=np.float64).reshape(-1, 2)
    width = float(np.ptp(points, axis=0).max()) if len(points) else 0.0
    if width > WIDEST:
        raise InvalidValueError(
            f"{name} is {width:g} m wide, and {WIDEST:g} m are the most; correct its farthest point"
        )


def _not_finer_than(least: float) -> AfterValidator:
    def check(value: float) -> float:
        """Refuse a positive value below the limit, and return any other."""
        # What is not positive the model refuses.
        if 0.0 < value < least:
            raise ValueError(f"{value:g} is finer than any device; write at least {least:g}")
        return value

    return AfterValidator(check)


Coordinate = Annotated[float, Field(ge=-FARTHEST, le=FARTHEST)]
Radius = Annotated[float, Field(le=WIDEST)]
# No servo turns by less than a second of arc [rad], and no sonar fires faster than a microsecond [s].
Step = Annotated[float, Field(le=100.0), _not_finer_than(1e-6)]
Period = Annotated[float, Field(le=60.0), _not_finer_than(1e-6)]
# Beyond ten megahertz sound ends within a millimetre of air.
Hertz = Annotated[float, Field(le=1e7)]
# Levels of loud and of faint senders differ by some 100 dB, and bursts have some ten cycles.
Decibels = Annotated[float, Field(ge=-300.0, le=300.0)]
Cycles = Annotated[float, Field(le=10_000.0)]
# Dead reckoning that is off by more knows nothing [m, rad].
Deviation = Annotated[float, Field(le=100.0)]
# Of a coordinate anywhere on earth [m²].
Variance = Annotated[float, Field(ge=-(FARTHEST**2), le=FARTHEST**2)]
HalfAperture = Annotated[float, AfterValidator(_checked_aperture)]
Lever = Annotated[float, AfterValidator(_checked_lever)]
Radians = Annotated[float, AfterValidator(_checked_angle)]
Metres = Annotated[float, AfterValidator(_checked_length)]
