"""Duplicates: one wall that is in the map twice because of pose errors."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from echoplan.geometry import signed_distances
from echoplan.joint.likelihood.hypothesis import Hypothesis

__all__ = ["DuplicateSettings", "are_duplicates", "without_duplicates"]


class DuplicateSettings(NamedTuple):
    """Greatest differences of two duplicates of a wall."""

    # Angle between them [rad].
    angle_gate: float = math.radians(12)
    # Distance between their lines, at the middle of either [m].
    normal_distance_gate: float = 0.08
    # Gap between their ends [m].
    gap_gate: float = 0.3


def without_duplicates(features: Sequence[Hypothesis], settings: DuplicateSettings) -> list[Hypothesis]:
    """Keep, of several duplicates of a wall, the one with the greatest log-likelihood ratio.

    Two walls are distinct if marginalised stations clearly support both, since the poses of these stations are final.
    """
    kept: list[Hypothesis] = []
    for feature in sorted(features, key=lambda each: each.llr, reverse=True):
        others = (each for each in kept if not (feature.history.supporting and each.history.supporting))
        if not any(are_duplicates(feature, each, settings) for each in others):
            kept.append(feature)
    return kept


def are_duplicates(one: Hypothesis, other: Hypothesis, settings: DuplicateSettings) -> bool:
    """Return True if two walls may be the same one; False if either landmark is no wall."""
    if not (one.is_wall and other.is_wall):
        return False
    if abs(math.remainder(one.line[0] - other.line[0], math.tau)) > settings.angle_gate:
        return False
    beside = min(_beside(one, other), _beside(other, one))
    apart = max(one.extent[0] - other.extent[1], other.extent[0] - one.extent[1])
    return beside < settings.normal_distance_gate and apart < settings.gap_gate


def _beside(one: Hypothesis, other: Hypothesis) -> float:
    """Return the distance of the midpoint of ``other`` from the line of ``one`` [m]."""
    return float(abs(signed_distances(one.line, other.ends_xy.mean(axis=0))))
