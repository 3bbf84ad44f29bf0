"""Whether each sensor works, by its last readings: what a builder wants to see at once."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model import Rig, Sweep

__all__ = ["SensorHealth", "SensorState", "sensor_health"]

# Fewer pings of a sensor do not show whether it works.
_FEWEST = 20
# A stuck sensor reads one value, to this width [m], in at least this share of its readings: as in preprocessing.
_STUCK_WIDTH, _STUCK_SHARE = 0.01, 0.95


class SensorState(StrEnum):
    """What the last readings of a sensor show."""

    WAITING = "waiting"
    GOOD = "good"
    SILENT = "silent"
    STUCK = "stuck"


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorHealth:
    """The last readings of one sensor.

    Parameters
    ----------
    sensor_id : int
        The sensor.
    pings : int
        How many pings were looked at.
    share : float
        Share of them with a reading between dead distance and reach.
    state : SensorState
        What they show.
    """

    sensor_id: int
    pings: int
    share: float
    state: SensorState


def sensor_health(sweeps: Sequence[Sweep], rig: Rig) -> Iterator[SensorHealth]:
    """Look at the readings of each sensor of a rig in its last sweeps: two are enough for a sensor on a servo."""
    ids = np.concatenate([np.zeros(0, dtype=np.int64), *(sweep.sensor_ids for sweep in sweeps)])
    ranges = np.concatenate([np.zeros(0), *(sweep.ranges for sweep in sweeps)])
    for sensor in rig.sensors:
        own = ranges[ids == sensor.sensor_id]
        with np.errstate(invalid="ignore"):
            valid = own[(own >= sensor.min_range) & (own <= sensor.max_range)]
        yield SensorHealth(
            sensor_id=sensor.sensor_id,
            pings=len(own),
            share=len(valid) / max(len(own), 1),
            state=_state(valid, usual=max(len(own), len(ranges) // len(rig.sensors))),
        )


def _state(valid: FloatArray, *, usual: int) -> SensorState:
    """Judge the readings of a sensor, where so many pings are usual for a sensor of its rig."""
    if usual < _FEWEST:
        return SensorState.WAITING
    if not len(valid):
        return SensorState.SILENT
    near = np.abs(valid - np.median(valid)) <= _STUCK_WIDTH / 2
    is_stuck = len(valid) >= _FEWEST and near.mean() >= _STUCK_SHARE
    return SensorState.STUCK if is_stuck else SensorState.GOOD
