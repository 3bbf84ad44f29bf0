"""The types of landmarks: number of parameters, reflection, class in the map, and resolution of proposals."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import IntArray
from echoplan.model import FeatureClass

__all__ = ["LANDMARKS", "PARAMETERS", "LandmarkType"]


class LandmarkType(NamedTuple):
    """Properties of a type of landmark, except its echo (``acoustics.predicted_echo``).

    Attributes
    ----------
    parameters : int
        Free parameters: normal angle and offset, or x, y and perhaps a radius.
    feature_class : FeatureClass
        What it is in a map.
    is_surface : bool
        Whether it reflects specularly.  Points return little sound, so that non-detections of them
        are weak evidence.
    proposal_cell : tuple of float
        Proposals in the same cell of this size count as one [rad, m; m, m, m].
    refined_cell : tuple of float
        The same once they are refined.
    """

    parameters: int
    feature_class: FeatureClass
    is_surface: bool
    proposal_cell: tuple[float, float, float]
    refined_cell: tuple[float, float, float]


# An edge is proposed wherever a corner is.
_CORNER = LandmarkType(
    parameters=2,
    feature_class=FeatureClass.CORNER,
    is_surface=False,
    proposal_cell=(0.03, 0.03, 1.0),
    refined_cell=(0.012, 0.012, 1.0),
)
# Cells are in rad and m for walls, in m for points and centres, and in m for the radius.
LANDMARKS: dict[Kind, LandmarkType] = {
    Kind.WALL: LandmarkType(
        parameters=2,
        feature_class=FeatureClass.WALL,
        is_surface=True,
        proposal_cell=(math.radians(2.0), 0.015, 1.0),
        refined_cell=(0.01, 0.006, 1.0),
    ),
    Kind.CORNER: _CORNER,
    Kind.EDGE: _CORNER,
    Kind.CYLINDER: LandmarkType(
        parameters=3,
        feature_class=FeatureClass.CYLINDER,
        is_surface=True,
        proposal_cell=(0.04, 0.04, 0.05),
        refined_cell=(0.015, 0.015, 0.02),
    ),
}
# Their free parameters by the value of ``Kind``, for compiled functions.
PARAMETERS: IntArray = np.array([LANDMARKS[kind].parameters for kind in Kind], dtype=np.int64)
