"""Openings: gaps between two segments of a line through which the robot drove or sound travelled."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.model import Opening, UnobservedStretch

__all__ = ["Gap", "openings_of", "unobserved_of"]

# The two faces of a wall are parallel within this and at most so far apart [rad, m].
_PARALLEL, _THICKEST = math.radians(10.0), 0.4


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Gap:
    """What lies between two walls of one line, or of the lines of the two faces of a wall.

    Parameters
    ----------
    walls : tuple of int
        Indices of the walls beside it.
    line : ndarray, shape (2,)
        Normal angle and offset [rad, m].
    ends : ndarray, shape (2,)
        Where it begins and ends along the line [m].
    variances : ndarray, shape (2,)
        Of both ends [m^2].
    is_open : bool
        Whether there is surely no wall somewhere in it, and none that meets it at a right angle ends it.
    passed : bool
        Whether the robot drove through.
    """

    walls: tuple[int, ...]
    line: FloatArray
    ends: FloatArray
    variances: FloatArray
    is_open: bool
    passed: bool

    @property
    def endpoints_xy(self) -> FloatArray:
        """Both ends [m], shape (2, 2)."""
        normal, along = directions(self.line[0]), directions(self.line[0] + math.pi / 2)
        ends: FloatArray = self.line[1] * normal + self.ends[:, None] * along
        return ends

    def is_other_face_of(self, other: "Gap") -> bool:
        """Return True if this and another gap are in the two faces of one wall."""
        if math.cos(self.line[0] - other.line[0]) > -math.cos(_PARALLEL):
            return False
        between = self.line[1] + other.line[1]
        low, high = np.maximum(self.ends[0], -other.ends[1]), np.minimum(self.ends[1], -other.ends[0])
        shorter = min(self.ends[1] - self.ends[0], other.ends[1] - other.ends[0])
        return bool(-_THICKEST < between < 0.0 and high - low > 0.5 * shorter)

    def merged(self, other: "Gap") -> "Gap":
        """Merge it with that of the other face: midway between both, each end the weighted mean of two."""
        ends, variances = -other.ends[::-1], other.variances[::-1]
        weights = 1.0 / np.stack([self.variances, variances])
        return replace(
            self,
            walls=(*self.walls, *other.walls),
            line=np.array([self.line[0], 0.5 * (self.line[1] - other.line[1])]),
            ends=(weights * np.stack([self.ends, ends])).sum(axis=0) / weights.sum(axis=0),
            variances=1.0 / weights.sum(axis=0),
            passed=self.passed or other.passed,
        )


def openings_of(gaps: Sequence[Gap]) -> tuple[Opening, ...]:
    """Make openings of the gaps that are open: one of those in the two faces of a wall."""
    merged: list[Gap] = []
    for gap in gaps:
        if not gap.is_open:
            continue
        faces = [each for each in merged if gap.is_other_face_of(each)]
        merged = [each for each in merged if each not in faces]
        merged.append(faces[0].merged(gap) if faces else gap)
    return tuple(
        Opening(
            endpoints_xy=each.endpoints_xy,
            width_sigma=float(np.sqrt(each.variances.sum())),
            walls=each.walls,
            passed=each.passed,
        )
        for each in merged
    )


def unobserved_of(gaps: Sequence[Gap]) -> tuple[UnobservedStretch, ...]:
    """Make unobserved stretches of the gaps that are not open."""
    return tuple(
        UnobservedStretch(endpoints_xy=each.endpoints_xy, walls=each.walls) for each in gaps if not each.is_open
    )
