"""Occlusion: no sound passes a wall, so of a wall and a landmark detected through it one does not exist.

Sound that a wall reflects to a cylinder and back seems to come from a cylinder behind the wall. A few stations rarely
detect this image twice at the same place; hundreds do. Likewise, a line through which other landmarks are detected is
no wall.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.search.ray_paths import Paths

__all__ = ["Occlusion", "hiding"]


class Occlusion(NamedTuple):
    """Paths through walls: of wall and landmark, the one of the greater log-likelihood ratio exists."""

    # Paths through a wall of a greater log-likelihood ratio than their landmark, shape (n,).
    hidden: BoolArray
    # Paths through each wall whose landmark has at least its log-likelihood ratio, shape (f, n).
    passed: BoolArray


def hiding(paths: Paths, features: Sequence[Hypothesis], *, gap: float) -> Occlusion:
    """Return which paths pass through which walls.

    A path passes only between two neighbouring detections of the wall that are less than ``gap`` apart [m].
    """
    totals = np.array([each.llr for each in features])
    hidden = np.zeros(len(paths.owners), dtype=bool)
    passed = np.zeros((len(features), len(paths.owners)), dtype=bool)
    for number, wall in enumerate(features):
        if wall.is_wall:
            pings, places = paths.through(wall.line)
            feet = np.concatenate([wall.history.feet, paths.feet(number, wall.line)])
            pings = pings[_is_between(feet, places, gap)]
            is_less = totals[paths.owners[pings]] < wall.llr
            hidden[pings[is_less]] = True
            passed[number, pings[~is_less]] = True
    return Occlusion(hidden, passed)


def _is_between(feet: FloatArray, places: FloatArray, gap: float) -> BoolArray:
    """Return which positions lie between two neighbouring feet that are less than ``gap`` apart."""
    bounds = np.concatenate([[-np.inf], np.sort(feet), [np.inf]])
    after = np.searchsorted(bounds, places)
    between: BoolArray = np.diff(bounds)[after - 1] < gap
    return between
