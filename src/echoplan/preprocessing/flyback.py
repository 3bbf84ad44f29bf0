"""Flyback: readings at the start of a sweep that were made while the servo was still on its way back."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.model import Sweep

__all__ = ["count_flyback_readings"]

# Sweeps of fewer readings, or over a lesser angle [rad], have no noticeable flyback; those all round have none.
_FEWEST, _LEAST, _ALL_ROUND = 20, math.radians(60.0), math.radians(330.0)
# A servo flies back if so many sweeps start where the one before did, not where it ended.
_MOST = 0.9
# The way back takes so many readings, and no more than this share of a sweep; the first is made this part of a reading
# after the servo started.
_READINGS, _PART, _DELAYS = 30, 1.0 / 3.0, (0.0, 0.25, 0.5, 0.75)
# Two readings of one direction agree to this [m], in this share of all at least; by chance no fewer do than this.
_AGREE, _AGREEING, _CHANCE = 0.05, 0.85, 0.02
# One servo in a hundred flies back like that, one in a hundred named may not; and so many ways back are tried [nats].
_EVIDENCE = 2 * math.log(100.0) + math.log(_READINGS * len(_DELAYS))
# Stands for no echo, so that it agrees with itself [m].
_NO_ECHO = 1e3


class _Scan(NamedTuple):
    """What one sensor read in one sweep."""

    angles: FloatArray
    ranges: FloatArray


def count_flyback_readings(sweeps: Sequence[Sweep], sensor_id: int, half_aperture: float) -> int:
    """Count the readings at the start of each sweep that were made on the way back of the servo.

    On its way back the servo passes, in a few readings, the directions in which it reads again on its way out.  If the
    first readings agree with those, from the last angle to the first, they belong there.

    Parameters
    ----------
    sweeps : sequence of Sweep
        All sweeps.
    sensor_id : int
        The sensor.
    half_aperture : float
        Half of its opening angle [rad].

    Returns
    -------
    int
        0 of a servo that waits until it is back, or that sweeps to and fro.
    """
    scans = _scans(sweeps, sensor_id)
    best, count = _EVIDENCE, 0
    for readings in range(1, _READINGS + 1):
        for delay in _DELAYS:
            evidence = _evidence(scans, readings, delay, half_aperture)
            if evidence > best:
                best, count = evidence, readings
    return count


def _scans(sweeps: Sequence[Sweep], sensor_id: int) -> list[_Scan]:
    """Return the scans of a sensor between which the servo goes back; none if it sweeps to and fro or all round."""
    scans: list[_Scan] = []
    backs: list[bool] = []
    for sweep in sweeps:
        own = sweep.sensor_ids == sensor_id
        angles, ranges = sweep.servo_angles[own], sweep.ranges[own]
        span = float(angles[-1] - angles[0]) if own.any() else 0.0
        if len(angles) >= _FEWEST and _LEAST < abs(span) < _ALL_ROUND and (np.diff(angles) * span >= 0.0).all():
            backs += [abs(scans[-1].angles[-1] - angles[0]) > 0.5 * abs(span)] if scans else []
            scans.append(_Scan(angles, np.where(np.isfinite(ranges), ranges, _NO_ECHO)))
    return scans if backs and np.mean(backs) >= _MOST else []


def _evidence(scans: Sequence[_Scan], readings: int, delay: float, half_aperture: float) -> float:
    """Return the log-likelihood ratio of a way back that takes so many readings, against none [nats]."""
    agreeing, by_chance = [], []
    for scan in scans:
        if readings < _PART * len(scan.angles):
            agrees, agree_with_any = _agreement(scan, readings, delay, half_aperture)
            agreeing.append(agrees)
            by_chance.append(agree_with_any)
    agreed = np.concatenate([np.zeros(0, dtype=bool), *agreeing])
    if not len(agreed):
        return 0.0
    chance = max(_CHANCE, float(np.concatenate(by_chance).mean()))
    if chance >= _AGREEING:
        return 0.0
    hit, miss = math.log(_AGREEING / chance), math.log((1.0 - _AGREEING) / (1.0 - chance))
    hits = int(agreed.sum())
    return hits * hit + (len(agreed) - hits) * miss


def _agreement(scan: _Scan, readings: int, delay: float, half_aperture: float) -> tuple[BoolArray, FloatArray]:
    """Find the first readings that agree with later ones of where the servo was, and count those that agree with any.

    Where it was less than half a beam away from where it should have been, a reading shows nothing.
    """
    last, there = scan.angles[-1], scan.angles[readings]
    passed = last + (there - last) * (np.arange(readings) + delay) / readings
    informative = np.abs(passed - scan.angles[:readings]) > half_aperture
    later = np.lib.stride_tricks.sliding_window_view(scan.ranges[readings:], 3)
    agree: BoolArray = np.any(np.abs(scan.ranges[:readings, None, None] - later) <= _AGREE, axis=-1)
    nearest = np.abs(scan.angles[readings + 1 : -1] - passed[:, None]).argmin(axis=1)
    return agree[np.arange(readings), nearest][informative], agree.mean(axis=1)[informative]
