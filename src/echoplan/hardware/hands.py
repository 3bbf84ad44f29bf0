"""Hands in the sweeps of a device: which sensor is covered, and on which side of the servo a hand is held."""

import math
from collections.abc import Sequence

import numpy as np

from echoplan.model import Sweep

__all__ = ["covered_sensors", "hand_side"]

# A hand over a sensor reads less than this [m], in this share of the pings: hands are not flat, nor quite still.
_COVERED, _COVERED_SHARE = 0.15, 0.6
# A hand held 30 cm from the robot reads from here to there [m], in at least so many pings, which differ by so much [m].
_NEAREST, _FARTHEST, _FEWEST, _DEPTH = 0.08, 0.5, 4, 0.03


def covered_sensors(sweeps: Sequence[Sweep]) -> list[int]:
    """Return the sensors that read too close, or hardly anything, most of the time."""
    sensor_ids = np.concatenate([sweep.sensor_ids for sweep in sweeps])
    is_short = np.concatenate([sweep.ranges for sweep in sweeps]) < _COVERED
    return [int(each) for each in np.unique(sensor_ids) if is_short[sensor_ids == each].mean() >= _COVERED_SHARE]


def hand_side(sweeps: Sequence[Sweep], *, sensor_id: int) -> float:
    """Return the share of a hand's echoes that come from positive recorded angles; nan if there is no hand."""
    own = [sweep.sensor_ids == sensor_id for sweep in sweeps]
    angles = np.concatenate([sweep.servo_angles[chosen] for sweep, chosen in zip(sweeps, own, strict=True)])
    ranges = np.concatenate([sweep.ranges[chosen] for sweep, chosen in zip(sweeps, own, strict=True)])
    is_near = (ranges > _NEAREST) & (ranges < _FARTHEST)
    hand = angles[is_near & (ranges < np.min(ranges, where=is_near, initial=_FARTHEST) + _DEPTH)]
    return float(np.mean(hand > 0)) if len(hand) >= _FEWEST else math.nan
