"""Map builder: optimised landmarks as the walls, corners and cylinders of a map, with covariances."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import ClassVar, NamedTuple

import numpy as np
from pydantic import Field

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import crosses_segments, path_crossings, wrap
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.map_extraction.corners import Vertex
from echoplan.joint.map_extraction.openings import Gap, merged_faces
from echoplan.joint.map_extraction.round_walls import chords
from echoplan.joint.map_extraction.segment import End, Segment, path_since
from echoplan.joint.map_extraction.surroundings import backs_of, fronts_of, is_filled
from echoplan.joint.optimisation.corner_factors import CornerFactorSettings, constrained_corners, crossing_jacobian
from echoplan.joint.optimisation.manhattan import ManhattanPrior
from echoplan.joint.optimisation.solution import Solution
from echoplan.model import ClassProbabilities, Corner, CornerKind, Cylinder, FeatureClass, Wall
from echoplan.settings import Settings

__all__ = ["MapBuilder", "MapSettings"]

# Length up to which a gap is ignored [m].
_TOUCHING = 0.05
# Distance between the end of a wall and the path of the robot, so that they do not touch [m].
_CLEAR = 0.001
# Greatest shift of an end to the jamb that the other face of the wall determines [m].
_FARTHEST = 0.4
# Least and greatest width of an opening [m]: narrower ones are no passage, wider ones separate two walls.
_WIDTHS = (0.5, 3.0)


class MapSettings(Settings):
    """Criteria for what is drawn."""

    former_keys: ClassVar = {
        "clear_station": "min_station_llr",
        "lone_stations": "lone_corner_min_stations",
        "lone_sigma": "lone_corner_sigma",
        "lone_distance": "lone_corner_min_distance",
        "least_length": "min_wall_length",
    }

    # Smallest log-likelihood ratio of a supporting station [nats].
    min_station_llr: ClassVar[float] = 5.0
    # Smallest number of stations that must detect a corner without walls.
    lone_corner_min_stations: ClassVar[int] = 3
    # Model error of a corner without walls [m], chosen on 15 of them in random rooms with a recess.
    lone_corner_sigma: ClassVar[float] = 0.004
    # Smallest distance of a corner without walls from any other corner [m].
    lone_corner_min_distance: ClassVar[float] = 0.06
    min_wall_length: float = Field(default=0.06, gt=0.0, description="Length of a wall with one detected point [m].")


class _Drawn(NamedTuple):
    """A segment as drawn: distributions of its ends (None if unknown), end places, and inferred lengths there [m]."""

    ends: tuple[End | None, End | None]
    places: tuple[float, float]
    inferred: tuple[float, float]

    def moved_to(self, gap: Gap, along: FloatArray) -> "_Drawn":
        """Move the end at a gap to the jamb that both faces determine, unless no observed length would remain."""
        (first, last), (low, high) = (
            sorted(zip(gap.endpoints_xy @ along, gap.jambs, strict=True), key=lambda each: each[0]),
            self.places,
        )
        upper = bool(abs(high - first[0]) < abs(low - last[0]))
        place, jamb = first if upper else last
        places = (low, place) if upper else (place, high)
        if (
            not jamb.is_known
            or places[1] - places[0] <= sum(self.inferred)
            or abs(place - self.places[upper]) > _FARTHEST
        ):
            return self
        known = End.normal(place, jamb.sigma)
        return self._replace(ends=(self.ends[0], known) if upper else (known, self.ends[1]), places=places)


def _diluted(probabilities: ClassProbabilities, share: float) -> ClassProbabilities:
    """Mix class probabilities with a share of one third each, for what was not observed."""
    mixed = (1.0 - share) * np.array([probabilities.wall, probabilities.corner, probabilities.cylinder]) + share / 3.0
    wall, corner, cylinder = mixed.tolist()
    return ClassProbabilities(wall=wall, corner=corner, cylinder=cylinder)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class MapBuilder:
    """Landmarks, segments and corners from which a map is made, and their covariances."""

    # Optimised landmarks with their track histories.
    features: Sequence[Hypothesis]
    solution: Solution
    segments: Sequence[Segment]
    vertices: Sequence[Vertex]
    # Manhattan prior that was used.
    manhattan_prior: ManhattanPrior | None
    settings: MapSettings
    # Criteria for corners that lie on walls.
    ties: CornerFactorSettings = field(default_factory=CornerFactorSettings)
    # Path of the robot, which no wall crosses [m], shape (p, 2).
    path_xy: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))

    def right_angles(self) -> dict[str, float | bool]:
        """Return what the Manhattan prior did, empty without one.

        Keys are ``walls``, the number of its members, ``sigma``, the standard deviation of their directions [rad], and
        ``along_axes``, whether they are aligned with the axes of the map.
        """
        if self.manhattan_prior is None:
            return {}
        walls = int(sum(self.manhattan_prior.members[segment.owner] for segment in self.segments))
        return {"walls": walls, "sigma": self.manhattan_prior.sigma, "along_axes": self.manhattan_prior.along_axes}

    def walls(self, gaps: Sequence[Gap]) -> tuple[Wall, ...]:
        """Return one wall per segment, and round walls as chords; walls beside an open gap end at its jambs."""
        drawn = [self._drawn(number) for number in range(len(self.segments))]
        for gap in gaps:
            for number in gap.walls if gap.is_open else ():
                drawn[number] = drawn[number].moved_to(gap, self.segments[number].along)
        straight = [self._wall(*each) for each in zip(self.segments, drawn, strict=True)]
        curved = (
            chord
            for number, each in enumerate(self.features)
            if each.kind is Kind.ROUND
            for chord in chords(each, self._covariance([number]), path_xy=path_since(each, self.path_xy))
        )
        return (*straight, *curved)

    def cylinders(self) -> tuple[Cylinder, ...]:
        """Return the cylinders."""
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
            if each.type.feature_class is FeatureClass.CYLINDER
        )

    def corners(self) -> tuple[Corner, ...]:
        """Return the corners where segments meet, and lone corners that were detected where none meet."""
        met = [self._corner(each) for each in self.vertices]
        lone = [
            self._lone_corner(number)
            for number, each in enumerate(self.features)
            if each.type.corner_kind and self._is_lone(each)
        ]
        return (*met, *lone)

    def _wall(self, segment: Segment, drawn: _Drawn) -> Wall:
        low, high = drawn.places
        normal_angle, offset = segment.wall.line.tolist()
        return Wall(
            normal_angle=float(wrap(normal_angle)),
            offset=offset,
            endpoints_xy=np.stack([segment.point(low), segment.point(high)]),
            covariance=self._covariance([segment.owner]),
            class_probabilities=_diluted(self._class_of(segment.owner), sum(drawn.inferred) / (high - low)),
            pings=segment.pings,
            stations=self._stations(segment.wall),
            endpoint_sigmas=np.array(
                [each.sigma if each is not None and each.is_known else math.nan for each in drawn.ends]
            ),
            inferred=np.array(drawn.inferred),
            reflection_loss=float(segment.wall.reflector[3]),
        )

    def _drawn(self, number: int) -> _Drawn:
        """Draw a segment up to its corners, up to its known ends, or as far as it was detected."""
        segment = self.segments[number]
        ends, places, is_inferred = list(segment.ends), [segment.low, segment.high], [False, False]
        for vertex in self.vertices:
            for each, upper in zip(vertex.segments, vertex.upper, strict=True):
                if each == number:
                    place = float(vertex.position_xy @ segment.along)
                    variance = segment.along @ self._covariance_of_vertex(vertex) @ segment.along
                    ends[int(upper)] = End.normal(place, math.sqrt(max(float(variance), 0.0)))
                    places[int(upper)], is_inferred[int(upper)] = place, not vertex.detected
        missing = max(self.settings.min_wall_length - (places[1] - places[0]), 0.0) / 2
        wanted = (places[0] - missing, places[1] + missing)
        low, high = self._beside_path(segment, *wanted)
        # An end that was clipped at the path of the robot is not known.
        known = [end if place == drawn else None for end, place, drawn in zip(ends, wanted, (low, high), strict=True)]
        beyond = (max(segment.low - low, 0.0), max(high - segment.high, 0.0))
        inferred = [length * is_one for length, is_one in zip(beyond, is_inferred, strict=True)]
        return _Drawn((known[0], known[1]), (low, high), (inferred[0], inferred[1]))

    def _beside_path(self, segment: Segment, low: float, high: float) -> list[float]:
        """Clip what is drawn beyond a segment at the path of the robot."""
        wall, middle = segment.wall, (segment.low + segment.high) / 2
        crossings = path_crossings(wall.line, path_since(wall, self.path_xy))
        before = max(crossings[crossings <= middle], default=-math.inf)
        after = min(crossings[crossings > middle], default=math.inf)
        return [max(low, before + _CLEAR), min(high, after - _CLEAR)]

    def gaps(self, path_xy: FloatArray) -> list[Gap]:
        """Return the gaps between consecutive segments of a line: openings and unobserved stretches.

        ``path_xy`` is the path of the robot, shape (p, 2) [m].
        """
        pairs = [
            (number, number + 1)
            for number, (one, other) in enumerate(pairwise(self.segments))
            if one.owner == other.owner
        ]
        drawn = [self._drawn(number) for number in range(len(self.segments))]
        gaps = [self._gap(pair, (drawn[pair[0]], drawn[pair[1]]), path_xy) for pair in pairs]
        wide = [each for each in gaps if each.ends[1] - each.ends[0] > _TOUCHING]
        return merged_faces([each for each in wide if not self._is_filled(each)])

    def _is_filled(self, gap: Gap) -> bool:
        """Return True if a wall of another landmark fills a gap: one wall may be mapped as two landmarks."""
        owner, (low, high) = self.segments[gap.walls[0]].owner, gap.ends.tolist()
        return is_filled(gap.line, low, high, [each for each in self.segments if each.owner != owner])

    def _gap(self, pair: tuple[int, int], drawn: tuple[_Drawn, _Drawn], path_xy: FloatArray) -> Gap:
        (one, other), (before, after), segment = pair, drawn, self.segments[pair[0]]
        low, high, line = before.places[1], after.places[0], segment.wall.line
        ends, crossings = (before.ends[1], after.ends[0]), path_crossings(line, path_since(segment.wall, path_xy))
        passed = bool(((crossings > low) & (crossings < high)).any())
        is_open = (
            segment.is_free(low, high)
            and _WIDTHS[0] < high - low < _WIDTHS[1]
            and None not in ends
            and not self._is_concave(one, upper=True)
            and not self._is_concave(other, upper=False)
            and not self._is_crossed(segment, low, high)
            and (passed or self._leads_on(segment, low, high))
        )
        return Gap(
            walls=(one, other),
            line=line,
            jambs=(ends[0] or End.normal(low, 0.0), ends[1] or End.normal(high, 0.0)),
            is_free=segment.is_free(low, high),
            is_open=is_open,
            passed=passed,
        )

    def _is_crossed(self, segment: Segment, low: float, high: float) -> bool:
        """Return True if another wall crosses a stretch of a line, so that both sides are not one wall."""
        others = [each for each in self.segments if each.owner != segment.owner]
        ends_xy = np.array([[each.point(each.low), each.point(each.high)] for each in others]).reshape(-1, 2, 2)
        inner = segment.point(low + _TOUCHING), segment.point(high - _TOUCHING)
        return bool(crosses_segments([inner[0]], [inner[1]], ends_xy).any())

    def _leads_on(self, segment: Segment, low: float, high: float) -> bool:
        """Return False if an object stands before a stretch of a line, or a wall closes it a little behind it."""
        others = [each for each in self.segments if each.owner != segment.owner]
        closing = fronts_of(segment.wall.line, others) + backs_of(segment.wall.line, others)
        return not any(first < high and low < last for first, last in closing)

    def _is_concave(self, number: int, *, upper: bool) -> bool:
        """Return True if an end of a segment is a concave corner, which no opening adjoins."""
        return any(
            vertex.kind is CornerKind.CONCAVE and (number, upper) in zip(vertex.segments, vertex.upper, strict=True)
            for vertex in self.vertices
        )

    def _corner(self, vertex: Vertex) -> Corner:
        detected, echo = self._detected_corner(vertex.position_xy), vertex.echo
        return Corner(
            position_xy=vertex.position_xy,
            kind=vertex.kind,
            covariance=self._covariance_of_vertex(vertex),
            class_probabilities=self._class_of_vertex(vertex) if detected is None else self._class_of(detected),
            pings=echo.pings if detected is None else self._pings(detected),
            stations=echo.stations if detected is None else self._stations(self.features[detected]),
        )

    def _covariance_of_vertex(self, vertex: Vertex) -> FloatArray:
        return self._covariance_of_crossing([self.segments[each].owner for each in vertex.segments], vertex.position_xy)

    def _covariance_of_crossing(self, owners: Sequence[int], crossing_xy: FloatArray) -> FloatArray:
        jacobian = crossing_jacobian(np.array([self.features[each].line for each in owners]), crossing_xy)
        covariance: FloatArray = jacobian @ self._covariance(owners) @ jacobian.T
        return covariance

    def _class_of_vertex(self, vertex: Vertex) -> ClassProbabilities:
        """Return the class probabilities of a corner where two lines cross.

        It is certain if it was detected, else as probable as wall between it and both segments.
        """
        chance = (
            1.0
            if vertex.detected
            else min(self.segments[each].chance_up_to(vertex.position_xy) for each in vertex.segments)
        )
        return _diluted(ClassProbabilities(corner=1.0), 1.0 - chance)

    def _lone_corner(self, number: int) -> Corner:
        """Return a corner at the crossing of its walls if both are known, else where its echo seems to come from.

        A wall that ends at the middle of another one, such as a partition, forms a corner with it, but no segments meet
        there.
        """
        feature = self.features[number]
        assert feature.type.corner_kind is not None
        position = feature.reflector[1:3]
        covariance = self._covariance([number]) + self.settings.lone_corner_sigma**2 * np.eye(2)
        for corner, walls, crossing in constrained_corners(
            np.array([each.reflector for each in self.features]), self.ties
        ):
            if corner == number:
                position, covariance = crossing, self._covariance_of_crossing(walls, crossing)
        return Corner(
            position_xy=position,
            kind=feature.type.corner_kind,
            covariance=covariance,
            class_probabilities=self._class_of(number),
            pings=self._pings(number),
            stations=self._stations(feature),
        )

    def _is_lone(self, feature: Hypothesis) -> bool:
        """Return True for a corner without segments that meet that lies where its echo seems to come from.

        The echo of a concave corner is reflected by both of its sides. With an angle b between them it returns after r
        sin(b) rather than r, the distance of the vertex. Therefore the vertex is known only if walls are square to each
        other.
        """
        if feature.type.corner_kind is CornerKind.CONCAVE and self.manhattan_prior is None:
            return False
        distances = [math.dist(each.position_xy, feature.reflector[1:3]) for each in self.vertices]
        far = min(distances, default=math.inf) > self.settings.lone_corner_min_distance
        return far and self._stations(feature) >= self.settings.lone_corner_min_stations

    def _detected_corner(self, point_xy: FloatArray) -> int | None:
        near = {
            math.dist(each.reflector[1:3], point_xy): number
            for number, each in enumerate(self.features)
            if each.type.corner_kind
        }
        return near[min(near)] if near and min(near) < self.settings.lone_corner_min_distance else None

    def _covariance(self, owners: Sequence[int]) -> FloatArray:
        layout = self.solution.layout
        places = np.concatenate([np.arange(layout.size)[layout.feature(each)] for each in owners])
        block = self.solution.covariance[np.ix_(places, places)]
        symmetric: FloatArray = 0.5 * (block + block.T)
        return symmetric

    def _class_of(self, number: int) -> ClassProbabilities:
        return self.features[number].history.probabilities

    def _pings(self, number: int) -> int:
        return self.features[number].history.pings

    def _stations(self, feature: Hypothesis) -> int:
        return feature.history.supporting
