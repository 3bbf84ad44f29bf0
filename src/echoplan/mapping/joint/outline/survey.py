"""Survey: adjusted hypotheses as the walls, corners and cylinders of a map, with covariances."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydantic import BaseModel, Field

from echoplan.acoustics.expectation import Kind
from echoplan.arrays import FloatArray
from echoplan.classification.hypotheses import Hypothesis
from echoplan.geometry import wrap
from echoplan.mapping.joint.adjustment.adjusted import Adjusted
from echoplan.mapping.joint.adjustment.crossings import crossing_slopes
from echoplan.mapping.joint.adjustment.squareness import Squareness
from echoplan.mapping.joint.outline.faces import Face
from echoplan.mapping.joint.outline.vertices import Vertex
from echoplan.model import ClassProbabilities, Corner, CornerKind, Cylinder, Wall

__all__ = ["Survey", "SurveySettings"]


class SurveySettings(BaseModel, frozen=True, extra="forbid"):
    """What is drawn."""

    clear_station: float = Field(default=5.0, description="least gain of a station that counts [nats]")
    lone_stations: int = Field(default=3, ge=1, description="that must have heard a corner without walls")
    lone_distance: float = Field(default=0.06, gt=0.0, description="of such a corner from any other [m]")
    least_length: float = Field(default=0.06, gt=0.0, description="of a wall of which only one point was heard [m]")


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Survey:
    """What was found, and how well it is known.

    Parameters
    ----------
    features : sequence of Hypothesis
        What is there, as adjusted; their pasts tell who heard them.
    adjusted : Adjusted
        Covariances.
    faces : sequence of Face
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
    faces: Sequence[Face]
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
        walls = int(sum(self.squareness.members[face.owner] for face in self.faces))
        return {"walls": walls, "sigma": self.squareness.sigma, "along_axes": self.squareness.along_axes}

    def walls(self) -> tuple[Wall, ...]:
        """Draw the faces, each up to the vertices at its ends.

        Returns
        -------
        tuple of Wall
            One a face.
        """
        return tuple(self._wall(number, face) for number, face in enumerate(self.faces))

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

    def _wall(self, number: int, face: Face) -> Wall:
        low, high = self._ends(number, face)
        normal_angle, offset = face.wall.line.tolist()
        return Wall(
            normal_angle=float(wrap(normal_angle)),
            offset=offset,
            endpoints_xy=np.stack([face.point(low), face.point(high)]),
            covariance=self._covariance([face.owner]),
            class_probabilities=self._class_of(face.owner),
            pings=face.pings,
            stations=self._stations(face.wall),
        )

    def _ends(self, number: int, face: Face) -> tuple[float, float]:
        low, high = face.low, face.high
        for vertex in self.vertices:
            for each, upper in zip(vertex.faces, vertex.upper, strict=True):
                if each == number:
                    place = float(vertex.position_xy @ face.along)
                    low, high = (low, place) if upper else (place, high)
        missing = max(self.settings.least_length - (high - low), 0.0) / 2
        return low - missing, high + missing

    def _corner(self, vertex: Vertex) -> Corner:
        owners = [self.faces[each].owner for each in vertex.faces]
        lines = np.array([self.features[each].line for each in owners])
        slopes = crossing_slopes(lines, vertex.position_xy)
        heard, echo = self._heard_corner(vertex.position_xy), vertex.echo
        return Corner(
            position_xy=vertex.position_xy,
            kind=vertex.kind,
            covariance=slopes @ self._covariance(owners) @ slopes.T,
            class_probabilities=ClassProbabilities(corner=1.0) if heard is None else self._class_of(heard),
            pings=echo.pings if heard is None else self._pings(heard),
            stations=echo.stations if heard is None else self._stations(self.features[heard]),
        )

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
        """Return True for a corner that no walls make and that is where its echo seems to come from.

        The echo of a concave corner goes over both of its sides: in one of the angle b it comes back after r sin(b),
        not r, of the distance r of the vertex. Only where walls are square to each other the vertex is known.
        """
        if feature.kind is Kind.CORNER and self.squareness is None:
            return False
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
