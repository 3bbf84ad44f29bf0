"""Survey: adjusted hypotheses as the walls, corners and cylinders of a map, with covariances."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import FloatArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.geometry import wrap
from echoplan.mapping.joint.adjustment.adjusted import Adjusted
from echoplan.mapping.joint.adjustment.crossings import crossing_slopes
from echoplan.mapping.joint.adjustment.squareness import Squareness
from echoplan.mapping.joint.outline.openings import Gap
from echoplan.mapping.joint.outline.segments import CELL, Segment, path_crossings
from echoplan.mapping.joint.outline.vertices import Vertex
from echoplan.model import ClassProbabilities, Corner, CornerKind, Cylinder, Wall

__all__ = ["Survey", "SurveySettings"]

# A gap shorter than this is none [m].
_TOUCHING = 0.05
# No end is known better than the cell that holds it [m].
_LEAST_SIGMA = CELL / math.sqrt(12.0)
# Probability of wall below which a cell is surely none.
_SURELY_NOT = 0.05


class SurveySettings(BaseModel, frozen=True, extra="forbid"):
    """What is drawn."""

    clear_station: float = Field(default=5.0, description="least gain of a station that counts [nats]")
    lone_stations: int = Field(default=3, ge=1, description="that must have heard a corner without walls")
    lone_distance: float = Field(default=0.06, gt=0.0, description="of such a corner from any other [m]")
    ends_per_metre: float = Field(default=1 / 3, gt=0.0, description="Prior rate of ends along a wall line [1/m].")
    least_length: float = Field(default=0.06, gt=0.0, description="of a wall of which only one point was heard [m]")


class _Ends(NamedTuple):
    """Ends of a wall along its line: where, how well known, and how much of the wall is inferred there; (2,) each [m]."""

    places: FloatArray
    sigmas: FloatArray
    inferred: FloatArray


def _diluted(probabilities: ClassProbabilities, share: float) -> ClassProbabilities:
    """Mix class probabilities with those of what was not observed: a third each."""
    mixed = (1.0 - share) * np.array([probabilities.wall, probabilities.corner, probabilities.cylinder]) + share / 3.0
    wall, corner, cylinder = mixed.tolist()
    return ClassProbabilities(wall=wall, corner=corner, cylinder=cylinder)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Survey:
    """What was found, and how well it is known.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there, as adjusted; their pasts tell who heard them.
    adjusted : Adjusted
        Covariances.
    segments : sequence of Segment
        Walls.
    vertices : sequence of Vertex
        Where they meet.
    squareness : Squareness or None
        Which features were drawn to right angles.
    settings : SurveySettings
        What is drawn.
    """

    features: Sequence[Hypothesis]
    adjusted: Adjusted
    segments: Sequence[Segment]
    vertices: Sequence[Vertex]
    squareness: Squareness | None
    settings: SurveySettings

    def right_angles(self) -> dict[str, float | bool]:
        """Tell how many walls were drawn to right angles, how closely, and whether along the axes.

        Returns
        -------
        dict of str to float or bool
            Their number (``walls``), the standard deviation of their directions (``sigma``) [rad], and whether they
            were taken to stand along the axes of the map (``along_axes``); empty if none.
        """
        if self.squareness is None:
            return {}
        walls = int(sum(self.squareness.members[segment.owner] for segment in self.segments))
        return {"walls": walls, "sigma": self.squareness.sigma, "along_axes": self.squareness.along_axes}

    def walls(self) -> tuple[Wall, ...]:
        """Draw the segments, each up to the vertices at its ends.

        Returns
        -------
        tuple of Wall
            One a segment.
        """
        return tuple(self._wall(number, segment) for number, segment in enumerate(self.segments))

    def cylinders(self) -> tuple[Cylinder, ...]:
        """Draw the cylinders.

        Returns
        -------
        tuple of Cylinder
            All of them.
        """
        return tuple(
            Cylinder(
                center_xy=each.reflector[1:3],
                radius=float(each.reflector[3]),
                covariance=self._covariance([number]),
                class_probabilities=self._class_of(number),
                pings=self._pings(number),
                stations=self._stations(each),
            )
            for number, each in enumerate(self.features)
            if each.kind is Kind.CYLINDER
        )

    def corners(self) -> tuple[Corner, ...]:
        """Draw the vertices, and the corners that were heard where no walls meet.

        Returns
        -------
        tuple of Corner
            All of them.
        """
        met = [self._corner(each) for each in self.vertices]
        lone = [
            self._lone_corner(number, each)
            for number, each in enumerate(self.features)
            if each.kind in (Kind.CORNER, Kind.EDGE) and self._is_lone(each)
        ]
        return (*met, *lone)

    def _wall(self, number: int, segment: Segment) -> Wall:
        ends = self._ends(number)
        low, high = ends.places
        normal_angle, offset = segment.wall.line.tolist()
        return Wall(
            normal_angle=float(wrap(normal_angle)),
            offset=offset,
            endpoints_xy=np.stack([segment.point(low), segment.point(high)]),
            covariance=self._covariance([segment.owner]),
            class_probabilities=_diluted(self._class_of(segment.owner), float(ends.inferred.sum()) / (high - low)),
            pings=segment.pings,
            stations=self._stations(segment.wall),
            endpoint_sigmas=ends.sigmas,
            inferred=ends.inferred,
        )

    def _ends(self, number: int) -> "_Ends":
        """Return where a segment ends: at a vertex, or where stations say so, or where it was detected last."""
        segment = self.segments[number]
        places, sigmas, inferred = np.array([segment.low, segment.high]), np.array(segment.sigmas), np.zeros(2)
        for vertex in self.vertices:
            for each, upper in zip(vertex.segments, vertex.upper, strict=True):
                if each == number:
                    place = float(vertex.position_xy @ segment.along)
                    if not vertex.heard:
                        inferred[int(upper)] = max((place - segment.high) if upper else (segment.low - place), 0.0)
                    places[int(upper)] = place
                    variance = segment.along @ self._covariance_of_vertex(vertex) @ segment.along
                    sigmas[int(upper)] = math.sqrt(max(float(variance), 0.0))
        missing = max(self.settings.least_length - float(places[1] - places[0]), 0.0) / 2
        return _Ends(places + missing * np.array([-1.0, 1.0]), sigmas, inferred)

    def gaps(self, path_xy: FloatArray) -> list[Gap]:
        """Find what lies between two segments that follow each other on a line.

        Parameters
        ----------
        path_xy : ndarray, shape (p, 2)
            The way of the robot [m].

        Returns
        -------
        list of Gap
            Openings, and stretches that nobody observed.
        """
        pairs = [
            (number, number + 1)
            for number, (one, other) in enumerate(pairwise(self.segments))
            if one.owner == other.owner
        ]
        gaps = [self._gap(one, other, path_xy) for one, other in pairs]
        return [each for each in gaps if each.ends[1] - each.ends[0] > _TOUCHING]

    def _gap(self, one: int, other: int, path_xy: FloatArray) -> Gap:
        before, after, segment = self._ends(one), self._ends(other), self.segments[one]
        ends, line = np.array([before.places[1], after.places[0]]), segment.wall.line
        sigmas = np.array([before.sigmas[1], after.sigmas[0]])
        crossings = path_crossings(line, path_xy)
        return Gap(
            walls=(one, other),
            line=line,
            ends=ends,
            variances=np.maximum(sigmas, _LEAST_SIGMA) ** 2,
            is_open=bool(
                segment.chances_between(*ends).min(initial=1.0) < _SURELY_NOT
                and not np.isnan(sigmas).any()
                and not self._is_concave(one, upper=True)
                and not self._is_concave(other, upper=False)
            ),
            passed=bool(((crossings > ends[0]) & (crossings < ends[1])).any()),
        )

    def _is_concave(self, number: int, *, upper: bool) -> bool:
        """Return True if an end of a segment is a concave corner: what follows is another wall, and no opening."""
        return any(
            vertex.kind is CornerKind.CONCAVE and (number, upper) in zip(vertex.segments, vertex.upper, strict=True)
            for vertex in self.vertices
        )

    def _corner(self, vertex: Vertex) -> Corner:
        heard, echo = self._heard_corner(vertex.position_xy), vertex.echo
        return Corner(
            position_xy=vertex.position_xy,
            kind=vertex.kind,
            covariance=self._covariance_of_vertex(vertex),
            class_probabilities=self._class_of_vertex(vertex) if heard is None else self._class_of(heard),
            pings=echo.pings if heard is None else self._pings(heard),
            stations=echo.stations if heard is None else self._stations(self.features[heard]),
        )

    def _covariance_of_vertex(self, vertex: Vertex) -> FloatArray:
        owners = [self.segments[each].owner for each in vertex.segments]
        slopes = crossing_slopes(np.array([self.features[each].line for each in owners]), vertex.position_xy)
        covariance: FloatArray = slopes @ self._covariance(owners) @ slopes.T
        return covariance

    def _class_of_vertex(self, vertex: Vertex) -> ClassProbabilities:
        """Of a corner where two lines cross: sure if it was detected, less so the farther walls are drawn to it."""
        certain = ClassProbabilities(corner=1.0)
        if vertex.heard:
            return certain
        far = sum(max(self.segments[each].extension(vertex.position_xy), 0.0) for each in vertex.segments)
        return _diluted(certain, -math.expm1(-self.settings.ends_per_metre * far))

    def _lone_corner(self, number: int, feature: Hypothesis) -> Corner:
        return Corner(
            position_xy=feature.reflector[1:3],
            kind=CornerKind.CONCAVE if feature.kind is Kind.CORNER else CornerKind.CONVEX,
            covariance=self._covariance([number]),
            class_probabilities=self._class_of(number),
            pings=self._pings(number),
            stations=self._stations(feature),
        )

    def _is_lone(self, feature: Hypothesis) -> bool:
        distances = [math.dist(each.position_xy, feature.reflector[1:3]) for each in self.vertices]
        far = min(distances, default=math.inf) > self.settings.lone_distance
        return far and self._stations(feature) >= self.settings.lone_stations

    def _heard_corner(self, point_xy: FloatArray) -> int | None:
        near = {
            math.dist(each.reflector[1:3], point_xy): number
            for number, each in enumerate(self.features)
            if each.kind in (Kind.CORNER, Kind.EDGE)
        }
        return near[min(near)] if near and min(near) < self.settings.lone_distance else None

    def _covariance(self, owners: Sequence[int]) -> FloatArray:
        unknowns = self.adjusted.unknowns
        places = np.concatenate([np.arange(unknowns.size)[unknowns.feature(each)] for each in owners])
        block = self.adjusted.covariance[np.ix_(places, places)]
        symmetric: FloatArray = 0.5 * (block + block.T)
        return symmetric

    def _class_of(self, number: int) -> ClassProbabilities:
        return self.features[number].past.probabilities

    def _pings(self, number: int) -> int:
        return self.features[number].past.pings

    def _stations(self, feature: Hypothesis) -> int:
        return feature.past.speaking
