"""Pings in the order of time, split into sweeps: rounds of a fixed ring, passes of a servo."""

from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray, chosen_items
from echoplan.model import Sweep

__all__ = ["PingColumns", "split_into_sweeps"]

# A servo turns back where it does so by more than this share of its way: jitter, or the sway of a hand, is less.
_BACK = 0.1
# A servo that turns less in all [rad] stands still.
_LEAST_TURN = 0.02


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class PingColumns:
    """Pings of all sensors.

    Parameters
    ----------
    stamps_ns : ndarray of int, shape (n,)
        Time of each [ns].
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
    angles = np.unwrap(pings.servo_angles)[starts]
    if np.ptp(angles) > _LEAST_TURN:
        starts = starts[_pass_starts(angles)]
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


def _pass_starts(angles: FloatArray) -> IntArray:
    """Return at which round each pass of the servo begins: after each extreme, and after each full turn."""
    back = _BACK * min(float(np.ptp(angles)), 2.0 * np.pi)
    # The extreme of the pass so far is held from round ``first`` to ``last``: a servo may dwell there.
    starts, first, last, direction = [0], 0, 0, 0.0
    for place, angle in enumerate(angles):
        ahead = angle - angles[last]
        is_far = abs(ahead) > back
        direction = direction or float(np.sign(ahead)) * is_far
        if direction * ahead > 0.0:
            first = last = place
        elif ahead == 0.0:
            last = place
        elif is_far:
            starts.append((first + last) // 2 + 1)
            # A jump is a flyback, and tells nothing of the next direction.
            direction = 0.0 if abs(angle - angles[place - 1]) > back else -direction
            first = last = place
        if abs(angles[last] - angles[starts[-1]]) >= 2.0 * np.pi:
            starts.append(last)
    return np.array(starts, dtype=np.int64)
