"""Passes: where one turn of the servo ends and the next begins, and when each ping was sent."""

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.errors import InputError
from echoplan.io.passes import LEAST_TURN, pass_starts
from echoplan.io.text_logs.columns import Role
from echoplan.io.text_logs.facts import Fact, Origin
from echoplan.io.text_logs.records import Reading, Records

__all__ = ["pass_numbers", "times_of_rows"]

# No sketch waits so long from ping to ping [s]: numbers that grow faster are milliseconds.
_SLOWEST = 5.0


def pass_numbers(records: Records, angles: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the numbers of pass and file of each reading, shape (n,); a sensor that does not turn makes a pass a row.

    Passes end where the angle turns back, after a full turn, with the file, and where the place changes. A robot whose
    place changes within passes moves while its servo turns: then a place ends no pass.
    """
    is_reading = np.array([isinstance(item, Reading) for item in records.items])
    files = np.repeat(np.arange(len(records.counts)), records.counts)
    runs = np.cumsum(~is_reading) + files if records.is_standing else files
    runs, files = runs[is_reading], files[is_reading]
    if np.ptp(angles) <= LEAST_TURN:
        return np.arange(len(angles)), files
    passes = _numbered(angles, runs)
    poses = records.poses
    if poses is not None:
        moves = np.flatnonzero(np.diff(poses, axis=0).any(axis=1)) + 1
        starts = np.flatnonzero(np.diff(passes)) + 1
        # By the angle alone, a pass may begin a reading too early or too late: extremes are read once, twice or never.
        if 2 * np.isin(moves, [starts - 1, starts, starts + 1]).sum() > len(moves):
            passes = _numbered(angles, runs + np.searchsorted(moves, np.arange(len(runs)), side="right"))
    return passes, files


def _numbered(angles: FloatArray, runs: IntArray) -> IntArray:
    """Return the number of the pass of each reading; passes end with a run, too."""
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
