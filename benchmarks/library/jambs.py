"""How far jambs of doors are off, and how far the middle between two feet of perpendiculars would be: for flats.py.

A station observes a wall only near the foot of its perpendicular.  The simplest estimate of a jamb lies halfway between
the last foot on the wall and the first in the gap.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.evaluation.doorways import Doorway, true_doorways
from echoplan.evaluation.floor_plan import match_openings
from echoplan.evaluation.matching import MatchingSettings
from echoplan.geometry import is_blocked
from echoplan.model import FeatureMap, Truth

__all__ = ["JambErrors", "jamb_errors"]


@dataclass(frozen=True, slots=True, kw_only=True)
class JambErrors:
    """Distances from true jambs along their walls [m], of the map and of the middle between two feet."""

    mapped: tuple[float, ...]
    halfway: tuple[float, ...]


def jamb_errors(feature_map: FeatureMap, truth: Truth, *, reach: float) -> JambErrors:
    """Compare the jambs of all openings that are right with those halfway between feet, where there are two feet."""
    doorways, pairs = true_doorways(truth), []
    for match in match_openings(feature_map.openings, truth, MatchingSettings()).right:
        ends_xy = feature_map.openings[match.estimate].endpoints_xy
        pairs += list(_pairs(doorways[match.truth], ends_xy, truth, reach))
    return JambErrors(mapped=tuple(each[0] for each in pairs), halfway=tuple(each[1] for each in pairs))


def _pairs(doorway: Doorway, ends_xy: FloatArray, truth: Truth, reach: float) -> Iterator[tuple[float, float]]:
    """Yield for each jamb how far the nearest end of an opening is off, and how far the best middle is."""
    for face in doorway.faces_xy:
        for jamb, other in (face, face[::-1]):
            inwards = (other - jamb) / np.hypot(*(other - jamb))
            feet = _feet(jamb, inwards, truth, reach)
            if (feet < 0.0).any() and (feet > 0.0).any():
                yield (
                    float(np.abs((ends_xy - jamb) @ inwards).min()),
                    0.5 * abs(float(feet[feet < 0.0].max() + feet[feet > 0.0].min())),
                )


def _feet(jamb_xy: FloatArray, inwards: FloatArray, truth: Truth, reach: float) -> FloatArray:
    """Feet of the perpendiculars of the stations that face the line of a jamb and see it: below 0 on the wall [m]."""
    stations = truth.poses[:, :2]
    places = (stations - jamb_xy) @ inwards
    feet_xy = jamb_xy + places[:, None] * inwards
    way = feet_xy - stations
    distances = np.hypot(*way.T)
    before_xy = stations + way * (1.0 - 0.01 / np.maximum(distances, 0.02))[:, None]
    seen = ~is_blocked(stations, before_xy, segments_xy=truth.walls_xy, discs=[])
    feet: FloatArray = places[seen & (distances < reach) & (distances > 0.02)]
    return feet
