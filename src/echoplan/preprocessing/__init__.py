"""What happens to readings before anything is extracted: validity, the K-means filter, a survey of it all."""

from echoplan.preprocessing.kmeans import KmeansSettings, echo_points, kmeans_filter
from echoplan.preprocessing.sound import expected_scale
from echoplan.preprocessing.survey import SensorSurvey, Survey, survey
from echoplan.preprocessing.validity import is_valid, told_ranges, valid_pings

__all__ = [
    "KmeansSettings",
    "SensorSurvey",
    "Survey",
    "echo_points",
    "expected_scale",
    "is_valid",
    "kmeans_filter",
    "survey",
    "told_ranges",
    "valid_pings",
]
