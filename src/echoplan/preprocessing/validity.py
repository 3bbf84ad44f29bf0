"""Which readings are ranges, and which are at least valid outcomes of a ping (REP 117)."""

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.model import Pings, Rig

__all__ = ["is_valid", "valid_pings", "valid_ranges"]

# A little more than a step of the readings, so that rounding does not matter.
_STEP = 1.01


def is_valid(pings: Pings, rig: Rig) -> BoolArray:
    """Return which readings lie between the dead distance and the reach of their sensor.

    Parameters
    ----------
    pings : Pings
        Readings of n pings.
    rig : Rig
        The sensors.

    Returns
    -------
    ndarray of bool, shape (n,)
        False for no echo (``inf``), too close (``-inf``), faulty (``nan``) and out of bounds.
    """
    with np.errstate(invalid="ignore"):
        valid: BoolArray = (pings.ranges >= rig.min_ranges[pings.sensors]) & (
            pings.ranges <= rig.max_ranges[pings.sensors]
        )
    return valid


def valid_ranges(pings: Pings, rig: Rig) -> FloatArray:
    """Return the range up to which each ping found free space.

    Faulty readings and those within the dead distance say nothing.  A reading within a step of the reach means that
    no echo was detected: many modules report that as their greatest range.

    Parameters
    ----------
    pings : Pings
        Readings of n pings.
    rig : Rig
        The sensors.

    Returns
    -------
    ndarray, shape (n,)
        Ranges [m]: ``inf`` without an echo, ``nan`` for a ping without information.
    """
    steps = np.array([sensor.resolution for sensor in rig.sensors])[pings.sensors]
    with np.errstate(invalid="ignore"):
        no_echo = pings.ranges >= rig.max_ranges[pings.sensors] - _STEP * steps
        beyond_dead_distance = pings.ranges >= rig.min_ranges[pings.sensors]
    return np.where(no_echo, np.inf, np.where(beyond_dead_distance, pings.ranges, np.nan))


def valid_pings(pings: Pings, rig: Rig) -> Pings:
    """Keep the pings whose reading is a range.

    Parameters
    ----------
    pings : Pings
        Readings of n pings.
    rig : Rig
        The sensors.

    Returns
    -------
    Pings
        The valid ones, in the same order.
    """
    return pings[is_valid(pings, rig)]
