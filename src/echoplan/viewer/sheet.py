"""Sheets: where a map lies on paper, at a scale that people know, y up."""

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, checked_floats, store

__all__ = ["Sheet", "round_up"]

# What is left of A4 between its margins [mm], and the empty border of the drawing.
_WIDEST, _HIGHEST = 190.0, 277.0
_BORDER, _FOOT = 10.0, 12.0

# Lines of the grid, and so the scale bar, are at least this far apart [mm].
_GRID = 25.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Sheet:
    """A drawing of a piece of the map; its unit is the millimetre on paper.

    Parameters
    ----------
    bounds_xy : ndarray, shape (2, 2)
        Lower left and upper right corner of what is drawn [m].
    """

    bounds_xy: FloatArray

    def __post_init__(self) -> None:
        store(self, bounds_xy=checked_floats(self.bounds_xy, name="bounds_xy", shape=(2, 2)))

    @property
    def scale(self) -> float:
        """How many times the world is greater than the drawing: 1, 2, 2.5 or 5 times a power of ten."""
        wide, high = 1000 * np.ptp(self.bounds_xy, axis=0)
        return round_up(max(wide / (_WIDEST - 2 * _BORDER), high / (_HIGHEST - 2 * _BORDER - _FOOT)), (1, 2, 2.5, 5))

    @property
    def millimetres(self) -> float:
        """Length of a metre on paper [mm]."""
        return 1000 / self.scale

    @property
    def size(self) -> FloatArray:
        """Width and height [mm], shape (2,)."""
        wide, high = self.millimetres * np.ptp(self.bounds_xy, axis=0)
        return np.array([wide + 2 * _BORDER, high + 2 * _BORDER + _FOOT])

    @property
    def grid(self) -> float:
        """Distance between the lines of the grid [m]: 1, 2 or 5 times a power of ten."""
        return round_up(_GRID / self.millimetres, (1, 2, 5))

    @property
    def lines(self) -> tuple[FloatArray, FloatArray]:
        """Where the lines of the grid cross the x and the y axis [m]."""
        low, high = np.ceil(self.bounds_xy[0] / self.grid - 1e-9), np.floor(self.bounds_xy[1] / self.grid + 1e-9)
        x, y = (self.grid * np.arange(first, last + 1) for first, last in zip(low, high, strict=True))
        return x, y

    def paper(self, points_xy: ArrayLike) -> FloatArray:
        """Take points of the map to the drawing.

        Parameters
        ----------
        points_xy : array_like, shape (..., 2)
            Points [m].

        Returns
        -------
        ndarray, shape (..., 2)
            Right and down from the upper left corner [mm].

        Examples
        --------
        >>> Sheet(bounds_xy=np.array([[0.0, 0.0], [3.0, 2.0]])).paper([0.0, 2.0])
        array([10., 10.])
        """
        low, high = self.bounds_xy
        x, y = np.moveaxis(np.asarray(points_xy, dtype=np.float64), -1, 0)
        return _BORDER + self.millimetres * np.stack([x - low[0], high[1] - y], axis=-1)


def round_up(value: float, digits: tuple[float, ...]) -> float:
    """Next greater of some digits times a power of ten."""
    exponent = math.floor(math.log10(value))
    candidates = itertools.product((exponent, exponent + 1), digits)
    return next(digit * 10.0**power for power, digit in candidates if digit * 10.0**power >= value * (1 - 1e-9))
