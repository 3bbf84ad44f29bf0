"""From weighted points to features: the one extraction that all point and grid methods share."""

from echoplan.classical.points.circles import Circle, CircleSettings, circle_covariance, find_circles, fit_taubin
from echoplan.classical.points.clouds import Cloud
from echoplan.classical.points.features import PointFeatures, PointFeatureSettings, features_of_points, join_segments
from echoplan.classical.points.maps import map_of_features
from echoplan.classical.points.peaks import Segments, find_segments
from echoplan.classical.points.segments import (
    Segment,
    SegmentSettings,
    fit_orthogonal,
    line_covariance,
    segment_of,
)

__all__ = [
    "Circle",
    "CircleSettings",
    "Cloud",
    "PointFeatureSettings",
    "PointFeatures",
    "Segment",
    "SegmentSettings",
    "Segments",
    "circle_covariance",
    "features_of_points",
    "find_circles",
    "find_segments",
    "fit_orthogonal",
    "fit_taubin",
    "join_segments",
    "line_covariance",
    "map_of_features",
    "segment_of",
]
