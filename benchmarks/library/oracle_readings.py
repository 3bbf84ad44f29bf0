"""Oracle readings: the readings of a recording that may be echoes of a true wall."""

import math
from collections.abc import Sequence

import numpy as np

from echoplan.arrays import FloatArray, IntArray
from echoplan.geometry import directions, wrap
from echoplan.model import Pings, Rig, Sweep

__all__ = ["readings_of"]

# An echo is read no more than this too near, and with its range walk no more than this too far [m].
NEARER, FARTHER = 0.01, 0.05
# No sensor detects a wall farther off its axis than this [rad].
OBLIQUE = math.radians(40.0)


def readings_of(wall_xy: FloatArray, sweeps: Sequence[Sweep], rig: Rig) -> IntArray:
    """Count the readings of each sweep that a wall may have made.

    Parameters
    ----------
    wall_xy : ndarray, shape (2, 2)
        Its ends [m].
    sweeps : sequence of Sweep
        With the true poses.
    rig : Rig
        Of the sweeps.

    Returns
    -------
    ndarray of int, shape (s,)
        Readings as far as the perpendicular to the wall is long, within the beam; of other echoes some are, by chance.
    """
    return np.array([_count(wall_xy, Pings.from_sweep(sweep, rig)) for sweep in sweeps])


def _count(wall_xy: FloatArray, pings: Pings) -> int:
    side = wall_xy[1] - wall_xy[0]
    tangent = directions(np.arctan2(side[1], side[0]))
    normal = np.array([-tangent[1], tangent[0]])
    away = pings.origins_xy - wall_xy[0]
    depths, places = away @ normal, away @ tangent
    facing = np.arctan2(*(-np.sign(depths)[:, None] * normal).T[::-1])
    late = pings.ranges - np.abs(depths)
    is_echo = (late > -NEARER) & (late < FARTHER) & (np.abs(wrap(pings.bearings - facing)) < OBLIQUE)
    return int((is_echo & (places > 0.0) & (places < np.hypot(*side))).sum())
