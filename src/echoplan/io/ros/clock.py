"""Times of messages: one clock for all topics, and no time that runs back."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from echoplan.errors import InputError
from echoplan.io.ros.series import Role, Series, SeriesKey

__all__ = ["TimedSeries", "with_one_clock"]

# Topics are stamped by the same clock if their stamps and the times of recording differ alike to this [ns]: messages
# are recorded within a second, and localisation stamps transforms up to a second ahead.
_SAME_CLOCK_NS = 2_000_000_000
# Messages that overtake each other on the way do so by less than this [ns]; a second run begins farther back.
_OVERTAKEN_NS = 1_000_000_000


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TimedSeries:
    """Series whose stamps are all of one clock, sorted by them.

    Parameters
    ----------
    series : dict
        The series by their keys.
    notes : tuple of str
        What was done about times, in words.
    """

    series: Mapping[SeriesKey, Series]
    notes: tuple[str, ...]


def with_one_clock(series: Mapping[SeriesKey, Series], *, path: Path) -> TimedSeries:
    """Use the stamps in the headers where one clock made them all, else the times of recording.

    Raises ``InputError`` if time runs back: then the bag holds two runs.
    """
    moving = {key: own for key, own in series.items() if key.role is not Role.FIXED_TRANSFORM}
    logged = _topics_by_log(moving)
    notes = []
    for topic, offset_ns in logged.items():
        why = "have no stamps" if offset_ns is None else f"are stamped by another clock, {offset_ns * 1e-9:+.0f} s off"
        notes.append(f"The messages on {topic} {why}; the times at which they were recorded are used instead.")
    timed = dict(series)
    for key, own in moving.items():
        stamps = np.where((own.stamps_ns == 0) | (key.topic in logged), own.log_ns, own.stamps_ns)
        timed[key] = _in_order(replace(own, stamps_ns=stamps), topic=key.topic, path=path)
    return TimedSeries(series=timed, notes=tuple(notes))


def _topics_by_log(series: Mapping[SeriesKey, Series]) -> dict[str, int | None]:
    """Return the topics whose stamps are of no use, and by how much they are off [ns]; None if they have none."""
    by_topic: defaultdict[str, list[Series]] = defaultdict(list)
    for key, own in series.items():
        by_topic[key.topic].append(own)
    offsets = {topic: _offset_ns(several) for topic, several in by_topic.items()}
    known = {topic: offset for topic, offset in offsets.items() if offset is not None}
    spread = max(known.values(), default=0) - min(known.values(), default=0)
    if len(known) == len(offsets) and spread <= _SAME_CLOCK_NS:
        return {}
    # The stamps of the others are those of the computer that recorded them.
    near = {topic for topic, offset in known.items() if abs(offset) <= _SAME_CLOCK_NS}
    return {topic: offset for topic, offset in offsets.items() if topic not in near}


def _offset_ns(several: list[Series]) -> int | None:
    """Return by how much the stamps of a topic are later than the times of recording [ns]; None without stamps."""
    stamps, logs = (np.concatenate([getattr(each, name) for each in several]) for name in ("stamps_ns", "log_ns"))
    stamped = stamps != 0
    # A topic with as many empty stamps as others has none that mean anything.
    return int(np.median(stamps[stamped] - logs[stamped])) if 2 * np.count_nonzero(stamped) > len(stamps) else None


def _in_order(series: Series, *, topic: str, path: Path) -> Series:
    """Sort a series by time, unless it runs back to an earlier run."""
    latest = np.maximum.accumulate(series.stamps_ns)
    back = latest - series.stamps_ns
    if back.max(initial=0) > _OVERTAKEN_NS:
        first = int(np.argmax(back > _OVERTAKEN_NS))
        problem = f"time goes back by {back[first] * 1e-9:.1f} s at message {first + 1}"
        remedy = "the bag holds two runs, or two publishers of one topic: split it there"
        raise InputError(path, problem, place=topic, remedy=remedy)
    order = np.argsort(series.stamps_ns, kind="stable")
    return Series(log_ns=series.log_ns[order], stamps_ns=series.stamps_ns[order], values=series.values[order])
