"""Cones: what pings say about the space before them, as plain arrays for compiled functions."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry import directions
from echoplan.model import Pings, Rig, Sweep
from echoplan.preprocessing import valid_ranges

__all__ = ["Cones", "chosen_cones", "cones_of", "join_cones"]


class Cones(NamedTuple):
    """The cones of n pings.

    Attributes
    ----------
    x, y : ndarray, shape (n,)
        Acoustic centres [m].
    ux, uy : ndarray, shape (n,)
        Unit vectors of the beam axes.
    half_apertures : ndarray, shape (n,)
        Half the opening of the cone [rad], at most a quarter turn: no sensor detects what is behind it.
    readings : ndarray, shape (n,)
        Readings [m]; ``inf`` without an echo.
    blanks : ndarray, shape (n,)
        Dead distances, within which nothing can be detected [m].
    reaches : ndarray, shape (n,)
        Ranges of the sensors [m].
    hub_x, hub_y : ndarray, shape (n,)
        Where the turret's axis was [m]: it stays in place while the sensors turn about it.
    """

    x: FloatArray
    y: FloatArray
    ux: FloatArray
    uy: FloatArray
    half_apertures: FloatArray
    readings: FloatArray
    blanks: FloatArray
    reaches: FloatArray
    hub_x: FloatArray
    hub_y: FloatArray


def cones_of(sweep: Sweep, rig: Rig) -> Cones:
    """Take the cones of a sweep, as ``valid_ranges`` interprets it.

    Parameters
    ----------
    sweep : Sweep
        The pings.
    rig : Rig
        What made them.

    Returns
    -------
    Cones
        Of the pings that say something, in the same order.

    Raises
    ------
    UnknownNameError
        If the sweep has a sensor id that the rig has not.
    """
    pings = Pings.from_sweep(sweep, rig)
    apertures = np.array([sensor.half_aperture for sensor in rig.sensors])[pings.sensors]
    axes = directions(pings.bearings)
    every = Cones(
        x=pings.origins_xy[:, 0],
        y=pings.origins_xy[:, 1],
        ux=axes[:, 0],
        uy=axes[:, 1],
        half_apertures=np.minimum(apertures, np.pi / 2),
        readings=valid_ranges(pings, rig),
        blanks=rig.min_ranges[pings.sensors],
        reaches=rig.max_ranges[pings.sensors],
        hub_x=pings.hubs_xy[:, 0],
        hub_y=pings.hubs_xy[:, 1],
    )
    return chosen_cones(every, ~np.isnan(every.readings))


def chosen_cones(cones: Cones, chosen: BoolArray | IntArray | slice) -> Cones:
    """Keep some cones.

    Parameters
    ----------
    cones : Cones
        The cones.
    chosen : ndarray or slice
        A mask, indices or a slice.

    Returns
    -------
    Cones
        Those, in memory of their own.
    """
    return Cones(*(np.array(field[chosen]) for field in cones))


def join_cones(parts: Sequence[Cones]) -> Cones:
    """Put cones together.

    Parameters
    ----------
    parts : sequence of Cones
        Any number of them.

    Returns
    -------
    Cones
        All of them, in order.
    """
    fields = zip(*parts, strict=True) if parts else ((),) * len(Cones._fields)
    return Cones(*(np.concatenate([np.zeros(0), *arrays]) for arrays in fields))
