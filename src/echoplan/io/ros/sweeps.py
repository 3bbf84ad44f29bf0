"""Pings in the order of time, split into sweeps: rounds of a fixed ring, passes of a servo."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray, chosen_items
from echoplan.io.passes import LEAST_TURN, pass_starts
from echoplan.model import Sweep

__all__ = ["PingColumns", "split_into_sweeps"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PingColumns:
    """Pings of all sensors.

    Parameters
    ----------
    stamps_ns : ndarray of int, shape (n,)
        Time of each ping [ns].
    sensor_ids : ndarray of int, shape (n,)
        Which sensor.
    servo_angles : ndarray, shape (n,)
        Angle of the servo [rad].
    ranges : ndarray, shape (n,)
        Readings [m] (REP 117).
    map_from_base : ndarray, shape (n, 3)
        Pose of the robot [m, m, rad].
    """

    stamps_ns: IntArray
    sensor_ids: IntArray
    servo_angles: FloatArray
    ranges: FloatArray
    map_from_base: FloatArray

    def __len__(self) -> int:
        return len(self.stamps_ns)

    def __getitem__(self, chosen: BoolArray | IntArray) -> "PingColumns":
        """Return some of the pings."""
        return chosen_items(self, chosen)


def split_into_sweeps(pings: PingColumns) -> tuple[Sweep, ...]:
    """Split pings into firing rounds, and join the rounds of one pass of the servo.

    A round ends at a pause, and where a sensor fires again.  A pass ends where the servo turns back, and after a full
    turn.
    """
    pings = pings[np.lexsort((pings.sensor_ids, pings.stamps_ns))]
    starts = _round_starts(pings.sensor_ids, pings.stamps_ns)
    angles = pings.servo_angles[starts]
    if np.ptp(np.unwrap(angles)) > LEAST_TURN:
        starts = starts[pass_starts(angles)]
    ends = np.append(starts[1:], len(pings))
    return tuple(
        Sweep(
            index=index,
            stamps_ns=pings.stamps_ns[start:end],
            sensor_ids=pings.sensor_ids[start:end],
            servo_angles=pings.servo_angles[start:end],
            ranges=pings.ranges[start:end],
            map_from_base=pings.map_from_base[start:end],
        )
        for index, (start, end) in enumerate(zip(starts, ends, strict=True))
    )


def _round_starts(sensor_ids: IntArray, stamps_ns: IntArray) -> IntArray:
    """Return where each firing round begins: after a pause, and where a sensor fires that has fired already."""
    periods = [np.diff(stamps_ns[sensor_ids == sensor]) for sensor in np.unique(sensor_ids)]
    # A pause is longer than half of the time from one firing of a sensor to its next.
    pauses = np.diff(stamps_ns, prepend=stamps_ns[0]) > 0.5 * np.median(np.concatenate([*periods, [np.inf]]))
    starts, fired = [0], set[int]()
    for place, (sensor, is_late) in enumerate(zip(sensor_ids.tolist(), pauses.tolist(), strict=True)):
        if sensor in fired or is_late:
            starts.append(place)
            fired.clear()
        fired.add(sensor)
    return np.array(starts, dtype=np.int64)
