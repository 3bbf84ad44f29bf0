"""Numbers of a topic over time: readings, poses, transforms and fields as arrays."""

from array import array
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from enum import Enum, auto
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray, chosen_items
from echoplan.geometry import wrap

__all__ = ["READING", "Role", "Row", "Series", "SeriesKey", "as_contents", "interpolate"]


class Role(Enum):
    """Purpose of a series."""

    READING = auto()
    POSE = auto()
    MOVING_TRANSFORM = auto()
    FIXED_TRANSFORM = auto()
    FIELD = auto()


class SeriesKey(NamedTuple):
    """Key of a series: its topic and, for a transform or a pose, the parent and the child frame.

    For a reading, ``frame`` is the frame of the sensor, and ``child`` the field if a message has several.
    """

    role: Role
    topic: str
    frame: str = ""
    child: str = ""


class Row(NamedTuple):
    """One entry of a series: when it was recorded, the stamp in its header (0 if there is none), and its numbers."""

    key: SeriesKey
    log_ns: int
    stamp_ns: int
    values: tuple[float, ...]


# The numbers of a reading in their order: range [m], limits [m], full angle of the beam [rad], whether it is infrared,
# and the bearing within a scan [rad].
READING = {"range": 0, "min_range": 1, "max_range": 2, "field_of_view": 3, "infrared": 4, "bearing": 5}


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Series:
    """Numbers over time.

    Parameters
    ----------
    log_ns, stamps_ns : ndarray of int, shape (n,)
        When each was recorded, and its stamp [ns].
    values : ndarray, shape (n, k)
        The numbers: a row of ``READING``, ``(x, y, yaw)`` of a pose, ``(x, y, z, qx, qy, qz, qw)`` of a transform, or
        a field alone.
    """

    log_ns: IntArray
    stamps_ns: IntArray
    values: FloatArray

    def __len__(self) -> int:
        return len(self.log_ns)

    def column(self, name: str) -> FloatArray:
        """Return one number of all readings, shape (n,)."""
        column: FloatArray = self.values[:, READING[name]]
        return column

    def __getitem__(self, chosen: BoolArray | IntArray) -> "Series":
        """Return the selected entries."""
        return chosen_items(self, chosen)

    def finite(self) -> "Series":
        """Leave out entries with a number that is not finite."""
        return self[np.flatnonzero(np.isfinite(self.values).all(axis=1))]


def as_contents(rows: Iterable[Row]) -> dict[SeriesKey, Series]:
    """Group rows by their keys."""
    # Numbers in arrays: an hour of transforms has millions.
    gathered: defaultdict[SeriesKey, tuple[array[int], array[int], array[float]]] = defaultdict(
        lambda: (array("q"), array("q"), array("d"))
    )
    for key, log_ns, stamp_ns, values in rows:
        logs, stamps, numbers = gathered[key]
        logs.append(log_ns)
        stamps.append(stamp_ns)
        numbers.extend(values)
    return {
        key: Series(
            log_ns=np.array(logs, dtype=np.int64),
            stamps_ns=np.array(stamps, dtype=np.int64),
            values=np.array(numbers, dtype=np.float64).reshape(len(logs), -1),
        )
        for key, (logs, stamps, numbers) in gathered.items()
    }


def interpolate(series: Series, stamps_ns: IntArray, *, angles: tuple[int, ...] = ()) -> tuple[FloatArray, BoolArray]:
    """Interpolate the columns of a sorted series linearly, the columns ``angles`` the shorter way round.

    Returns the numbers, shape (n, k), and whether each time lies within the series.
    """
    if not len(series):
        return np.zeros((len(stamps_ns), series.values.shape[1])), np.zeros(len(stamps_ns), dtype=np.bool_)
    values = series.values.copy()
    for place in angles:
        values[:, place] = np.unwrap(values[:, place])
    # A float cannot represent nanoseconds since 1970 exactly.
    start = series.stamps_ns[0]
    moments, knots = stamps_ns - start, series.stamps_ns - start
    found = np.stack([np.interp(moments, knots, column) for column in values.T], axis=-1)
    for place in angles:
        found[:, place] = wrap(found[:, place])
    known: BoolArray = (moments >= knots[0]) & (moments <= knots[-1])
    return found, known
