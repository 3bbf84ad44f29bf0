"""Openings: gaps between two segments of a line through which the robot drove or sound travelled."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.map_extraction.segment import PARALLEL, End
from echoplan.model import Opening, UnobservedStretch

__all__ = ["Gap", "merged_faces", "openings_of", "unobserved_of"]

# The two faces of a wall are at most so far apart [m].
_THICKEST = 0.4


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Gap:
    """What lies between two walls of one line, or of the lines of the two faces of a wall.

    Parameters
    ----------
    walls : tuple of int
        Indices of the walls beside it.
    line : ndarray, shape (2,)
        Normal angle and offset [rad, m].
    jambs : tuple of End
        Where it begins and ends along the line.
    is_free : bool
        Whether there is surely no wall somewhere in it.
    is_open : bool
        Whether it is free and known at both ends, and neither of these is a concave corner.
    passed : bool
        Whether the robot drove through.
    """

    walls: tuple[int, ...]
    line: FloatArray
    jambs: tuple[End, End]
    is_free: bool
    is_open: bool
    passed: bool

    @property
    def ends(self) -> FloatArray:
        """Where it begins and ends along the line [m], shape (2,)."""
        return np.array([each.place for each in self.jambs])

    @property
    def endpoints_xy(self) -> FloatArray:
        """Both ends [m], shape (2, 2)."""
        normal, along = directions(self.line[0]), directions(self.line[0] + math.pi / 2)
        ends: FloatArray = self.line[1] * normal + self.ends[:, None] * along
        return ends

    def seen_along(self, line: FloatArray) -> "Gap":
        """Return the same gap as one in a line through its middle that runs as another line does [rad, m]."""
        along, normal = directions(line[0] + math.pi / 2), directions(line[0])
        ends = zip(self.endpoints_xy @ along, self.jambs, strict=True)
        turned = math.cos(self.line[0] - line[0]) < 0.0
        jambs = [(each.reversed() if turned else each).centred(float(place)) for place, each in ends]
        first, last = jambs[::-1] if turned else jambs
        offset = float(self.endpoints_xy.mean(axis=0) @ normal)
        return replace(self, line=np.array([line[0], offset]), jambs=(first, last))

    def is_other_face_of(self, other: "Gap") -> bool:
        """Return True if this and another gap are in the two faces of one wall."""
        if math.cos(self.line[0] - other.line[0]) > -PARALLEL:
            return False
        face = other.seen_along(self.line)
        low, high = max(self.ends[0], face.ends[0]), min(self.ends[1], face.ends[1])
        shorter = min(float(np.diff(each.ends)[0]) for each in (self, face))
        return bool(0.0 < face.line[1] - self.line[1] < _THICKEST and high - low > 0.5 * shorter)

    def merged(self, other: "Gap") -> "Gap":
        """Merge it, an open one, with that of the other face: midway between both, each end where both say that it is.

        Of a gap in the other face that is not known to be open, only the place of that face is used.
        """
        face, (first, last) = other.seen_along(self.line), self.jambs
        if other.is_open:
            first, last = first.joined(face.jambs[0]), last.joined(face.jambs[1])
        return replace(
            self,
            walls=(*self.walls, *other.walls),
            line=np.array([self.line[0], 0.5 * (self.line[1] + face.line[1])]),
            jambs=(first, last),
            passed=self.passed or other.passed,
        )


def merged_faces(gaps: Sequence[Gap]) -> list[Gap]:
    """Merge open gaps with those in the other faces of their walls."""
    merged: list[Gap] = []
    for gap in sorted(gaps, key=lambda each: not each.is_open):
        face = next((each for each in merged if each.is_open and gap.is_other_face_of(each)), None)
        if face is None:
            merged.append(gap)
        else:
            merged[merged.index(face)] = face.merged(gap)
    return merged


def openings_of(gaps: Sequence[Gap]) -> tuple[Opening, ...]:
    """Make openings of the gaps that are open."""
    return tuple(
        Opening(
            endpoints_xy=each.endpoints_xy,
            width_sigma=math.hypot(*(jamb.sigma for jamb in each.jambs)),
            walls=each.walls,
            passed=each.passed,
        )
        for each in gaps
        if each.is_open
    )


def unobserved_of(gaps: Sequence[Gap]) -> tuple[UnobservedStretch, ...]:
    """Make unobserved stretches of the gaps that may be wall."""
    return tuple(
        UnobservedStretch(endpoints_xy=each.endpoints_xy, walls=each.walls) for each in gaps if not each.is_free
    )
