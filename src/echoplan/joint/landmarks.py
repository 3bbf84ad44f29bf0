"""The types of landmarks: number of parameters, reflection, how they are proposed, and what they are in a map."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.model import CornerKind, FeatureClass

__all__ = ["LANDMARKS", "PARAMETERS", "LandmarkType", "reflector_at"]


class LandmarkType(NamedTuple):
    """Properties of a type of landmark, except its echo (``acoustics.predicted_echo``)."""

    # Free parameters: normal angle and offset, or x, y and perhaps a radius.
    parameters: int
    # What it is in a map.
    feature_class: FeatureClass
    # Whether the level of its echo is known. Points return little sound, so that non-detections of them are weak
    # evidence, and a round wall focuses it.
    is_surface: bool
    # Whether it returns sound in all directions, so that every station with a free view should detect it.
    is_omnidirectional: bool
    # Proposals in the same cell of this size count as one [rad, m; m, m, m].
    proposal_cell: tuple[float, float, float]
    # The same once they are refined.
    refined_cell: tuple[float, float, float]
    # Kinds that are tried wherever it is proposed.
    also_proposed: tuple[Kind, ...] = ()
    # Which corner it is, if it is one.
    corner_kind: CornerKind | None = None

    @property
    def has_radius(self) -> bool:
        """Whether it has a radius, as its third parameter."""
        return self.parameters > 2


# A concave corner; an edge is a convex one.
_CORNER = LandmarkType(
    parameters=2,
    feature_class=FeatureClass.CORNER,
    is_surface=False,
    is_omnidirectional=False,
    proposal_cell=(0.03, 0.03, 1.0),
    refined_cell=(0.012, 0.012, 1.0),
    also_proposed=(Kind.EDGE,),
    corner_kind=CornerKind.CONCAVE,
)
# Cells are in rad and m for walls, in m for points and centres, and in m for the radius.
LANDMARKS: dict[Kind, LandmarkType] = {
    Kind.WALL: LandmarkType(
        parameters=2,
        feature_class=FeatureClass.WALL,
        is_surface=True,
        is_omnidirectional=False,
        proposal_cell=(math.radians(2.0), 0.015, 1.0),
        refined_cell=(0.01, 0.006, 1.0),
    ),
    Kind.CORNER: _CORNER,
    Kind.EDGE: _CORNER._replace(also_proposed=(), corner_kind=CornerKind.CONVEX),
    Kind.CYLINDER: LandmarkType(
        parameters=3,
        feature_class=FeatureClass.CYLINDER,
        is_surface=True,
        is_omnidirectional=True,
        proposal_cell=(0.04, 0.04, 0.05),
        refined_cell=(0.015, 0.015, 0.02),
    ),
    Kind.ROUND: LandmarkType(
        parameters=3,
        feature_class=FeatureClass.WALL,
        is_surface=False,
        is_omnidirectional=False,
        proposal_cell=(0.04, 0.04, 0.04),
        refined_cell=(0.015, 0.015, 0.02),
    ),
}
# Their free parameters by the value of ``Kind``, for compiled functions.
PARAMETERS: IntArray = np.array([LANDMARKS[kind].parameters for kind in Kind], dtype=np.int64)


def reflector_at(kind: Kind, point_xy: FloatArray, away: FloatArray, *, radius: float) -> FloatArray:
    """Return the reflector of a kind that a sensor detects at a point, shape (4,).

    ``away`` is the unit vector from the sensor to the point; ``radius`` is that of a kind that has one [m].
    """
    if kind is Kind.WALL:
        return np.array([kind, np.arctan2(away[1], away[0]), point_xy @ away, 0.0])
    radius = radius if LANDMARKS[kind].has_radius else 0.0
    return np.array([kind, *(point_xy + radius * away), radius])
