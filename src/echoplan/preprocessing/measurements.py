"""Measurements: the pings of many sweeps as plain arrays, without invalid readings, for compiled functions."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from echoplan.acoustics import Air
from echoplan.arrays import BoolArray, FloatArray, IntArray, known_median
from echoplan.geometry import directions, rotation_step, wrap
from echoplan.model import Pings, Rig, Sweep
from echoplan.preprocessing.validity import valid_ranges

__all__ = [
    "Measurements",
    "as_sent",
    "first_stations",
    "halfway",
    "independent",
    "join_measurements",
    "measurements_of",
    "rearranged_stations",
    "select_measurements",
    "step_of",
    "turned",
]

# Pings this far apart detect a reflector independently of each other [rad]; nearer ones share their errors.
_INDEPENDENT = np.radians(4.0)
# A burst older than this comes from farther than the reach of any sonar of this kind [s].
_MEMORY = 0.06
# A robot whose poses differ by less from ping to ping stood: the difference is a rounding error [m].
_STOOD = 1e-6
# What modules take the speed of sound to be [m/s].
_SPEED = Air().speed_of_sound
# What there is one of for each ping.
_BY_PING = (
    "x", "y", "ux", "uy", "arms_x", "arms_y", "angles", "rates", "readings", "stations", "sensors",
    "crosstalk_sources", "crosstalk_delays", "weights", "ways",
)  # fmt: skip


class Measurements(NamedTuple):
    """Pings of s stations as n-vectors.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Acoustic centres [m].
    ux, uy : ndarray, shape (n,)
        Unit vectors of the beam axes.
    arms_x, arms_y : ndarray, shape (n,)
        From the axis of the servo to the acoustic centre [m].
    angles : ndarray, shape (n,)
        Where the servo was, as recorded [rad].
    rates : ndarray, shape (n,)
        How fast the servo turned [rad/s].
    readings : ndarray, shape (n,)
        Readings [m]; ``inf`` where nothing was detected.
    stations : ndarray of int, shape (n,)
        Number of the station, from 0.
    sensors : ndarray of int, shape (n,)
        Index of the sensor in the rig.
    crosstalk_sources : ndarray of int, shape (n, m)
        Pings whose bursts this one may have received, too: those that other sensors fired at the same time, and those
        of the firing before; -1 fills up.
    crosstalk_delays : ndarray, shape (n, m)
        How long before this ping each of them was fired [s].
    weights : ndarray, shape (n,)
        How much a ping counts beside its neighbours.
    ways : ndarray, shape (n,)
        How far the robot drove by its odometry from the pose of the sweep to each ping, negative before it [m]; a turn
        of a radian counts as a metre. Zero if it stood.
    centers : ndarray, shape (s, 2)
        Mean acoustic centre of each station [m].
    min_range, max_range : float
        Dead distance and reach [m].
    temperature : float
        Of the air in the median [degrees Celsius]; ``nan`` if it was not measured.
    """

    x: FloatArray
    y: FloatArray
    ux: FloatArray
    uy: FloatArray
    arms_x: FloatArray
    arms_y: FloatArray
    angles: FloatArray
    rates: FloatArray
    readings: FloatArray
    stations: IntArray
    sensors: IntArray
    crosstalk_sources: IntArray
    crosstalk_delays: FloatArray
    weights: FloatArray
    ways: FloatArray
    centers: FloatArray
    min_range: float
    max_range: float
    temperature: float = math.nan

    @property
    def bearings(self) -> FloatArray:
        """Directions of the beam axes [rad], shape (n,)."""
        return np.arctan2(self.uy, self.ux)


def measurements_of(sweep: Sweep, rig: Rig) -> Measurements:
    """Collect the readings of a sweep, as ``valid_ranges`` interprets them.

    Parameters
    ----------
    sweep : Sweep
        The pings.
    rig : Rig
        What made them.

    Returns
    -------
    Measurements
        One station.
    """
    pings = Pings.from_sweep(sweep, rig)
    readings = valid_ranges(pings, rig)
    valid = ~np.isnan(readings)
    kept = pings[valid]
    axes = directions(kept.bearings)
    crosstalk_sources, crosstalk_delays = _crosstalk_sources(sweep.stamps_ns[valid])
    weight = min(1.0, rotation_step(kept.bearings) / _INDEPENDENT) if len(kept) else 1.0
    center = kept.origins_xy.mean(axis=0) if len(kept) else sweep.station[:2]
    measurements = Measurements(
        x=kept.origins_xy[:, 0].copy(),
        y=kept.origins_xy[:, 1].copy(),
        ux=axes[:, 0].copy(),
        uy=axes[:, 1].copy(),
        arms_x=kept.origins_xy[:, 0] - kept.hubs_xy[:, 0],
        arms_y=kept.origins_xy[:, 1] - kept.hubs_xy[:, 1],
        angles=sweep.servo_angles[valid],
        rates=_rates(sweep.stamps_ns, sweep.servo_angles)[valid],
        readings=readings[valid],
        stations=np.zeros(len(kept), dtype=np.int64),
        sensors=kept.sensors.copy(),
        crosstalk_sources=crosstalk_sources,
        crosstalk_delays=crosstalk_delays,
        weights=np.full(len(kept), weight),
        ways=_ways(sweep)[valid],
        centers=center[None],
        min_range=float(rig.min_ranges.max()),
        max_range=float(rig.max_ranges.max()),
        temperature=sweep.temperature,
    )
    return halfway(measurements)


def join_measurements(parts: Sequence[Measurements]) -> Measurements:
    """Put the pings of stations together.

    Parameters
    ----------
    parts : sequence of Measurements
        One station each, at least one.

    Returns
    -------
    Measurements
        The stations are numbered in the given order.
    """
    counts = [len(part.readings) for part in parts]
    names = {*_BY_PING, "centers"} - {"crosstalk_sources", "crosstalk_delays"}
    joined = {name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    joined["stations"] = np.repeat(np.arange(len(parts)), counts)
    return Measurements(
        **joined,
        crosstalk_sources=_stacked(_renumbered(parts, np.cumsum([0, *counts[:-1]])), fill=-1),
        crosstalk_delays=_stacked([part.crosstalk_delays for part in parts], fill=0),
        min_range=max(part.min_range for part in parts),
        max_range=max(part.max_range for part in parts),
        temperature=known_median(np.array([part.temperature for part in parts])),
    )


def select_measurements(measurements: Measurements, kept: BoolArray) -> Measurements:
    """Keep some of the pings.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    kept : ndarray of bool, shape (n,)
        Which to keep.

    Returns
    -------
    Measurements
        Of the same stations.
    """
    if kept.all():
        return measurements
    numbers = np.append(np.where(kept, np.cumsum(kept) - 1, -1), -1)
    rest = {name: getattr(measurements, name)[kept] for name in _BY_PING}
    return measurements._replace(**rest)._replace(crosstalk_sources=numbers[measurements.crosstalk_sources[kept]])


def first_stations(measurements: Measurements, count: int) -> Measurements:
    """Keep the first stations.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    count : int
        Of how many stations.

    Returns
    -------
    Measurements
        The pings of these stations.
    """
    kept = select_measurements(measurements, measurements.stations < count)
    return kept._replace(centers=measurements.centers[:count])


def rearranged_stations(measurements: Measurements, order: Sequence[int]) -> Measurements:
    """Give stations other numbers.

    Parameters
    ----------
    measurements : Measurements
        As they are.
    order : sequence of int
        Which station is the first from now on, which the second.

    Returns
    -------
    Measurements
        Station after station.  Stations that follow each other are no longer neighbours on the path of the robot, so
        each counts as if the robot had stood.
    """
    parts = [select_measurements(measurements, measurements.stations == station) for station in order]
    return join_measurements(
        [
            part._replace(centers=measurements.centers[[station]], ways=np.zeros(len(part.ways)))
            for part, station in zip(parts, order, strict=True)
        ]
    )


def independent(measurements: Measurements) -> BoolArray:
    """Choose as few pings as are independent of each other, evenly around each station.

    Parameters
    ----------
    measurements : Measurements
        The pings.

    Returns
    -------
    ndarray of bool, shape (n,)
        Every k-th ping around each station; all of them where they are far apart.
    """
    # A step of 2 degrees may come out a rounding above it: it still takes two of them.
    stride = int(1.0 / float(np.median(measurements.weights)) + 1e-6) if len(measurements.weights) else 1
    order = np.lexsort((measurements.bearings, measurements.stations))
    kept = np.zeros(len(order), dtype=bool)
    kept[order[:: max(stride, 1)]] = True
    return kept


def step_of(measurements: Measurements) -> float:
    """Return how far a sonar turns from one ping to the next; of a ring, how far apart its sensors look.

    Parameters
    ----------
    measurements : Measurements
        The pings.

    Returns
    -------
    float
        From their weights, or where pings are too far apart for these, from their directions [rad]; ``inf`` without
        pings.
    """
    if not len(measurements.weights):
        return np.inf
    share = float(np.median(measurements.weights))
    return _INDEPENDENT * share if share < 1.0 else _spacing(measurements)


def _spacing(measurements: Measurements) -> float:
    """Return how far apart independent pings look; what is nearer is of another sweep at the same station."""
    order = np.lexsort((measurements.bearings, measurements.stations))
    bearings, stations = measurements.bearings[order], measurements.stations[order]
    gaps = np.diff(bearings)[np.diff(stations) == 0]
    wide = gaps[gaps > _INDEPENDENT]
    return float(np.median(wide)) if len(wide) else float(_INDEPENDENT)


def halfway(measurements: Measurements) -> Measurements:
    """Turn pings on to where they looked halfway between sending and receiving.

    A servo turns on while sound is under way: a ping is sent in one direction and received in another, and the beam
    there and back is that of the direction between them.  Where nothing was detected, sound is taken to have come half
    as far as it could.
    """
    return turned(measurements, _turns_under_way(measurements))


def as_sent(measurements: Measurements) -> Measurements:
    """Turn pings back to where they looked when they were sent: the inverse of ``halfway``."""
    return turned(measurements, -_turns_under_way(measurements))


def _turns_under_way(measurements: Measurements) -> FloatArray:
    """By how much the servo turns while sound comes half of its way [rad]."""
    ways = np.where(np.isfinite(measurements.readings), measurements.readings, 0.5 * measurements.max_range)
    turns: FloatArray = measurements.rates * ways / _SPEED
    return turns


def turned(measurements: Measurements, angles: FloatArray) -> Measurements:
    """Turn the servo under each ping by an angle, shape (n,) [rad]."""
    turn = np.exp(1j * angles)
    axes = (measurements.ux + 1j * measurements.uy) * turn
    arms = measurements.arms_x + 1j * measurements.arms_y
    moved = arms * turn
    return measurements._replace(
        x=measurements.x + (moved - arms).real,
        y=measurements.y + (moved - arms).imag,
        ux=axes.real.copy(),
        uy=axes.imag.copy(),
        arms_x=moved.real.copy(),
        arms_y=moved.imag.copy(),
    )


def _rates(stamps_ns: IntArray, angles: FloatArray) -> FloatArray:
    """Find how fast a servo turned at each ping: the slope between its neighbours in time [rad/s]."""
    times, firsts = np.unique(stamps_ns, return_index=True)
    if len(times) < 2:
        return np.zeros(len(stamps_ns))
    slopes = np.gradient(angles[firsts], 1e-9 * (times - times[0]))
    return np.asarray(np.interp(stamps_ns, times, slopes), dtype=np.float64)


def _ways(sweep: Sweep) -> FloatArray:
    """Find how far the robot drove from the pose of the sweep to each ping [m]; a turn of a radian is a metre."""
    steps = np.diff(sweep.map_from_base, axis=0)
    lengths = np.hypot(steps[:, 0], steps[:, 1]) + np.abs(wrap(steps[:, 2]))
    ways = np.concatenate([[0.0], np.cumsum(np.where(lengths > _STOOD, lengths, 0.0))])
    return np.asarray(ways - ways[len(sweep) // 2], dtype=np.float64)


def _crosstalk_sources(stamps_ns: IntArray) -> tuple[IntArray, FloatArray]:
    """Find the other pings of each volley, and those of the volley before; pings of one time lie side by side."""
    starts = np.flatnonzero(np.diff(stamps_ns, prepend=stamps_ns[:1] - 1))
    sizes = np.diff(starts, append=len(stamps_ns))
    volleys, most = np.repeat(np.arange(len(starts)), sizes), int(sizes.max(initial=1))
    beside = np.arange(len(stamps_ns)) - starts[volleys]
    turns = np.arange(1, most)
    own = starts[volleys][:, None] + (beside[:, None] + turns) % sizes[volleys][:, None]
    own = np.where(turns < sizes[volleys][:, None], own, -1)
    waits = np.diff(1e-9 * stamps_ns[starts], prepend=-np.inf)[volleys]
    places = np.arange(most)
    is_recent = (places < sizes[volleys - 1][:, None]) & (waits < _MEMORY)[:, None]
    before = np.where(is_recent, starts[volleys - 1][:, None] + places, -1)
    crosstalk_delays = np.concatenate([np.zeros(own.shape), np.where(is_recent, waits[:, None], 0.0)], axis=1)
    return np.concatenate([own, before], axis=1), crosstalk_delays


def _renumbered(parts: Sequence[Measurements], starts: IntArray) -> list[IntArray]:
    """Give crosstalk_sources the numbers that they have among the pings of all parts."""
    return [
        np.where(part.crosstalk_sources < 0, -1, part.crosstalk_sources + start)
        for part, start in zip(parts, starts, strict=True)
    ]


def _stacked(parts: Sequence[Any], *, fill: int) -> Any:
    """Put arrays one below the other, each as wide as the widest."""
    width = max(part.shape[1] for part in parts)
    padding = [((0, 0), (0, width - part.shape[1])) for part in parts]
    return np.concatenate([np.pad(part, pad, constant_values=fill) for part, pad in zip(parts, padding, strict=True)])
