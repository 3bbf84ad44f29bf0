"""Sweeps: the pings of one pass of the array, as they were recorded and as they lie in the map."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from echoplan.arrays import (
    BoolArray,
    FloatArray,
    IntArray,
    checked_floats,
    checked_integers,
    checked_number,
    chosen_items,
    store,
)
from echoplan.errors import InvalidValueError
from echoplan.geometry import compose, transform_points
from echoplan.model.rig import Rig

__all__ = ["COLDEST", "HOTTEST", "Pings", "Recording", "Source", "Sweep"]

# Air in which anybody measures [degrees Celsius].
COLDEST, HOTTEST = -30.0, 60.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Sweep:
    """The pings of one pass of the array at one station, or of one firing of a fixed ring.

    Parameters
    ----------
    index : int
        Number of the sweep in the recording.
    stamps_ns : ndarray of int, shape (n,)
        Time of each ping [ns], not decreasing.
    sensor_ids : ndarray of int, shape (n,)
        Which sensor fired and received.
    servo_angles : ndarray, shape (n,)
        Turn of the servo [rad], 0 for fixed sensors.
    ranges : ndarray, shape (n,)
        Readings from the sensor's face [m]; ``inf`` no echo, ``-inf`` too close, ``nan`` faulty (REP 117).
    map_from_base : ndarray, shape (n, 3)
        Pose of the robot at each ping [m, m, rad].
    temperature : float, optional
        Temperature of the air [degrees Celsius]; ``nan`` where it was not measured.

    Raises
    ------
    InvalidValueError
        If lengths differ, times go back, a finite range is negative, a pose is not finite or no air is so warm.
    """

    index: int
    stamps_ns: IntArray
    sensor_ids: IntArray
    servo_angles: FloatArray
    ranges: FloatArray
    map_from_base: FloatArray
    temperature: float = math.nan

    def __post_init__(self) -> None:
        checked_number(self.index, name="index", minimum=0)
        if not math.isnan(self.temperature):
            checked_number(self.temperature, name="temperature", minimum=COLDEST, maximum=HOTTEST)
        stamps = checked_integers(self.stamps_ns, name="stamps_ns", shape=(None,))
        count = len(stamps)
        ranges = checked_floats(self.ranges, name="ranges", shape=(count,), finite=False)
        if (np.diff(stamps) < 0).any():
            raise InvalidValueError(f"stamps_ns must not go back; sweep {self.index} does")
        if (np.isfinite(ranges) & (ranges < 0)).any():
            raise InvalidValueError(f"ranges must not be negative, not {ranges[np.isfinite(ranges)].min():g}")
        store(
            self,
            stamps_ns=stamps,
            sensor_ids=checked_integers(self.sensor_ids, name="sensor_ids", shape=(count,)),
            servo_angles=checked_floats(self.servo_angles, name="servo_angles", shape=(count,)),
            ranges=ranges,
            map_from_base=checked_floats(self.map_from_base, name="map_from_base", shape=(count, 3)),
        )

    def __len__(self) -> int:
        return len(self.stamps_ns)

    @property
    def station(self) -> FloatArray:
        """Pose of the robot halfway through the sweep [m, m, rad], shape (3,)."""
        middle: FloatArray = self.map_from_base[len(self) // 2]
        return middle

    @property
    def station_ns(self) -> int:
        """When the robot was at the station [ns]."""
        return int(self.stamps_ns[len(self) // 2])

    def __getitem__(self, chosen: BoolArray | IntArray | slice) -> "Sweep":
        """Return some of the pings: a mask, indices or a slice."""
        columns = ("stamps_ns", "sensor_ids", "servo_angles", "ranges", "map_from_base")
        return replace(self, **{name: getattr(self, name)[chosen] for name in columns})


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Pings:
    """Pings as they lie in the map: where each sensor was, where it looked and what it read.

    Parameters
    ----------
    origins_xy : ndarray, shape (n, 2)
        Acoustic centres [m].
    hubs_xy : ndarray, shape (n, 2)
        The turret's axis at each ping [m].
    bearings : ndarray, shape (n,)
        Directions of the beam axes in the map [rad].
    ranges : ndarray, shape (n,)
        Readings from the face of the sensor [m] (REP 117).
    sensors : ndarray of int, shape (n,)
        Index of the sensor in the rig.

    Raises
    ------
    InvalidValueError
        If lengths differ or a position or direction is not finite.
    """

    origins_xy: FloatArray
    hubs_xy: FloatArray
    bearings: FloatArray
    ranges: FloatArray
    sensors: IntArray

    def __post_init__(self) -> None:
        ranges = checked_floats(self.ranges, name="ranges", shape=(None,), finite=False)
        count = len(ranges)
        store(
            self,
            origins_xy=checked_floats(self.origins_xy, name="origins_xy", shape=(count, 2)),
            hubs_xy=checked_floats(self.hubs_xy, name="hubs_xy", shape=(count, 2)),
            bearings=checked_floats(self.bearings, name="bearings", shape=(count,)),
            ranges=ranges,
            sensors=checked_integers(self.sensors, name="sensors", shape=(count,)),
        )

    def __len__(self) -> int:
        return len(self.ranges)

    def __getitem__(self, chosen: BoolArray | IntArray | slice) -> "Pings":
        """Return some of the pings: a mask, indices or a slice."""
        return chosen_items(self, chosen)

    @classmethod
    def from_sweep(cls, sweep: Sweep, rig: Rig) -> "Pings":
        """Place the pings of a sweep in the map.

        Parameters
        ----------
        sweep : Sweep
            What was recorded.
        rig : Rig
            What recorded it.

        Returns
        -------
        Pings
            The same pings, in the same order.

        Raises
        ------
        UnknownNameError
            If the sweep has a sensor id that the rig has not.
        """
        in_base = rig.base_from_sensors(sweep.sensor_ids, sweep.servo_angles)
        in_map = compose(sweep.map_from_base, in_base)
        return cls(
            origins_xy=in_map[:, :2],
            hubs_xy=transform_points(sweep.map_from_base, rig.base_from_turret[:2]),
            bearings=in_map[:, 2],
            ranges=sweep.ranges,
            sensors=rig.indices(sweep.sensor_ids),
        )


class Source(Protocol):
    """Where sweeps come from: a recording, a serial port and the simulator are the same to a mapper."""

    @property
    def name(self) -> str:
        """What to call the source in messages and results."""
        ...

    @property
    def rig(self) -> Rig:
        """What made the sweeps."""
        ...

    def __iter__(self) -> Iterator[Sweep]:
        """Yield the sweeps in the order of time."""
        ...

    def __len__(self) -> int:
        """Return the number of sweeps, for a progress bar."""
        ...


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Recording:
    """Sweeps in memory, with the rig that made them: the plainest source.

    Parameters
    ----------
    name : str
        What to call it.
    rig : Rig
        What made the sweeps.
    sweeps : tuple of Sweep
        The sweeps in the order of time.
    notes : tuple of str, optional
        What the user should know about how they were read.
    """

    name: str
    rig: Rig
    sweeps: tuple[Sweep, ...]
    notes: tuple[str, ...] = ()

    def __iter__(self) -> Iterator[Sweep]:
        return iter(self.sweeps)

    def __len__(self) -> int:
        return len(self.sweeps)
