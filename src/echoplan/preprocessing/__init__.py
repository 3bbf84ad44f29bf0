"""What happens to readings before anything is extracted: validity, faults, the K-means filter, a survey of it all."""

from echoplan.preprocessing.faults import Faults, clean_sweeps, find_faults
from echoplan.preprocessing.kmeans import KmeansSettings, echo_points, kmeans_filter
from echoplan.preprocessing.recording_faults import ENOUGH_PLACES, RecordingFault, RecordingFaultKind, count_places
from echoplan.preprocessing.sensor_faults import SensorFault, SensorFaultKind
from echoplan.preprocessing.sound import expected_scale
from echoplan.preprocessing.statistics import SensorSurvey, Survey, survey
from echoplan.preprocessing.validity import is_valid, told_ranges, valid_pings

__all__ = [
    "ENOUGH_PLACES",
    "Faults",
    "KmeansSettings",
    "RecordingFault",
    "RecordingFaultKind",
    "SensorFault",
    "SensorFaultKind",
    "SensorSurvey",
    "Survey",
    "clean_sweeps",
    "count_places",
    "echo_points",
    "expected_scale",
    "find_faults",
    "is_valid",
    "kmeans_filter",
    "survey",
    "told_ranges",
    "valid_pings",
]
