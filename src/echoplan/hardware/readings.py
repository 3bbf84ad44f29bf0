"""Records of a device to sweeps: one clock, ranges, poses from the wheels."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from echoplan.acoustics import Air
from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import compose
from echoplan.hardware.protocol import Air as Temperature
from echoplan.hardware.protocol import Echo, Record, Wheels
from echoplan.model import Rig, Sweep

__all__ = ["Wheelbase", "driven", "elapsed_ns", "ranges_of", "sweep_of"]

# The clock of a device begins again after so many microseconds.
_WRAP_US = 2**32
_NO_ECHO, _FAULTY = 0, -1


@dataclass(frozen=True, slots=True, kw_only=True)
class Wheelbase:
    """Two driven wheels with encoders.

    Parameters
    ----------
    tick : float
        Way of a wheel from count to count [m].
    width : float
        Distance between the wheels [m].
    """

    tick: float
    width: float


def elapsed_ns(clocks: Sequence[int]) -> IntArray:
    """Return the time of each record of a session since the first [ns]; the clock of the device [us] may wrap.

    Between two records of a session passes less than a turn of the clock.
    """
    steps = np.diff(np.array(clocks, dtype=np.int64)) % _WRAP_US
    return 1000 * np.concatenate([[0], np.cumsum(steps)])[: len(clocks)]


def ranges_of(flights_us: ArrayLike, sensor_ids: ArrayLike, *, rig: Rig) -> FloatArray:
    """Convert times of flight [us], shape (n,), to ranges [m] as of REP 117.

    With the speed of sound that the rig states, or that of air of 20 degrees. A thermometer corrects it in the mapper.
    """
    flights, sensors = np.asarray(flights_us), rig.indices(sensor_ids)
    ranges = 0.5e-6 * flights * (rig.speed_of_sound or Air().speed_of_sound)
    ranges = np.where(ranges < rig.min_ranges[sensors], -np.inf, ranges)
    ranges = np.where((ranges > rig.max_ranges[sensors]) | (flights == _NO_ECHO), np.inf, ranges)
    return np.where(flights == _FAULTY, np.nan, ranges)


def driven(start: FloatArray, records: Sequence[Wheels], *, wheels: Wheelbase) -> FloatArray:
    """Return where the robot is at each count of its wheels, shape (n, 3) [m, m, rad], by dead reckoning.

    It is at the start at the first count, and drives along an arc between two.
    """
    poses = [np.asarray(start, dtype=np.float64)]
    for before, after in zip(records, records[1:], strict=False):
        left, right = wheels.tick * (after.left - before.left), wheels.tick * (after.right - before.right)
        turn = (right - left) / wheels.width
        # The chord of the arc points along the heading halfway.
        chord = (left + right) / 2 * np.sinc(turn / (2 * math.pi))
        poses.append(compose(poses[-1], np.array([chord * math.cos(turn / 2), chord * math.sin(turn / 2), turn])))
    return np.array(poses)


def sweep_of(records: Sequence[Record], *, index: int, rig: Rig, begin_ns: int, poses: FloatArray) -> Sweep:
    """Make a sweep of the records from ``begin`` to ``end``.

    Parameters
    ----------
    records : sequence of Record
        The records.
    index : int
        Number of the sweep.
    rig : Rig
        What its sensors are.
    begin_ns : int
        Time of the first record [ns].
    poses : ndarray, shape (w, 3)
        Pose at each ``wheels`` record [m, m, rad]; shape (1, 3) for a robot without wheels.

    Raises
    ------
    UnknownNameError
        If a sensor is not part of the rig.
    """
    times_ns = begin_ns + elapsed_ns([record.clock for record in records])
    is_echo = np.array([isinstance(record, Echo) for record in records])
    echoes = [record for record in records if isinstance(record, Echo)]
    sensor_ids = [echo.sensor for echo in echoes]
    temperatures = [0.01 * record.temperature for record in records if isinstance(record, Temperature)]
    knots_ns = times_ns[[isinstance(record, Wheels) for record in records]] if len(poses) > 1 else times_ns[:1]
    unwrapped = np.column_stack([poses[:, :2], np.unwrap(poses[:, 2])])
    stamps_ns = times_ns[is_echo]
    return Sweep(
        index=index,
        stamps_ns=stamps_ns,
        sensor_ids=np.array(sensor_ids, dtype=np.int64),
        servo_angles=np.radians([0.01 * echo.angle for echo in echoes]),
        ranges=ranges_of([echo.flight for echo in echoes], sensor_ids, rig=rig),
        map_from_base=np.column_stack([np.interp(stamps_ns, knots_ns, column) for column in unwrapped.T]),
        temperature=temperatures[0] if temperatures else math.nan,
    )
