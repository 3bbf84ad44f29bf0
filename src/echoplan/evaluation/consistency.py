"""Whether a map is as good as it says: the errors of its features against their own covariances.

The normalised estimation error squared (NEES) of an error e with covariance P is ``e . P^-1 e``.  Of k parameters it
has the chi-square distribution with k degrees of freedom if the covariance is true (Bar-Shalom, Li and Kirubarajan
2001, Section 5.4): a greater mean indicates an overconfident map, a smaller one an underconfident map.
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import isfinite, nan

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.evaluation.matches import Matches
from echoplan.evaluation.vertices import true_vertices
from echoplan.geometry import lines_through, wrap
from echoplan.model import FeatureClass, FeatureMap, Truth, Wall, translated_wall

__all__ = ["PARAMETERS", "Consistency", "check_consistency", "check_errors", "nees", "pool_consistency", "wall_error"]

# How many parameters the features of each class have.
PARAMETERS: Mapping[FeatureClass, int] = {FeatureClass.WALL: 2, FeatureClass.CORNER: 2, FeatureClass.CYLINDER: 3}

_CONFIDENCE = 0.95

# A correlation matrix with a lesser eigenvalue cannot be inverted within rounding.
_SINGULAR = 1e-12


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Consistency:
    """Errors against covariances, over n features of one class.

    Parameters
    ----------
    parameters : int
        How many parameters such a feature has.
    nees : ndarray, shape (n,)
        NEES of each right estimate whose covariance can be inverted.
    """

    parameters: int
    nees: FloatArray

    def __post_init__(self) -> None:
        store(self, nees=checked_floats(self.nees, name="nees", shape=(None,)))

    @property
    def mean(self) -> float:
        """Mean NEES, ideally the number of parameters; nan without features."""
        return float(self.nees.mean()) if len(self.nees) else nan

    @property
    def accepted(self) -> FloatArray:
        """Bounds of the mean NEES, 95 % likely for independent features with true covariances, shape (2,)."""
        count = len(self.nees)
        if not count:
            return np.full(2, nan)
        tail = (1 - _CONFIDENCE) / 2
        return np.array([_quantile(share, count * self.parameters) / count for share in (tail, 1 - tail)])

    @property
    def share_inside(self) -> float:
        """Share of the features whose truth lies inside their 95 % ellipse; nan without features."""
        return self.inside / len(self.nees) if len(self.nees) else nan

    @property
    def inside(self) -> int:
        """How many of the features have the truth inside their 95 % ellipse."""
        return int(np.sum(self.nees <= _quantile(_CONFIDENCE, self.parameters)))


def check_consistency(feature_map: FeatureMap, truth: Truth, matches: Matches) -> Mapping[FeatureClass, Consistency]:
    """Compare the errors of the right estimates with their covariances.

    Parameters
    ----------
    feature_map : FeatureMap
        The estimates with their covariances.
    truth : Truth
        The true objects.
    matches : Matches
        Which is of which.

    Returns
    -------
    mapping of FeatureClass to Consistency
        Walls in (normal_angle, offset), corners in (x, y), cylinders in (x, y, radius).
    """
    vertices_xy = true_vertices(truth).positions_xy
    corners = [(feature_map.corners[match.estimate], vertices_xy[match.truth]) for match in matches.corners.right]
    cylinders = [
        (feature_map.cylinders[match.estimate], truth.cylinders[match.truth]) for match in matches.cylinders.right
    ]
    squares = {
        FeatureClass.WALL: _wall_squares(feature_map, truth, matches),
        FeatureClass.CORNER: [nees(found.position_xy - vertex_xy, found.covariance) for found, vertex_xy in corners],
        FeatureClass.CYLINDER: [
            nees([*found.center_xy, found.radius] - circle, found.covariance) for found, circle in cylinders
        ],
    }
    return {
        name: Consistency(parameters=PARAMETERS[name], nees=np.array(list(filter(isfinite, values))))
        for name, values in squares.items()
    }


def check_errors(errors: FloatArray, covariances: FloatArray) -> Consistency:
    """Compare errors with covariances, one by one.

    Parameters
    ----------
    errors : ndarray, shape (n, k)
        Estimated less true.
    covariances : ndarray, shape (n, k, k)
        What the estimator holds them to be.

    Returns
    -------
    Consistency
        Of those whose covariance can be inverted.
    """
    squares = (nees(error, covariance) for error, covariance in zip(errors, covariances, strict=True))
    return Consistency(parameters=errors.shape[1], nees=np.array(list(filter(isfinite, squares))))


def pool_consistency(several: Iterable[Consistency], *, parameters: int) -> Consistency:
    """Pool the features of several maps.

    Parameters
    ----------
    several : iterable of Consistency
        All of the same class.
    parameters : int
        How many parameters a feature of the class has.

    Returns
    -------
    Consistency
        Of all their features.
    """
    values = [each.nees for each in several]
    return Consistency(parameters=parameters, nees=np.concatenate([np.zeros(0), *values]))


def wall_error(wall: Wall, true_ends_xy: FloatArray) -> FloatArray:
    """Error of a line, estimated less true.

    A line has two normals.  The true one that is nearer to the estimated one is taken, and the true offset with it.

    Parameters
    ----------
    wall : Wall
        The estimate.
    true_ends_xy : ndarray, shape (2, 2)
        Ends of the true wall [m].

    Returns
    -------
    ndarray, shape (2,)
        Errors of normal_angle, in [-pi/2, pi/2], and of offset [rad, m].

    Examples
    --------
    >>> ends = np.array([[0.0, 2.0], [4.0, 2.0]])
    >>> wall = Wall(normal_angle=1.58, offset=2.01, endpoints_xy=ends, covariance=np.eye(2))
    >>> wall_error(wall, ends).round(4)
    array([0.0092, 0.01  ])
    """
    angle, offset = lines_through(*true_ends_xy)
    turn = float(wrap(wall.normal_angle - angle))
    if abs(turn) <= np.pi / 2:
        return np.array([turn, wall.offset - offset])
    return np.array([wrap(turn + np.pi), wall.offset + offset])


def nees(error: ArrayLike, covariance: FloatArray) -> float:
    """Normalised estimation error squared, ``e . P^-1 e``.

    Parameters
    ----------
    error : array_like, shape (k,)
        Estimated less true.
    covariance : ndarray, shape (k, k)
        What the estimator holds the error to be, in the same order and units.

    Returns
    -------
    float
        The square; nan if the covariance is singular and so says nothing of some direction.

    Examples
    --------
    >>> nees([0.01, 0.02], np.diag([0.01**2, 0.01**2]))
    5.0
    """
    sigmas = np.sqrt(np.diag(covariance))
    if not (sigmas > 0).all():
        return nan
    correlation = covariance / sigmas / sigmas[:, None]
    if float(np.linalg.eigvalsh(correlation)[0]) < _SINGULAR:
        return nan
    scaled = np.asarray(error, dtype=np.float64) / sigmas
    return float(scaled @ np.linalg.solve(correlation, scaled))


def _wall_squares(feature_map: FeatureMap, truth: Truth, matches: Matches) -> list[float]:
    squares = []
    for match in matches.walls.right:
        wall = feature_map.walls[match.estimate]
        # From its own middle: far away from a wall, its offset and its angle are nearly one and the same.
        middle_xy = wall.endpoints_xy.mean(axis=0)
        near = translated_wall(wall, -middle_xy)
        squares.append(nees(wall_error(near, truth.walls_xy[match.truth] - middle_xy), near.covariance))
    return squares


def _quantile(share: float, freedom: int) -> float:
    """Quantile of the chi-square distribution."""
    from scipy.special import chdtri  # noqa: PLC0415 - a second of import that only this needs

    return float(chdtri(freedom, 1 - share))
