"""Hiding: nothing is heard through a wall; of a wall and what is heard through it one is not there.

Sound that met a wall on its way to a cylinder and back comes as from a cylinder beyond the wall.  From a few stations
that is rarely heard twice alike; from hundreds it is.  And what others are heard through is no wall.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.search.ray_paths import Paths

__all__ = ["Hiding", "hiding"]

# What stands less than this behind a wall may stand before it [m]: that well walls and poses are known.
_BEHIND = 0.05


class Hiding(NamedTuple):
    """Sound that would have gone through walls: what explains more is there, and the other is not.

    Attributes
    ----------
    hidden : ndarray of bool, shape (n,)
        Which sound would have gone through a wall that explains more than what the sound seems to come from.
    passed : ndarray of bool, shape (f, n)
        Which sound of what explains more went through each wall.
    """

    hidden: BoolArray
    passed: BoolArray


def hiding(paths: Paths, features: Sequence[Hypothesis], *, gap: float) -> Hiding:
    """Tell which sound would have gone through which walls.

    Parameters
    ----------
    paths : Paths
        Ways of sound.
    features : sequence of Hypothesis
        What is there.
    gap : float
        How far apart a wall must have been heard for sound to go through between [m].

    Returns
    -------
    Hiding
        By ping.
    """
    totals = np.array([each.total for each in features])
    hidden = np.zeros(len(paths.owners), dtype=bool)
    passed = np.zeros((len(features), len(paths.owners)), dtype=bool)
    for number, wall in enumerate(features):
        if wall.is_wall:
            pings, places = paths.through(wall.line, behind=_BEHIND)
            feet = np.concatenate([wall.history.feet, paths.feet(number, wall.line)])
            pings = pings[_is_between(feet, places, gap)]
            is_less = totals[paths.owners[pings]] < wall.total
            hidden[pings[is_less]] = True
            passed[number, pings[~is_less]] = True
    return Hiding(hidden, passed)


def _is_between(feet: FloatArray, places: FloatArray, gap: float) -> BoolArray:
    """Tell which places lie between two feet that are next to each other and no farther apart than this."""
    bounds = np.concatenate([[-np.inf], np.sort(feet), [np.inf]])
    after = np.searchsorted(bounds, places)
    between: BoolArray = np.diff(bounds)[after - 1] < gap
    return between
