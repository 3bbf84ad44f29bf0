"""Uncertainty as shapes: the ellipse of a point and the band about a wall."""

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, checked_covariance, checked_floats, store
from echoplan.geometry import along
from echoplan.model import Wall

__all__ = [
    "PROBABILITY",
    "Ellipse",
    "across_sigmas",
    "error_ellipse",
    "greatest_sigma",
    "half_interval",
    "middle_sigma",
    "sigma",
    "wall_band",
]

PROBABILITY = 0.95

_BAND_POINTS = 9


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Ellipse:
    """An ellipse in the map.

    Parameters
    ----------
    center_xy : ndarray, shape (2,)
        Middle [m].
    semi_axes : ndarray, shape (2,)
        Half of the long and of the short axis [m].
    angle : float
        Direction of the long axis [rad].
    """

    center_xy: FloatArray
    semi_axes: FloatArray
    angle: float

    def __post_init__(self) -> None:
        store(
            self,
            center_xy=checked_floats(self.center_xy, name="center_xy", shape=(2,)),
            semi_axes=checked_floats(self.semi_axes, name="semi_axes", shape=(2,)),
        )


def error_ellipse(position_xy: ArrayLike, covariance: ArrayLike, *, probability: float = PROBABILITY) -> Ellipse:
    """Find the ellipse that holds a Gaussian point with a given probability.

    Parameters
    ----------
    position_xy : array_like, shape (2,)
        Mean [m].
    covariance : array_like, shape (2, 2)
        Covariance [m, m].
    probability : float, optional
        Between 0 and 1.

    Returns
    -------
    Ellipse
        Its axes are the standard deviations along the eigenvectors times ``sqrt(-2 ln(1 - probability))``, the root
        of the quantile of a chi-squared variable of two degrees of freedom.

    Raises
    ------
    InvalidValueError
        If the covariance is invalid.

    Examples
    --------
    >>> error_ellipse([0.0, 0.0], [[0.04, 0.0], [0.0, 0.01]]).semi_axes.round(3)
    array([0.49 , 0.245])
    """
    matrix = checked_covariance(covariance, name="covariance", size=2)
    variances, vectors = np.linalg.eigh(matrix)
    scale = math.sqrt(-2 * math.log1p(-probability))
    return Ellipse(
        center_xy=np.asarray(position_xy),
        semi_axes=scale * np.sqrt(np.maximum(variances[::-1], 0.0)),
        angle=float(np.arctan2(vectors[1, 1], vectors[0, 1])),
    )


def across_sigmas(wall: Wall, points_xy: ArrayLike) -> FloatArray:
    """Return how uncertain a wall is across itself, beside points on it.

    Parameters
    ----------
    wall : Wall
        The wall.
    points_xy : array_like, shape (..., 2)
        Points on it [m].

    Returns
    -------
    ndarray, shape (...)
        Standard deviations [m].  A point at the coordinate s along the line moves by ``d offset - s d angle`` along
        the normal.
    """
    coordinates = along([wall.normal_angle, wall.offset], points_xy)
    jacobian = np.stack([-coordinates, np.ones_like(coordinates)], axis=-1)
    variances = np.einsum("...i,ij,...j->...", jacobian, wall.covariance, jacobian)
    sigmas: FloatArray = np.sqrt(np.maximum(variances, 0.0))
    return sigmas


def middle_sigma(wall: Wall) -> float:
    """Return how uncertain a wall is across itself, in its middle.

    Parameters
    ----------
    wall : Wall
        The wall.

    Returns
    -------
    float
        Standard deviation [m].
    """
    return float(across_sigmas(wall, wall.endpoints_xy.mean(axis=0)))


def greatest_sigma(covariance: FloatArray) -> float:
    """Return how uncertain a point is in the direction in which it is most so.

    Parameters
    ----------
    covariance : ndarray, shape (2, 2)
        Of the point [m, m].

    Returns
    -------
    float
        Root of the greatest eigenvalue [m].

    Examples
    --------
    >>> greatest_sigma(np.diag([4e-6, 1e-6]))
    0.002
    """
    return math.sqrt(max(float(np.linalg.eigvalsh(covariance)[-1]), 0.0))


def half_interval(deviation: float, *, probability: float = PROBABILITY) -> float:
    """Half the width of the interval that holds a Gaussian number with a given probability, from its sigma."""
    return NormalDist().inv_cdf((1 + probability) / 2) * deviation


def sigma(covariance: FloatArray, index: int) -> float:
    """Return how uncertain one parameter is by itself.

    Parameters
    ----------
    covariance : ndarray, shape (n, n)
        Of n parameters.
    index : int
        Which of them.

    Returns
    -------
    float
        Standard deviation, in the unit of the parameter.
    """
    return math.sqrt(max(float(covariance[index, index]), 0.0))


def wall_band(wall: Wall, *, probability: float = PROBABILITY) -> FloatArray:
    """Outline the band in which a wall lies with a given probability, at each place for itself.

    Parameters
    ----------
    wall : Wall
        The wall.
    probability : float, optional
        Between 0 and 1.

    Returns
    -------
    ndarray, shape (n, 2)
        Distance along the wall from its start, and half of the width there [m]: narrow where the wall was
        detected, wide where it was only lengthened.
    """
    shares = np.linspace(0.0, 1.0, _BAND_POINTS)
    points = wall.endpoints_xy[0] + shares[:, None] * (wall.endpoints_xy[1] - wall.endpoints_xy[0])
    half = half_interval(1.0, probability=probability) * across_sigmas(wall, points)
    return np.stack([shares * wall.length, half], axis=-1)
