"""Stations: sweeps from nearly the same place count as one."""

import math
from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import compose, invert, wrap
from echoplan.preprocessing.measurements import Measurements, as_sent, halfway, select_measurements
from echoplan.settings import Settings

__all__ = ["StationSettings", "Stations", "at_stations", "group_sweeps", "without_repeats"]

# Pings of one sensor are the same if they start this near to each other and look in directions this near [m, rad].
_SAME_PLACE, _SAME_DIRECTION = 0.01, math.radians(0.1)


class StationSettings(Settings):
    """What is one station."""

    former_keys: ClassVar = {
        "way": "max_distance",
        "turn": "max_turn",
        "most_pings": "max_pings",
        "same_way": "repeat_distance",
        "same_turn": "repeat_turn",
    }

    max_distance: float = Field(
        default=0.15, ge=0.0, description="Largest distance between sweeps of one station for fixed sensors [m]."
    )
    max_turn: float = Field(
        default=math.radians(15),
        ge=0.0,
        description="Largest turn between sweeps of one station for fixed sensors [rad].",
    )
    max_pings: int = Field(
        default=100,
        ge=1,
        description="Largest number of pings of sweeps that are joined to a station, unless they repeat each other.",
    )
    # Largest distance between sweeps that repeat each other [m]: a wavelength at 40 kHz.
    repeat_distance: ClassVar[float] = 0.01
    # Largest turn between sweeps that repeat each other [rad]: a step of a servo.
    repeat_turn: ClassVar[float] = math.radians(1.0)


class Stations(NamedTuple):
    """Which sweeps belong to which station.

    Attributes
    ----------
    numbers : ndarray of int, shape (w,)
        Station of each sweep.
    poses : ndarray, shape (s, 3)
        Pose of the first sweep of each station, as recorded [m, m, rad].
    """

    numbers: IntArray
    poses: FloatArray

    def of_sweeps(self, recorded: FloatArray, poses: FloatArray) -> FloatArray:
        """Carry corrected poses of stations over to their sweeps.

        Parameters
        ----------
        recorded : ndarray, shape (w, 3)
            Poses of the sweeps as recorded [m, m, rad].
        poses : ndarray, shape (s, 3)
            Corrected poses of the stations.

        Returns
        -------
        ndarray, shape (w, 3)
            Corrected poses of the sweeps: as far from their stations as they were recorded.
        """
        if (poses == self.poses).all():
            return recorded
        own = self.numbers
        carried: FloatArray = compose(poses[own], compose(invert(self.poses[own]), recorded))
        return carried


def group_sweeps(recorded: FloatArray, pings: IntArray, settings: StationSettings) -> Stations:
    """Group sweeps that follow each other from the same pose, or, if they have few pings, from nearly the same.

    Parameters
    ----------
    recorded : ndarray, shape (w, 3)
        Poses of the sweeps [m, m, rad].
    pings : ndarray of int, shape (w,)
        How many pings each has.
    settings : StationSettings
        What is one station.

    Returns
    -------
    Stations
        The groups, in the order of time.

    Examples
    --------
    >>> way = np.array([[0.0, 0, 0], [0.1, 0, 0], [0.2, 0, 0]])
    >>> group_sweeps(way, np.array([8, 8, 8]), StationSettings()).numbers
    array([0, 0, 1])
    """
    firsts, numbers, together = [0], [0], int(pings[0])
    for sweep in range(1, len(recorded)):
        step = recorded[sweep] - recorded[firsts[-1]]
        way, turn = math.hypot(step[0], step[1]), abs(float(wrap(step[2])))
        near = way <= settings.max_distance and turn <= settings.max_turn
        # Two sweeps of so many pings never make a station, unless one repeats the other.
        is_repeat = (
            way <= settings.repeat_distance and turn <= settings.repeat_turn and 2 * pings[sweep] > settings.max_pings
        )
        together += 0 if is_repeat else int(pings[sweep])
        if not (is_repeat or (near and together <= settings.max_pings)):
            firsts.append(sweep)
            together = int(pings[sweep])
        numbers.append(len(firsts) - 1)
    return Stations(np.array(numbers), recorded[firsts])


def at_stations(measurements: Measurements, stations: Stations) -> Measurements:
    """Give pings the numbers of stations instead of sweeps.

    Parameters
    ----------
    measurements : Measurements
        Numbered by sweep.
    stations : Stations
        The station of each sweep.

    Returns
    -------
    Measurements
        The same pings.
    """
    count = np.bincount(stations.numbers)
    sums = [np.bincount(stations.numbers, column) for column in measurements.centers.T]
    centers = np.column_stack(sums) / count[:, None]
    return measurements._replace(stations=stations.numbers[measurements.stations], centers=centers)


def without_repeats(measurements: Measurements) -> Measurements:
    """Make one ping of all that a turning sensor made at one place in one direction: the median of their readings.

    What the model of the sonar lacks is the same in all of them, and so they say little more than one does.

    Parameters
    ----------
    measurements : Measurements
        At stations.

    Returns
    -------
    Measurements
        The first of such pings each.  Those of a servo that turns the other way stay, for they determine its latency,
        but both count as one.
    """
    if not measurements.rates.any():
        # Repeats of fixed sensors show how much their readings scatter, and a station has few of them.
        return measurements
    sent = as_sent(measurements)
    where = np.column_stack([sent.x, sent.y, sent.bearings]) / (_SAME_PLACE, _SAME_PLACE, _SAME_DIRECTION)
    # A quarter of a cell aside, so that round numbers do not lie on the border of two.
    keys = np.column_stack([sent.stations, sent.sensors, np.round(where + 0.25), np.sign(sent.rates)])
    _, firsts, groups, counts = np.unique(keys, axis=0, return_index=True, return_inverse=True, return_counts=True)
    _, ways, repeats = np.unique(keys[firsts, :-1], axis=0, return_inverse=True, return_counts=True)
    if len(repeats) == len(keys):
        return measurements
    order = np.lexsort((sent.readings, groups.ravel()))
    # Of an even number the lower one: half way to no echo there is nothing.
    middles = order[np.cumsum(counts) - counts + (counts - 1) // 2]
    readings, weights, kept = sent.readings.copy(), sent.weights.copy(), np.zeros(len(keys), dtype=bool)
    readings[firsts], kept[firsts] = sent.readings[middles], True
    weights[firsts] /= repeats[ways.ravel()]
    return halfway(select_measurements(sent._replace(readings=readings, weights=weights), kept))
