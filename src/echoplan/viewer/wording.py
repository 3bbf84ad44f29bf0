"""Numbers as people read them, with their units."""

import math

import numpy as np
from numpy.typing import ArrayLike

__all__ = ["SIGMA", "decimal", "in_degrees", "in_metres", "in_millimetres", "in_percent", "plural", "point"]

# The standard deviation; as a letter of the source it looks like an o.
SIGMA = "\N{GREEK SMALL LETTER SIGMA}"


def decimal(value: float, digits: int) -> str:
    """Write a number.

    Parameters
    ----------
    value : float
        The number.
    digits : int
        Digits after the point.

    Returns
    -------
    str
        The number; what rounds to zero has no sign.

    Examples
    --------
    >>> decimal(-0.0001, 3)
    '0.000'
    """
    return f"{value:z.{digits}f}"


def in_metres(value: float) -> str:
    """Write a length to the millimetre.

    Parameters
    ----------
    value : float
        Length [m].

    Returns
    -------
    str
        In metres.
    """
    return f"{decimal(value, 3)} m"


def in_millimetres(value: float) -> str:
    """Write a small length.

    Parameters
    ----------
    value : float
        Length [m].

    Returns
    -------
    str
        In millimetres.

    Examples
    --------
    >>> in_millimetres(0.00512)
    '5.1 mm'
    """
    return f"{decimal(1000 * value, 1)} mm"


def in_degrees(value: float, *, digits: int = 1) -> str:
    """Write an angle.

    Parameters
    ----------
    value : float
        Angle [rad].
    digits : int, optional
        Digits after the point.

    Returns
    -------
    str
        In degrees.
    """
    return f"{decimal(math.degrees(value), digits)}°"


def in_percent(share: float) -> str:
    """Write a share.

    Parameters
    ----------
    share : float
        Between 0 and 1.

    Returns
    -------
    str
        In per cent, without the sign.
    """
    return decimal(100 * share, 0)


def point(point_xy: ArrayLike) -> str:
    """Write a point.

    Parameters
    ----------
    point_xy : array_like, shape (2,)
        The point [m].

    Returns
    -------
    str
        Both coordinates in metres.

    Examples
    --------
    >>> point([1.0, -2.5])
    '(1.000, -2.500) m'
    """
    x, y = (decimal(value, 3) for value in np.asarray(point_xy, dtype=np.float64))
    return f"({x}, {y}) m"


def plural(count: int, noun: str) -> str:
    """Count things.

    Parameters
    ----------
    count : int
        How many.
    noun : str
        What, in the singular.

    Returns
    -------
    str
        Number and noun.

    Examples
    --------
    >>> plural(1, "ping"), plural(2, "ping")
    ('1 ping', '2 pings')
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
