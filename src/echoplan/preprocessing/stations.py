"""Stations: sweeps that heard the world from nearly the same place count as one."""

import math
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import compose, invert, wrap
from echoplan.preprocessing.soundings import Soundings

__all__ = ["StationSettings", "Stations", "at_stations", "group_sweeps"]


class StationSettings(BaseModel, frozen=True, extra="forbid"):
    """What is one station."""

    way: float = Field(default=0.15, ge=0.0, description="within which fixed sensors hear the same [m]")
    turn: float = Field(default=math.radians(15), ge=0.0, description="likewise [rad]")
    most_pings: int = Field(default=100, ge=1, description="more are a station by themselves")


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
    """Group sweeps of few pings that follow each other from nearly the same pose.

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
        near = math.hypot(step[0], step[1]) <= settings.way and abs(float(wrap(step[2]))) <= settings.turn
        together += int(pings[sweep])
        if not near or together > settings.most_pings:
            firsts.append(sweep)
            together = int(pings[sweep])
        numbers.append(len(firsts) - 1)
    return Stations(np.array(numbers), recorded[firsts])


def at_stations(soundings: Soundings, stations: Stations) -> Soundings:
    """Give soundings the numbers of stations instead of sweeps.

    Parameters
    ----------
    soundings : Soundings
        Numbered by sweep.
    stations : Stations
        The station of each sweep.

    Returns
    -------
    Soundings
        The same pings.
    """
    count = np.bincount(stations.numbers)
    sums = [np.bincount(stations.numbers, column) for column in soundings.centers.T]
    centers = np.column_stack(sums) / count[:, None]
    return soundings._replace(stations=stations.numbers[soundings.stations], centers=centers)
