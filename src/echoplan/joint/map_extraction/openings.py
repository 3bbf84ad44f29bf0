"""Openings: gaps between two segments of a line through which the robot drove or sound passed."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.map_extraction.segment import PARALLEL, End
from echoplan.model import Opening, UnobservedStretch

__all__ = ["Gap", "merged_faces", "openings_of", "unobserved_of"]

# Greatest thickness of a wall: distance of its two faces [m].
_THICKEST = 0.4


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Gap:
    """Stretch between two segments of one line, or of the two faces of a wall."""

    # Indices of the adjacent walls.
    walls: tuple[int, ...]
    # Normal angle and offset [rad, m], shape (2,).
    line: FloatArray
    # Distributions of its lower and upper end along the line.
    jambs: tuple[End, End]
    # Whether one of its cells is certainly no wall.
    is_free: bool
    # Whether it is an opening: free, with two known ends that are no concave corners.
    is_open: bool
    # Whether the robot drove through.
    passed: bool

    @property
    def ends(self) -> FloatArray:
        """Lower and upper end along the line [m], shape (2,)."""
        return np.array([each.place for each in self.jambs])

    @property
    def endpoints_xy(self) -> FloatArray:
        """Both ends [m], shape (2, 2)."""
        normal, along = directions(self.line[0]), directions(self.line[0] + math.pi / 2)
        ends: FloatArray = self.line[1] * normal + self.ends[:, None] * along
        return ends

    def seen_along(self, line: FloatArray) -> "Gap":
        """Return the gap on a line through its middle, parallel to another line (normal angle, offset) [rad, m]."""
        along, normal = directions(line[0] + math.pi / 2), directions(line[0])
        ends = zip(self.endpoints_xy @ along, self.jambs, strict=True)
        turned = math.cos(self.line[0] - line[0]) < 0.0
        jambs = [(each.reversed() if turned else each).centred(float(place)) for place, each in ends]
        first, last = jambs[::-1] if turned else jambs
        offset = float(self.endpoints_xy.mean(axis=0) @ normal)
        return replace(self, line=np.array([line[0], offset]), jambs=(first, last))

    def is_other_face_of(self, other: "Gap") -> bool:
        """Return True if this gap and another one are in the two faces of one wall."""
        if math.cos(self.line[0] - other.line[0]) > -PARALLEL:
            return False
        face = other.seen_along(self.line)
        low, high = max(self.ends[0], face.ends[0]), min(self.ends[1], face.ends[1])
        shorter = min(float(np.diff(each.ends)[0]) for each in (self, face))
        return bool(0.0 < face.line[1] - self.line[1] < _THICKEST and high - low > 0.5 * shorter)

    def merged(self, other: "Gap") -> "Gap":
        """Merge this open gap with that of the other face, midway between both.

        The distributions of each jamb are multiplied. If the other gap is not known to be open, only its offset is
        used.
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
    """Merge open gaps with those in the other face of the same wall."""
    merged: list[Gap] = []
    for gap in sorted(gaps, key=lambda each: not each.is_open):
        face = next((each for each in merged if each.is_open and gap.is_other_face_of(each)), None)
        if face is None:
            merged.append(gap)
        else:
            merged[merged.index(face)] = face.merged(gap)
    return merged


def openings_of(gaps: Sequence[Gap]) -> tuple[Opening, ...]:
    """Return the open gaps as openings."""
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
    """Return the gaps that may be wall as unobserved stretches."""
    return tuple(
        UnobservedStretch(endpoints_xy=each.endpoints_xy, walls=each.walls) for each in gaps if not each.is_free
    )
