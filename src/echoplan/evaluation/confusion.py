"""What the map made of walls, corners and cylinders: the confusion matrix of the classification.

Every estimate counts once, in the column of its class.  Its row is the class of what truly stands there: its own
match if it has one, else the corner, the cylinder or the wall that it lies on, else nothing.  A wanted true object
that no estimate of any class lies on counts once as missed.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.evaluation.matches import Matches
from echoplan.evaluation.matching import MatchingSettings
from echoplan.evaluation.vertices import true_vertices
from echoplan.geometry import distances_to_segments
from echoplan.model import FeatureClass, FeatureMap, Truth

__all__ = ["MAP_CLASSES", "TRUE_CLASSES", "confusion_matrix", "no_confusion"]

_NONE, _MISSED = "none", "missed"
TRUE_CLASSES = (*map(str, FeatureClass), _NONE)
MAP_CLASSES = (*map(str, FeatureClass), _MISSED)

# Points before lines: near a corner there are always walls.
_PRECEDENCE = (FeatureClass.CORNER, FeatureClass.CYLINDER, FeatureClass.WALL)


@dataclass(frozen=True, slots=True, kw_only=True)
class _Claim:
    """An estimate's class, and the class and number of the true object that it lies on."""

    estimated: str
    true: str
    number: int


def confusion_matrix(feature_map: FeatureMap, truth: Truth, matches: Matches, settings: MatchingSettings) -> IntArray:
    """Count what stands for what.

    Parameters
    ----------
    feature_map : FeatureMap
        The estimates.
    truth : Truth
        The true objects.
    matches : Matches
        Which estimate is of which true object of its own class.
    settings : MatchingSettings
        How near an estimate must be to lie on something: as near as one of the right class, but measured between
        the surfaces.  An estimated wall lies where its midpoint is.

    Returns
    -------
    ndarray of int, shape (4, 4)
        Rows as in ``TRUE_CLASSES``, columns as in ``MAP_CLASSES``.
    """
    claims = [
        _Claim(estimated=name, true=name, number=match.truth)
        for name, matching in matches.by_class.items()
        for match in (*matching.right, *matching.duplicate)
    ]
    claims += _unmatched(feature_map, truth, matches, settings)
    matrix = no_confusion()
    for claim in claims:
        matrix[TRUE_CLASSES.index(claim.true), MAP_CLASSES.index(claim.estimated)] += 1
    for name, matching in matches.by_class.items():
        claimed = {claim.number for claim in claims if claim.true == name}
        missed = set(matching.wanted) - set(matching.found) - claimed
        matrix[TRUE_CLASSES.index(name), MAP_CLASSES.index(_MISSED)] = len(missed)
    return matrix


def no_confusion() -> IntArray:
    """Return the matrix of nothing.

    Returns
    -------
    ndarray of int, shape (4, 4)
        Zeros.
    """
    return np.zeros((len(TRUE_CLASSES), len(MAP_CLASSES)), dtype=np.int64)


def _unmatched(feature_map: FeatureMap, truth: Truth, matches: Matches, settings: MatchingSettings) -> Iterator[_Claim]:
    discs = _discs(feature_map)
    vertices_xy = true_vertices(truth).positions_xy
    reaches = {
        FeatureClass.CORNER: settings.corner_distance,
        FeatureClass.CYLINDER: settings.cylinder_distance,
        FeatureClass.WALL: settings.wall_distance,
    }
    for name, matching in matches.by_class.items():
        for x, y, radius in discs[name][list(matching.spurious)].tolist():
            others = {other: reaches[other] + radius for other in _PRECEDENCE if other != name}
            yield _claim(name, _distances(np.array([x, y]), truth, vertices_xy), others)


def _claim(
    estimated: str, distances: Mapping[FeatureClass, FloatArray], reaches: Mapping[FeatureClass, float]
) -> _Claim:
    for true, reach in reaches.items():
        if (distances[true] <= reach).any():
            return _Claim(estimated=estimated, true=true, number=int(distances[true].argmin()))
    return _Claim(estimated=estimated, true=_NONE, number=0)


def _discs(feature_map: FeatureMap) -> Mapping[FeatureClass, FloatArray]:
    """Where the n estimates of each class lie: x, y and how far their surfaces are from there [m], shape (n, 3)."""
    walls = [[*wall.endpoints_xy.mean(axis=0), 0.0] for wall in feature_map.walls]
    corners = [[*corner.position_xy, 0.0] for corner in feature_map.corners]
    cylinders = [[*cylinder.center_xy, cylinder.radius] for cylinder in feature_map.cylinders]
    return {
        name: np.reshape(rows, (-1, 3)) for name, rows in zip(FeatureClass, (walls, corners, cylinders), strict=True)
    }


def _distances(point_xy: FloatArray, truth: Truth, vertices_xy: FloatArray) -> Mapping[FeatureClass, FloatArray]:
    """Distance of a point from every true object, negative inside a cylinder [m]."""
    vertices = vertices_xy - point_xy
    axes = truth.cylinders[:, :2] - point_xy
    return {
        FeatureClass.WALL: distances_to_segments(point_xy[None], truth.walls_xy)[0],
        FeatureClass.CORNER: np.hypot(vertices[:, 0], vertices[:, 1]),
        FeatureClass.CYLINDER: np.hypot(axes[:, 0], axes[:, 1]) - truth.cylinders[:, 2],
    }
