"""Copies: one wall that poses in error made two of."""

import math
from collections.abc import Sequence
from itertools import combinations

from pydantic import BaseModel, Field

from echoplan.geometry import crosses_segments, signed_distances
from echoplan.joint.likelihood.hypothesis import Hypothesis

__all__ = ["DuplicateSettings", "are_duplicates", "cross", "duplicate_pairs", "without_duplicates"]


class DuplicateSettings(BaseModel, frozen=True, extra="forbid"):
    """How far apart two copies of a wall may lie."""

    turn: float = Field(default=math.radians(12), gt=0.0, description="between them [rad]")
    beside: float = Field(default=0.08, gt=0.0, description="between their lines, at the middle of either [m]")
    apart: float = Field(default=0.3, ge=0.0, description="between their ends [m]")


def without_duplicates(features: Sequence[Hypothesis], settings: DuplicateSettings) -> list[Hypothesis]:
    """Keep one of several copies of each wall: the one that explains most.

    Walls that stations told apart which were let go are two: their poses had come to rest.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there.
    settings : DuplicateSettings
        What copies are.

    Returns
    -------
    list of Hypothesis
        The others are left for it to explain.
    """
    kept: list[Hypothesis] = []
    for feature in sorted(features, key=lambda each: each.total, reverse=True):
        if not any(_may_be_one(feature, each, settings) for each in kept):
            kept.append(feature)
    return kept


def duplicate_pairs(features: Sequence[Hypothesis], settings: DuplicateSettings) -> list[tuple[int, int]]:
    """Find all that may be there twice.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there.
    settings : DuplicateSettings
        What copies are.

    Returns
    -------
    list of tuple of int
        Numbers of any two that may be the same wall.
    """
    numbers = combinations(range(len(features)), 2)
    return [(one, other) for one, other in numbers if _may_be_one(features[one], features[other], settings)]


def are_duplicates(one: Hypothesis, other: Hypothesis, settings: DuplicateSettings) -> bool:
    """Tell whether two features may be the same wall.

    Parameters
    ----------
    one, other : Hypothesis
        Two features.
    settings : DuplicateSettings
        How far apart they may lie.

    Returns
    -------
    bool
        False if either is no wall.
    """
    if not (one.is_wall and other.is_wall):
        return False
    if abs(math.remainder(one.line[0] - other.line[0], math.tau)) > settings.turn:
        return False
    beside = min(_beside(one, other), _beside(other, one))
    apart = max(one.extent[0] - other.extent[1], other.extent[0] - one.extent[1])
    return beside < settings.beside and apart < settings.apart


def cross(one: Hypothesis, other: Hypothesis) -> bool:
    """Tell whether what was heard of a wall crosses what was heard of another, as no two walls do.

    Parameters
    ----------
    one, other : Hypothesis
        Two walls.

    Returns
    -------
    bool
        Whether there is a point inside both.
    """
    start, end = one.ends_xy
    return bool(crosses_segments([start], [end], other.ends_xy).any())


def _may_be_one(one: Hypothesis, other: Hypothesis, settings: DuplicateSettings) -> bool:
    return are_duplicates(one, other, settings) and not _are_confirmed(one, other)


def _are_confirmed(one: Hypothesis, other: Hypothesis) -> bool:
    return one.history.supporting > 0 and other.history.supporting > 0


def _beside(one: Hypothesis, other: Hypothesis) -> float:
    """How far the middle of what was heard of one wall lies beside the line of another."""
    return float(abs(signed_distances(one.line, other.ends_xy.mean(axis=0))))
