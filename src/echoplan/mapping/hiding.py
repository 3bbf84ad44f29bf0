"""Hiding: nothing is heard through a wall, so what seems to stand behind one is an image in it.

Sound that met a wall on its way to a cylinder and back comes as from a cylinder beyond the wall.  From a few stations
that is rarely heard twice alike; from hundreds it is.
"""

from collections.abc import Sequence

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.mapping.paths import Paths

__all__ = ["hidden"]

# What stands less than this behind a wall may stand before it [m]: that well walls and poses are known.
_BEHIND = 0.05


def hidden(paths: Paths, features: Sequence[Hypothesis], *, gap: float) -> BoolArray:
    """Tell which sound would have gone through a wall, one that explains more than what it seems to come from.

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
    ndarray of bool, shape (n,)
        By ping.
    """
    behind, totals = np.zeros(len(paths.owners), dtype=bool), np.array([each.total for each in features])
    for number, wall in enumerate(features):
        if wall.is_wall:
            pings, places = paths.through(wall.line, behind=_BEHIND)
            struck = _is_between(np.concatenate([wall.past.feet, paths.feet(number, wall.line)]), places, gap)
            behind[pings[struck & (totals[paths.owners[pings]] < wall.total)]] = True
    return behind


def _is_between(feet: FloatArray, places: FloatArray, gap: float) -> BoolArray:
    """Tell which places lie between two feet that are next to each other and no farther apart than this."""
    bounds = np.concatenate([[-np.inf], np.sort(feet), [np.inf]])
    after = np.searchsorted(bounds, places)
    between: BoolArray = np.diff(bounds)[after - 1] < gap
    return between
