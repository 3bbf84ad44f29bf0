"""Faces: the parts of a line that are wall, told apart by gaps that sound went through."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.geometry import directions, intersections
from echoplan.mapping.joint.search.echoes import Echoes

__all__ = ["Face", "FaceSettings", "find_faces"]


class FaceSettings(BaseModel, frozen=True, extra="forbid"):
    """When a line is more than one wall."""

    gap: float = Field(default=0.12, gt=0.0, description="least gap that sound may have gone through [m]")
    crossing_span: float = Field(
        default=math.radians(25), gt=0.0, description="of the pings that went through such a gap [rad]"
    )
    wide_gap: float = Field(default=0.4, gt=0.0, description="least gap about a corner that was heard [m]")
    corner_away: float = Field(default=1.0, gt=0.0, description="of such a corner from what was heard of a wall [m]")
    stub: float = Field(default=0.06, gt=0.0, description="of a wall heard at its end is none that goes on there [m]")
    corner_reach: float = Field(default=0.03, gt=0.0, description="of a corner that was heard as such from a wall [m]")
    echo_span: float = Field(default=math.radians(5), gt=0.0, description="of the pings that hear a corner [rad]")
    right_angle: float = Field(default=math.radians(5), gt=0.0, description="of walls that echo at their vertex [rad]")
    beside: float = Field(default=0.02, gt=0.0, description="of one wall there is no room for another [m]")
    askew: float = Field(default=0.05, gt=0.0, description="at most of a stub that goes on from a wall [m]")
    turn: float = Field(default=math.radians(12), gt=0.0, description="between two walls of one [rad]")
    against: float = Field(default=1.0, gt=0.0, description="a wall stands what fronts less than this before it [m]")
    least_share: float = Field(default=0.05, ge=0.0, description="of the pings of a line or wall that make another")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Face:
    """One wall of perhaps several on a line.

    Parameters
    ----------
    owner : int
        Number of the feature.
    wall : Hypothesis
        The feature.
    low, high : float
        Ends of what was heard of it along the line [m].
    crossings : ndarray, shape (k,)
        Where sound of other features went through its line [m].
    silences : ndarray, shape (d,)
        Where it should have been heard and was not [m].
    pings : int
        How many pings were reflected by it.
    """

    owner: int
    wall: Hypothesis
    low: float
    high: float
    crossings: FloatArray
    silences: FloatArray
    pings: int

    @property
    def along(self) -> FloatArray:
        """Unit vector along it, shape (2,)."""
        return directions(self.wall.line[0] + math.pi / 2)

    @property
    def middle_xy(self) -> FloatArray:
        """The point halfway [m], shape (2,)."""
        return self.point(0.5 * (self.low + self.high))

    def point(self, place: float) -> FloatArray:
        """Return the point at a place along the line [m].

        Parameters
        ----------
        place : float
            The place.

        Returns
        -------
        ndarray, shape (2,)
            The point [m].
        """
        point: FloatArray = self.wall.line[1] * directions(self.wall.line[0]) + place * self.along
        return point

    def is_open(self, low: float, high: float) -> bool:
        """Tell whether sound went through between two places, or should have come back from there and did not.

        Parameters
        ----------
        low, high : float
            The places along the line [m].

        Returns
        -------
        bool
            Whether at least four pings say so.
        """
        return any(int(((places > low) & (places < high)).sum()) >= 4 for places in (self.crossings, self.silences))

    def extension(self, point_xy: FloatArray) -> float:
        """Tell how far it must be lengthened to reach a point.

        Parameters
        ----------
        point_xy : ndarray, shape (2,)
            The point, on its line [m].

        Returns
        -------
        float
            How far [m]; below 0 if the point lies along it.
        """
        place = float(point_xy @ self.along)
        return max(self.low - place, place - self.high)

    def is_upper(self, point_xy: FloatArray) -> bool:
        """Tell whether a point is nearer to its upper end than to the lower one.

        Parameters
        ----------
        point_xy : ndarray, shape (2,)
            The point, on its line [m].

        Returns
        -------
        bool
            Whether it is.
        """
        return float(point_xy @ self.along) > 0.5 * (self.low + self.high)

    def is_open_toward(self, point_xy: FloatArray) -> bool:
        """Tell whether it is open between its end and a point beyond that.

        Parameters
        ----------
        point_xy : ndarray, shape (2,)
            The point, on its line [m].

        Returns
        -------
        bool
            Whether sound went through there, or should have come back and did not.
        """
        place = float(point_xy @ self.along)
        end = self.high if self.is_upper(point_xy) else self.low
        return self.is_open(min(end, place) + 0.03, max(end, place) - 0.03)


def find_faces(features: Sequence[Hypothesis], echoes: Echoes, *, step: float, settings: FaceSettings) -> list[Face]:
    """Cut the lines of walls where sound went through.

    Sound that reached something behind a line went through it there; and where a corner was heard on a wall, this ends:
    what lies beyond is another wall.  Nobody knows whether a wall goes on behind what may stand against it, so it does
    not.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there, with a past that tells where walls sent sound back, and where it went through.
    echoes : Echoes
        Where corners were heard.
    step : float
        Turn from one ping to the next [rad].
    settings : FaceSettings
        When to cut.

    Returns
    -------
    list of Face
        At least one of each wall.
    """
    wholes = [_whole(number, each) for number, each in enumerate(features) if each.is_wall]
    faces = list[Face]()
    for whole in wholes:
        breaks = _heard_corners(whole, wholes, echoes, step=step, settings=settings) + _fronts(whole, wholes, settings)
        faces += _cut(whole, _feet(whole.wall), breaks, step=step, settings=settings)
    return _without_copies(faces, settings)


def _feet(wall: Hypothesis) -> FloatArray:
    return wall.past.feet if len(wall.past.feet) else np.array(wall.extent)


def _whole(number: int, wall: Hypothesis) -> Face:
    feet, past = _feet(wall), wall.past
    return Face(
        owner=number,
        wall=wall,
        low=float(feet[0]),
        high=float(feet[-1]),
        crossings=past.crossings,
        silences=past.silences,
        pings=past.pings,
    )


def _without_copies(faces: Sequence[Face], settings: FaceSettings) -> list[Face]:
    """Leave out what there is no room for beside a wall of which more was heard, and what hardly goes on from it.

    Stations let go one by one may make two of a wall.  And next to a corner its echo runs into that of the wall, so
    that a few of many stations hear a stub that stands askew there.
    """
    kept: list[Face] = []
    for face in sorted(faces, key=lambda each: each.pings, reverse=True):
        if not any(_lies_along(face, each, settings) for each in kept):
            kept.append(face)
    return [each for each in faces if each in kept]


def _lies_along(face: Face, other: Face, settings: FaceSettings) -> bool:
    """Tell whether a face is so near another that faces the same side that it is a part of this, or an error."""
    if math.cos(face.wall.line[0] - other.wall.line[0]) < math.cos(settings.turn):
        return False
    places = sorted(float(face.point(each) @ other.along) for each in (face.low, face.high))
    low, high = (min(max(each, other.low), other.high) for each in places)
    if 2.0 * (high - low) > face.high - face.low:
        return max(_away(other.point(low), face), _away(other.point(high), face)) < settings.beside
    return face.pings < settings.least_share * other.pings and _is_stub(face, other, settings)


def _is_stub(face: Face, other: Face, settings: FaceSettings) -> bool:
    """Tell whether a face is near the end of another, and crosses the line of this there."""
    if max(_away(face.point(each), other) for each in (face.low, face.high)) > settings.askew:
        return False
    crossing = intersections(face.wall.line, other.wall.line)
    place, end = float(crossing @ face.along), float(crossing @ other.along)
    apart = max(face.low - place, place - face.high, other.low - end, end - other.high)
    return apart < settings.wide_gap


def _away(point_xy: FloatArray, face: Face) -> float:
    return abs(float(point_xy @ directions(face.wall.line[0]) - face.wall.line[1]))


def _cut(whole: Face, feet: FloatArray, breaks: Sequence[float], *, step: float, settings: FaceSettings) -> list[Face]:
    pieces = np.split(feet, np.flatnonzero(np.diff(feet) > settings.gap) + 1)
    through, parts = max(4.0, settings.crossing_span / step), pieces[:1]
    for before, after in pairwise(pieces):
        low, high = float(before[-1]), float(after[0])
        crossed = ((whole.crossings > low + 0.02) & (whole.crossings < high - 0.02)).sum() >= through
        broken = high - low > settings.wide_gap and any(_ends(before, each, after, settings) for each in breaks)
        if crossed or broken:
            parts.append(after)
        else:
            parts[-1] = np.concatenate([parts[-1], after])
    enough = max(settings.least_share * len(feet), 1.0)
    return [
        replace(whole, low=float(part[0]), high=float(part[-1]), pings=round(whole.pings * len(part) / len(feet)))
        for part in parts
        if len(part) >= min(enough, 6.0)
    ]


def _ends(before: FloatArray, place: float, after: FloatArray, settings: FaceSettings) -> bool:
    """Tell whether a wall ends at a place in a gap, or near it; not where one side is nothing but that place itself."""
    is_there = before[-1] - settings.corner_reach < place < after[0] + settings.corner_reach
    return bool(is_there and min(place - before[0], after[-1] - place) > settings.stub)


def _fronts(whole: Face, wholes: Sequence[Face], settings: FaceSettings) -> list[float]:
    """Places along a wall of what may stand against it: of the middles of parallel walls a little before it."""
    angle, offset = whole.wall.line
    parallel = [each for each in wholes if math.cos(each.wall.line[0] - angle) > math.cos(settings.turn)]
    return [
        float(each.middle_xy @ whole.along)
        for each in parallel
        if settings.askew < offset - float(each.middle_xy @ directions(angle)) < settings.against
    ]


def _heard_corners(
    whole: Face, wholes: Sequence[Face], echoes: Echoes, *, step: float, settings: FaceSettings
) -> list[float]:
    """Places along a wall where a corner was heard: as such, or as two walls that were heard in each other.

    What makes a corner with the wall may be known or not.  Sound over two walls comes as from where their lines cross,
    even if they do not meet there.
    """
    on_line = np.abs(echoes.corners_xy @ directions(whole.wall.line[0]) - whole.wall.line[1]) < settings.corner_reach
    places: list[float] = (echoes.corners_xy[on_line] @ whole.along).tolist()
    least = max(1.0, settings.echo_span / step)
    for other in wholes:
        if abs(math.cos(whole.wall.line[0] - other.wall.line[0])) > math.sin(settings.right_angle):
            continue
        point, between = intersections(whole.wall.line, other.wall.line), echoes.between(whole.owner, other.owner)
        if between.pings < least or not between.is_believed:
            continue
        if -0.1 < other.extension(point) < settings.corner_away and not other.is_open_toward(point):
            places.append(float(point @ whole.along))
    return places
