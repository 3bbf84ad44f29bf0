"""Events: decisions about landmarks with their numbers, logged at debug level.

Events travel through ``logging``, so that no algorithm has to pass them on. ``collect_events`` gathers them; without a
handler at debug level none is created. ``echoplan map --why`` and the report show them.
"""

import logging
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.joint.likelihood.hypothesis import Hypothesis

__all__ = ["Decision", "Event", "Reason", "collect_events", "record_event", "record_window"]

_LOGGER = logging.getLogger("echoplan.joint")


class Decision(StrEnum):
    """Decision about a landmark."""

    ADDED = "added"
    REJECTED = "rejected"
    REMOVED = "removed"
    CHANGED = "changed"


class Reason(StrEnum):
    """Test that decided."""

    EVIDENCE = "evidence"
    UNDERDETERMINED = "underdetermined"
    MISSED = "missed"
    WEAKLY_DETECTED = "weakly detected"
    SINGLE_STATION = "single station"
    BETTER_CLASS = "better class"
    MULTIPATH = "multipath"
    DUPLICATE = "duplicate"
    INCONSISTENT = "inconsistent"


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """One decision about one landmark."""

    decision: Decision
    reason: Reason
    # Class of the landmark before the decision.
    kind: Kind
    # Normal angle and offset of a wall [rad, m]; x, y, and radius of anything else [m].
    parameters: tuple[float, ...]
    # Log-likelihood ratio of all pings with and without the landmark [nats].
    log_likelihood_ratio: float
    # Required log-likelihood ratio [nats]; NaN if another test decided.
    threshold: float
    # Sums of the positive and of the negative log-likelihood ratios of the stations [nats].
    detections: float
    missed_detections: float
    # Number of supporting stations.
    stations: int
    # Index of the station with the most negative log-likelihood ratio.
    worst_station: int | None
    # Class after a change.
    becomes: Kind | None = None

    def translated(self, offset_xy: tuple[float, float]) -> "Event":
        """Return the event in a frame whose origin lies at minus ``offset_xy`` [m]."""
        x, y = offset_xy
        if self.kind is Kind.WALL:
            angle, offset = self.parameters
            return replace(self, parameters=(angle, offset + x * math.cos(angle) + y * math.sin(angle)))
        return replace(self, parameters=(self.parameters[0] + x, self.parameters[1] + y, *self.parameters[2:]))


def record_event(
    decision: Decision,
    landmark: Hypothesis,
    *,
    reason: Reason,
    threshold: float = math.nan,
    becomes: Kind | None = None,
) -> None:
    """Log a decision if a handler listens at debug level."""
    if not _LOGGER.isEnabledFor(logging.DEBUG):
        return
    ratios = landmark.llr_by_station
    against = float(ratios.min(initial=0.0))
    event = Event(
        decision=decision,
        reason=reason,
        kind=landmark.kind,
        parameters=tuple(landmark.parameters.tolist()),
        log_likelihood_ratio=landmark.llr,
        threshold=threshold,
        detections=float(ratios[ratios > 0.0].sum()) + landmark.history.llr,
        missed_detections=float(ratios[ratios < 0.0].sum()),
        stations=landmark.supporting(0.0),
        worst_station=int(np.argmin(ratios)) if against < 0.0 else None,
        becomes=becomes,
    )
    _LOGGER.debug("%s", event, extra={"event": event})


def record_window(first_station: int) -> None:
    """Log the index of the first station of the window, from which the next events count."""
    _LOGGER.debug("window begins at station %d", first_station, extra={"first_station": first_station})


@contextmanager
def collect_events() -> Iterator[list[Event]]:
    """Collect the events of a block in order, with station indices that count from the start of the recording."""
    collector, level = _Collector(), _LOGGER.level
    _LOGGER.addHandler(collector)
    _LOGGER.setLevel(logging.DEBUG)
    try:
        yield collector.events
    finally:
        _LOGGER.removeHandler(collector)
        _LOGGER.setLevel(level)


class _Collector(logging.Handler):
    """Handler that keeps the events among the records of a logger."""

    def __init__(self) -> None:
        super().__init__(logging.DEBUG)
        self.events: list[Event] = []
        self._first_station = 0

    def emit(self, record: logging.LogRecord) -> None:
        """Keep the event of a record, if it has one."""
        self._first_station = getattr(record, "first_station", self._first_station)
        event = getattr(record, "event", None)
        if event is not None:
            worst = event.worst_station
            if worst is not None:
                event = replace(event, worst_station=worst + self._first_station)
            self.events.append(event)
