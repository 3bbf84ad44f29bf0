"""Loci of echoes: the arcs on which their reflectors lie, somewhere within the beam at the measured range."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray, checked_floats, checked_integers, chosen_items, store
from echoplan.geometry import directions, wrap
from echoplan.model import Pings, Rig, Sweep
from echoplan.preprocessing import valid_pings

__all__ = ["Loci"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Loci:
    """Arcs of n echoes.

    Parameters
    ----------
    centers_xy : ndarray, shape (n, 2)
        Acoustic centres [m].
    ranges : ndarray, shape (n,)
        Radii [m].
    bearings : ndarray, shape (n,)
        Directions of the beam axes [rad].
    half_apertures : ndarray, shape (n,)
        How far the arc goes to either side of the axis [rad].
    sweeps : ndarray of int, shape (n,)
        Number of the sweep of each.

    Raises
    ------
    InvalidValueError
        If lengths differ or a number is not finite.
    """

    centers_xy: FloatArray
    ranges: FloatArray
    bearings: FloatArray
    half_apertures: FloatArray
    sweeps: IntArray

    def __post_init__(self) -> None:
        ranges = checked_floats(self.ranges, name="ranges", shape=(None,))
        count = len(ranges)
        store(
            self,
            ranges=ranges,
            centers_xy=checked_floats(self.centers_xy, name="centers_xy", shape=(count, 2)),
            bearings=checked_floats(self.bearings, name="bearings", shape=(count,)),
            half_apertures=checked_floats(self.half_apertures, name="half_apertures", shape=(count,)),
            sweeps=checked_integers(self.sweeps, name="sweeps", shape=(count,)),
        )

    def __len__(self) -> int:
        return len(self.ranges)

    def __getitem__(self, chosen: BoolArray | IntArray | slice) -> "Loci":
        """Return some of the arcs: a mask, indices or a slice."""
        return chosen_items(self, chosen)

    @classmethod
    def of(cls, sweep: Sweep, rig: Rig) -> "Loci":
        """Draw the arcs of a sweep.

        Parameters
        ----------
        sweep : Sweep
            What was recorded.
        rig : Rig
            What recorded it.

        Returns
        -------
        Loci
            One for each valid reading, in the same order.

        Raises
        ------
        UnknownNameError
            If the sweep has a sensor id that the rig has not.
        """
        pings = valid_pings(Pings.from_sweep(sweep, rig), rig)
        half_apertures = np.array([sensor.half_aperture for sensor in rig.sensors])
        return cls(
            centers_xy=pings.origins_xy,
            ranges=pings.ranges,
            bearings=pings.bearings,
            half_apertures=half_apertures[pings.sensors],
            sweeps=np.full(len(pings), sweep.index),
        )

    @classmethod
    def joined(cls, parts: Sequence["Loci"]) -> "Loci":
        """Put arcs together.

        Parameters
        ----------
        parts : sequence of Loci
            Any number of them.

        Returns
        -------
        Loci
            All of them, in order.
        """
        return cls(
            centers_xy=np.concatenate([np.zeros((0, 2)), *(part.centers_xy for part in parts)]),
            ranges=np.concatenate([np.zeros(0), *(part.ranges for part in parts)]),
            bearings=np.concatenate([np.zeros(0), *(part.bearings for part in parts)]),
            half_apertures=np.concatenate([np.zeros(0), *(part.half_apertures for part in parts)]),
            sweeps=np.concatenate([np.zeros(0, dtype=np.int64), *(part.sweeps for part in parts)]),
        )

    @property
    def middles_xy(self) -> FloatArray:
        """Points on the beam axes: what the readings would mean if sound were a ray [m], shape (n, 2)."""
        return self.points_xy(np.zeros(len(self)))

    def points_xy(self, turns: FloatArray) -> FloatArray:
        """Points on the arcs.

        Parameters
        ----------
        turns : ndarray, shape (n,) or (n, k)
            Angles from the beam axis of each arc [rad].

        Returns
        -------
        ndarray, shape (n, 2) or (n, k, 2)
            The points [m].
        """
        shape = (len(self),) + (1,) * (turns.ndim - 1)
        rays = directions(self.bearings.reshape(shape) + turns)
        points: FloatArray = self.centers_xy.reshape(*shape, 2) + self.ranges.reshape(*shape, 1) * rays
        return points

    def turns(self, points_xy: FloatArray) -> FloatArray:
        """Angles from the beam axes at which points are seen.

        Parameters
        ----------
        points_xy : ndarray, shape (n, 2)
            A point for each arc [m].

        Returns
        -------
        ndarray, shape (n,)
            Angle of the point from the beam axis [rad].
        """
        away = points_xy - self.centers_xy
        return wrap(np.arctan2(away[:, 1], away[:, 0]) - self.bearings)
