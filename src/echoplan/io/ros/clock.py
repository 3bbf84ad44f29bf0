"""Times of messages: one clock for all topics, and times that never decrease."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from echoplan.arrays import IntArray
from echoplan.errors import InputError
from echoplan.io.ros.series import Role, Series, SeriesKey

__all__ = ["TimedSeries", "times_of", "with_one_clock"]

# Topics have the same clock if the offsets of their stamps from the times of recording agree to this [ns]: messages
# are recorded within a second, and localisation stamps transforms up to a second ahead.
_SAME_CLOCK_NS = 2_000_000_000
# Messages arrive out of order by less than this [ns]; a second run begins farther back.
_OVERTAKEN_NS = 1_000_000_000


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TimedSeries:
    """Series that are stamped by one clock, sorted by time.

    Parameters
    ----------
    series : dict
        The series by key.
    notes : tuple of str
        Corrections of times, as sentences for the user.
    without_stamps : frozenset of str
        Topics of which the times of recording are used.
    """

    series: Mapping[SeriesKey, Series]
    notes: tuple[str, ...]
    without_stamps: frozenset[str]


def with_one_clock(series: Mapping[SeriesKey, Series], *, path: Path) -> TimedSeries:
    """Use the stamps in the headers if one clock made them all, else the times of recording.

    Raises ``InputError`` if time goes back, as in a bag of two runs.
    """
    moving = {key: own for key, own in series.items() if key.role is not Role.FIXED_TRANSFORM}
    logged = _topics_by_log(moving)
    notes = []
    for topic, offset_ns in logged.items():
        why = "have no stamps" if offset_ns is None else f"were stamped by another clock, {offset_ns * 1e-9:+.0f} s off"
        notes.append(f"The messages on {topic} {why}; the times of recording are used instead.")
    timed = dict(series)
    for key, own in moving.items():
        stamps = times_of(own, has_stamps=key.topic not in logged)
        timed[key] = _in_order(replace(own, stamps_ns=stamps), topic=key.topic, path=path)
    return TimedSeries(series=timed, notes=tuple(notes), without_stamps=frozenset(logged))


def times_of(series: Series, *, has_stamps: bool) -> IntArray:
    """Return the time of each entry [ns]: its stamp, or when it was recorded."""
    times: IntArray = np.where((series.stamps_ns == 0) | (not has_stamps), series.log_ns, series.stamps_ns)
    return times


def _topics_by_log(series: Mapping[SeriesKey, Series]) -> dict[str, int | None]:
    """Return the topics with unusable stamps, and their offset [ns]; None if they have no stamps."""
    by_topic: defaultdict[str, list[Series]] = defaultdict(list)
    for key, own in series.items():
        by_topic[key.topic].append(own)
    offsets = {topic: _offset_ns(several) for topic, several in by_topic.items()}
    known = {topic: offset for topic, offset in offsets.items() if offset is not None}
    spread = max(known.values(), default=0) - min(known.values(), default=0)
    if len(known) == len(offsets) and spread <= _SAME_CLOCK_NS:
        return {}
    # The other topics are stamped by the clock of the computer that recorded them.
    near = {topic for topic, offset in known.items() if abs(offset) <= _SAME_CLOCK_NS}
    return {topic: offset for topic, offset in offsets.items() if topic not in near}


def _offset_ns(several: list[Series]) -> int | None:
    """Return by how much the stamps of a topic are later than the times of recording [ns]; None without stamps."""
    stamps, logs = (np.concatenate([getattr(each, name) for each in several]) for name in ("stamps_ns", "log_ns"))
    stamped = stamps != 0
    # If half of the stamps of a topic are empty, the others mean nothing.
    return int(np.median(stamps[stamped] - logs[stamped])) if 2 * np.count_nonzero(stamped) > len(stamps) else None


def _in_order(series: Series, *, topic: str, path: Path) -> Series:
    """Sort a series by time; refuse it if time goes back, as in a bag of two runs."""
    latest = np.maximum.accumulate(series.stamps_ns)
    back = latest - series.stamps_ns
    if back.max(initial=0) > _OVERTAKEN_NS:
        first = int(np.argmax(back > _OVERTAKEN_NS))
        problem = f"time goes back by {back[first] * 1e-9:.1f} s at message {first + 1}"
        remedy = "the bag contains two runs, or a topic with two publishers: split the bag at this message"
        raise InputError(path, problem, place=topic, remedy=remedy)
    order = np.argsort(series.stamps_ns, kind="stable")
    return Series(log_ns=series.log_ns[order], stamps_ns=series.stamps_ns[order], values=series.values[order])
