"""Records of a device to sweeps: one clock, ranges, poses from the wheels."""

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from echoplan.acoustics import Air
from echoplan.arrays import FloatArray
from echoplan.geometry import compose
from echoplan.hardware.messages import Air as Temperature
from echoplan.hardware.messages import Echo, Record, Wheels
from echoplan.model import Rig, Sweep
from echoplan.model.sweep import COLDEST, HOTTEST

__all__ = ["FAULTY", "NO_ECHO", "Timed", "Track", "Wheelbase", "driven", "ranges_of", "sweep_of", "timed"]

# The clock of a device begins again after so many microseconds.
_WRAP_US = 2**32
# Values of the protocol in place of a time of flight: no echo, and a sensor that does not answer correctly.
NO_ECHO, FAULTY = 0, -1


@dataclass(frozen=True, slots=True, kw_only=True)
class Timed:
    """A record with its time.

    Parameters
    ----------
    record : Record
        The record.
    stamp_ns : int
        Its time by the clock of the host [ns].
    """

    record: Record
    stamp_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheelbase:
    """Two driven wheels with encoders.

    Parameters
    ----------
    tick : float
        Distance that a wheel rolls from count to count [m].
    width : float
        Distance between the wheels [m].
    """

    tick: float
    width: float


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Track:
    """Where the robot is.

    Parameters
    ----------
    pose : ndarray, shape (3,)
        Its pose [m, m, rad]; the heading counts whole turns.
    counts : Wheels, optional
        The counts of its wheels there, if they are known.
    """

    pose: FloatArray
    counts: Wheels | None = None


def timed(records: Iterable[Record], *, now_ns: Callable[[], int]) -> Iterator[Timed]:
    """Yield the records of a job with their times; the first is timed by the clock of the host [ns].

    Between two records passes less than a turn of the clock of the device.
    """
    clock, stamp_ns = 0, 0
    for record in records:
        stamp_ns = stamp_ns + 1000 * ((record.clock - clock) % _WRAP_US) if stamp_ns else now_ns()
        clock = record.clock
        yield Timed(record=record, stamp_ns=stamp_ns)


def ranges_of(flights_us: ArrayLike, sensor_ids: ArrayLike, *, rig: Rig) -> FloatArray:
    """Convert times of flight [us], shape (n,), to ranges [m] as of REP 117.

    With the speed of sound that the rig states, or that of air of 20 degrees. A thermometer corrects it in the mapper.
    """
    flights, sensors = np.asarray(flights_us, dtype=np.int64), rig.indices(sensor_ids)
    ranges = 0.5e-6 * flights * (rig.speed_of_sound or Air().speed_of_sound)
    ranges = np.where(ranges < rig.min_ranges[sensors], -np.inf, ranges)
    ranges = np.where((ranges > rig.max_ranges[sensors]) | (flights == NO_ECHO), np.inf, ranges)
    return np.where(flights == FAULTY, np.nan, ranges)


def driven(track: Track, counts: Wheels, *, wheels: Wheelbase) -> Track:
    """Return where the robot is after its wheels have turned, by dead reckoning along an arc."""
    if track.counts is None:
        return Track(pose=track.pose, counts=counts)
    left, right = wheels.tick * (counts.left - track.counts.left), wheels.tick * (counts.right - track.counts.right)
    turn = (right - left) / wheels.width
    # The chord of the arc points along the heading halfway.
    chord = (left + right) / 2 * np.sinc(turn / (2 * math.pi))
    moved = compose(track.pose, np.array([chord * math.cos(turn / 2), chord * math.sin(turn / 2), 0.0]))
    return Track(pose=np.array([*moved[:2], track.pose[2] + turn]), counts=counts)


def sweep_of(records: Sequence[Timed], *, index: int, rig: Rig, poses: Sequence[tuple[int, FloatArray]]) -> Sweep:
    """Make a sweep of the records from ``begin`` to ``end``.

    Parameters
    ----------
    records : sequence of Timed
        The records.
    index : int
        Number of the sweep.
    rig : Rig
        What its sensors are.
    poses : sequence of tuple
        Times [ns] and poses [m, m, rad] between which those of the pings are interpolated.

    Raises
    ------
    UnknownNameError
        If a sensor is not part of the rig.
    """
    echoes = [(each.stamp_ns, each.record) for each in records if isinstance(each.record, Echo)]
    columns = [(stamp_ns, echo.sensor, echo.angle, echo.flight) for stamp_ns, echo in echoes]
    stamps_ns, sensor_ids, angles, flights = np.array(columns, dtype=np.int64).reshape(-1, 4).T
    temperatures = (0.01 * each.record.temperature for each in records if isinstance(each.record, Temperature))
    times_ns, known = zip(*poses, strict=True)
    # Differences, because nanoseconds since 1970 do not fit a float.
    since, knots = stamps_ns - times_ns[0], np.array(times_ns, dtype=np.int64) - times_ns[0]
    return Sweep(
        index=index,
        stamps_ns=stamps_ns,
        sensor_ids=sensor_ids,
        servo_angles=np.radians(0.01 * angles),
        ranges=ranges_of(flights, sensor_ids, rig=rig),
        map_from_base=np.column_stack([np.interp(since, knots, column) for column in np.array(known).T]),
        # A broken thermometer reports what no air has: a DS18B20 85 degrees.
        temperature=next((each for each in temperatures if COLDEST <= each <= HOTTEST), math.nan),
    )
