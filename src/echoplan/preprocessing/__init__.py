"""Preprocessing of readings: validity, faults, the K-means filter, statistics."""

from echoplan.preprocessing.faults import Faults, clean_sweeps, find_faults
from echoplan.preprocessing.kmeans import KmeansSettings, echo_points, kmeans_filter
from echoplan.preprocessing.placement import placed_sweeps
from echoplan.preprocessing.recording_faults import ENOUGH_PLACES, RecordingFault, RecordingFaultKind, count_places
from echoplan.preprocessing.sensor_faults import SensorFault, SensorFaultKind
from echoplan.preprocessing.sound import expected_scale
from echoplan.preprocessing.statistics import RecordingStatistics, SensorStatistics, recording_statistics
from echoplan.preprocessing.validity import is_valid, valid_pings, valid_ranges

__all__ = [
    "ENOUGH_PLACES",
    "Faults",
    "KmeansSettings",
    "RecordingFault",
    "RecordingFaultKind",
    "RecordingStatistics",
    "SensorFault",
    "SensorFaultKind",
    "SensorStatistics",
    "clean_sweeps",
    "count_places",
    "echo_points",
    "expected_scale",
    "find_faults",
    "is_valid",
    "kmeans_filter",
    "placed_sweeps",
    "recording_statistics",
    "valid_pings",
    "valid_ranges",
]
