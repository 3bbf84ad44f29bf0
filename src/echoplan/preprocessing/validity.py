"""Which readings are ranges at all (REP 117)."""

import numpy as np

from echoplan.arrays import BoolArray
from echoplan.model import Pings, Rig

__all__ = ["is_valid", "valid_pings"]


def is_valid(pings: Pings, rig: Rig) -> BoolArray:
    """Tell which readings lie between the dead distance and the reach of their sensor.

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
