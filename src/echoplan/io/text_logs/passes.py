"""Passes: where one turn of the servo ends and the next begins, and when each ping was sent."""

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InputError
from echoplan.io.passes import pass_starts
from echoplan.io.text_logs.columns import Role
from echoplan.io.text_logs.facts import Fact, Origin
from echoplan.io.text_logs.records import Reading, Records

__all__ = ["pass_numbers", "runs_of", "times_of_rows"]

# No sketch waits so long from ping to ping [s]: numbers that grow faster are milliseconds.
_SLOWEST = 5.0


def runs_of(records: Records) -> tuple[IntArray, IntArray]:
    """Return the numbers of run and file of each reading; a run ends with the file, and at a place.

    A robot that says where it is all the time moves while its servo turns: then a place ends no run.
    """
    is_reading = np.array([isinstance(item, Reading) for item in records.items])
    files = np.repeat(np.arange(len(records.counts)), records.counts)
    runs = np.cumsum(~is_reading) + files if records.is_standing else files
    return runs[is_reading], files[is_reading]


def pass_numbers(angles: FloatArray, runs: IntArray) -> IntArray:
    """Return the number of the pass of each reading; passes end with a run and where the angle turns back."""
    numbers = np.zeros(len(angles), dtype=np.int64)
    for rows in np.split(np.arange(len(runs)), np.flatnonzero(np.diff(runs)) + 1):
        # The first row of each run begins a pass, too.
        numbers[rows[pass_starts(angles[rows])]] = 1
    return np.cumsum(numbers) - 1


def times_of_rows(records: Records, *, sensors: int, period: float, source: str) -> tuple[FloatArray, Fact]:
    """Return when each sensor of each row was fired, shape (n, sensors) [s], and how that is known.

    The sensors of a row are fired one after another. Stamps that go back, as after a reset, are not used.
    """
    known = np.array([np.nan if reading.stamp is None else reading.stamp for reading in records.readings])
    gaps = np.diff(known)
    usual, column = float(np.median(gaps)) if len(gaps) else 0.0, records.column(Role.TIME)
    if column is not None and not column.unit and usual > _SLOWEST:
        problem = f"its times have no unit, and go up by {usual:g} from line to line"
        raise InputError(source, problem, remedy="name the column t:ms, t:us or t:s in --columns, or - to leave it out")
    if np.isfinite(known).all() and (gaps >= 0.0).all() and (gaps > 0.0).any():
        # Coarse stamps repeat: then the sensors of a row share their time.
        apart, rows = min(period, float(gaps.min()) / sensors), known - known[0]
        fact = Fact(subject="times", value="as stamped", origin=Origin.STATED)
    else:
        apart, rows = period, period * sensors * np.arange(len(known), dtype=np.float64)
        fact = Fact(subject="times", value=f"{period:g} s from ping to ping", origin=Origin.DEFAULT)
    times: FloatArray = rows[:, None] + apart * np.arange(sensors)
    return times, fact
