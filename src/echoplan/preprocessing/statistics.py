"""Statistics of a recording: pings of each sensor, counted by outcome (REP 117)."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray, IntArray, known_median
from echoplan.model import Pings, Rig, Sweep
from echoplan.preprocessing.validity import is_valid

__all__ = ["RecordingStatistics", "SensorStatistics", "recording_statistics"]

_OUTCOMES = ("pings", "valid", "silent", "too_close", "faulty")


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorStatistics:
    """Pings of one sensor, counted by outcome.

    Parameters
    ----------
    sensor_id : int
        The sensor.
    pings, valid, silent, too_close, faulty : int
        All pings; those with a range within dead distance and reach; no echo; nearer than the dead distance;
        no reading at all.
    shortest, longest : float
        Least and greatest valid range [m]; nan if there is none.
    """

    sensor_id: int
    pings: int
    valid: int
    silent: int
    too_close: int
    faulty: int
    shortest: float
    longest: float


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class RecordingStatistics:
    """Duration, extent and outcome counts of a recording.

    Parameters
    ----------
    sweeps : int
        How many sweeps.
    duration : float
        From the first ping to the last [s].
    way : float
        Length of the way of the robot [m].
    low_xy, high_xy : ndarray, shape (2,)
        Corners of the box that holds all positions of the robot [m].
    temperature : float
        Of the air in the median over the sweeps [degrees Celsius]; ``nan`` if it was not measured.
    sensors : tuple of SensorStatistics
        The sensors, in the order of the rig.
    """

    sweeps: int
    duration: float
    way: float
    low_xy: FloatArray
    high_xy: FloatArray
    temperature: float
    sensors: tuple[SensorStatistics, ...]


def recording_statistics(sweeps: Iterable[Sweep], rig: Rig) -> RecordingStatistics:
    """Compute the statistics of a recording, one sweep at a time.

    Parameters
    ----------
    sweeps : iterable of Sweep
        The sweeps, at least one.
    rig : Rig
        What made them.

    Returns
    -------
    RecordingStatistics
        Counts and extents.
    """
    counts = np.zeros((len(rig.sensors), len(_OUTCOMES)), dtype=np.int64)
    extremes = np.tile([np.inf, -np.inf], (len(rig.sensors), 1))
    stations, ends_ns, temperatures = [], [], []
    for sweep in sweeps:
        pings = Pings.from_sweep(sweep, rig)
        counts += _counts(pings, rig)
        valid = is_valid(pings, rig)
        np.minimum.at(extremes[:, 0], pings.sensors[valid], pings.ranges[valid])
        np.maximum.at(extremes[:, 1], pings.sensors[valid], pings.ranges[valid])
        stations.append(sweep.map_from_base[[0, -1], :2])
        temperatures.append(sweep.temperature)
        ends_ns += [int(sweep.stamps_ns[0]), int(sweep.stamps_ns[-1])]
    positions = np.concatenate(stations)
    return RecordingStatistics(
        sweeps=len(stations),
        duration=(ends_ns[-1] - ends_ns[0]) * 1e-9,
        way=float(np.hypot(*np.diff(positions, axis=0).T).sum()),
        low_xy=positions.min(axis=0),
        high_xy=positions.max(axis=0),
        temperature=known_median(np.array(temperatures)),
        sensors=tuple(_sensor_statistics(*each) for each in zip(rig.sensor_ids, counts, extremes, strict=True)),
    )


def _counts(pings: Pings, rig: Rig) -> IntArray:
    """Outcomes by sensor, shape (s, 5); a finite range beyond the reach counts as no echo, one before as too close."""
    with np.errstate(invalid="ignore"):
        silent = pings.ranges > rig.max_ranges[pings.sensors]
        too_close = pings.ranges < rig.min_ranges[pings.sensors]
    outcomes = (np.ones(len(pings), dtype=bool), is_valid(pings, rig), silent, too_close, np.isnan(pings.ranges))
    size = len(rig.sensors)
    return np.stack([np.bincount(pings.sensors[each], minlength=size) for each in outcomes], axis=1)


def _sensor_statistics(sensor_id: int, counts: IntArray, extremes: FloatArray) -> SensorStatistics:
    shortest, longest = np.where(np.isfinite(extremes), extremes, np.nan).tolist()
    return SensorStatistics(
        sensor_id=int(sensor_id),
        shortest=shortest,
        longest=longest,
        **dict(zip(_OUTCOMES, counts.tolist(), strict=True)),
    )
