"""Select the readings of sonar in a bag, and interpret their numbers (REP 117)."""

import re
from collections.abc import Mapping

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.errors import InputError
from echoplan.io.ros.choice import named_topics
from echoplan.io.ros.contents import BagContents
from echoplan.io.ros.options import BagOptions
from echoplan.io.ros.series import Role, Series, SeriesKey

__all__ = ["Readings", "notes_about_infrared", "notes_about_ranges", "ranges_of", "sonar_readings"]

Readings = Mapping[SeriesKey, Series]


def sonar_readings(read: BagContents) -> dict[SeriesKey, Series]:
    """Return the readings by sensor, in natural order of their topics; infrared ones only if they are named.

    Raises ``InputError`` if there are none.
    """

    def natural(key: SeriesKey) -> list[tuple[int, str]]:
        """Return a sorting key in which numbers count as numbers."""
        # /sonar_2 comes before /sonar_10; sensors of one topic are sorted by their fields and frames.
        words = re.findall(r"(\d+)|(\D+)", f"{key.topic} {key.child} {key.frame}")
        return [(int(number or 0), text) for number, text in words]

    found = read.of_role(Role.READING)
    in_order = sorted(found, key=natural)
    kept = {key: found[key] for key in in_order if not _is_infrared(found[key], read.options)}
    if kept:
        return kept
    if not any(topic.count for topic in read.topics):
        raise InputError(read.path, "there is no message in it", remedy="record it again; check with: ros2 topic hz")
    problem = f"no topic has ranges of sonar (sensor_msgs/Range); it has {named_topics(read.topics)}"
    remedy = "record them, name the field of another type: --field range=/TOPIC.FIELD, or a sonar's LaserScan: --topic"
    raise InputError(read.path, problem, remedy=remedy)


def notes_about_infrared(read: BagContents) -> list[str]:
    """Note which topics are left out because they are not sonar."""
    found = read.of_role(Role.READING)
    topics = {key.topic for key, series in found.items() if _is_infrared(series, read.options)}
    return [
        f"{topic} is infrared, not sonar, and is left out. To map it, name it with --topic." for topic in sorted(topics)
    ]


def ranges_of(series: Series, options: BagOptions) -> FloatArray:
    """Return the ranges of a sensor: ``inf`` from ``max_range`` on, ``nan`` for negative ranges."""
    ranges: FloatArray = series.column("range").copy()
    ranges[_is_silent(series, options)] = np.inf
    ranges[_is_impossible(series)] = np.nan
    return ranges


def notes_about_ranges(readings: Readings, options: BagOptions) -> list[str]:
    """Note how many readings mean no echo or a fault."""
    total = sum(map(len, readings.values()))
    silent = sum(int(_is_silent(series, options).sum()) for series in readings.values())
    impossible = sum(int(_is_impossible(series).sum()) for series in readings.values())
    notes = []
    if silent:
        notes.append(f"{silent} of {total} readings are max_range or more and mean no echo.")
    if impossible:
        notes.append(f"{impossible} of {total} readings are negative and count as faulty.")
    return notes


def _is_silent(series: Series, options: BagOptions) -> BoolArray:
    stated = options.constant("max_range")
    most = series.column("max_range") if stated is None else np.full(len(series), stated)
    ranges = series.column("range")
    with np.errstate(invalid="ignore"):
        silent: BoolArray = np.isfinite(ranges) & (most > 0.0) & (ranges >= most)
    return silent


def _is_impossible(series: Series) -> BoolArray:
    ranges = series.column("range")
    with np.errstate(invalid="ignore"):
        impossible: BoolArray = np.isfinite(ranges) & (ranges < 0.0)
    return impossible


def _is_infrared(series: Series, options: BagOptions) -> bool:
    return not options.topics and bool(series.column("infrared").all())
