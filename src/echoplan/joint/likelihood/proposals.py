"""Proposals: landmarks that arcs of different stations suggest.

A wall is a tangent of the range circles of two arcs, a corner or an edge a common point, a cylinder a circle that
touches both (Leonard and Durrant-Whyte 1992). Proposals need only be approximate: refinement and log-likelihood ratio
decide.
"""

import math
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.geometry import directions, wrap
from echoplan.joint.landmarks import LANDMARKS

__all__ = ["ROUND_STATIONS", "ArcMeasurements", "CandidateSettings", "propose_hypotheses"]


# Number of arcs with most pings of which all triples suggest round walls; least determinant of their normals; least and
# greatest radius [m].
_LONGEST_ARCS, _LEAST_DETERMINANT, _ROUNDEST, _FLATTEST = 50, 0.2, 0.4, 8.0
# Greatest distance of a plane from a round wall that it touches [m]; least number of stations that detect one.
_TOUCHED, ROUND_STATIONS = 0.02, 5


class CandidateSettings(NamedTuple):
    """Tolerances within which arcs suggest a landmark."""

    # Largest angle between the normal of an arc and that of a tangent [rad].
    wall_angle_gate: float = np.radians(10)
    # Largest angle between the normal of an arc and the direction of a point [rad].
    point_angle_gate: float = np.radians(9)
    # Radii of proposed cylinders [m].
    radii: tuple[float, ...] = (0.04, 0.08, 0.12, 0.18, 0.26)
    # Smallest distance between two stations whose arcs are combined [m].
    min_baseline: float = 0.05
    # Largest distance between two stations whose arcs are combined [m].
    max_baseline: float = 6.0
    # Largest number of proposals of one class; those that more pairs suggest are kept.
    max_candidates: int = 1500


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class ArcMeasurements:
    """Arcs as the planes that explain them."""

    # Index of the station of each arc, shape (a,).
    stations: IntArray
    # Center of this station [m], shape (a, 2).
    centers: FloatArray
    # ``(normal_angle, offset)`` [rad, m], shape (a, 2).
    planes: FloatArray
    # Number of pings of each arc, shape (a,).
    pings: IntArray

    @property
    def depths(self) -> FloatArray:
        """Distance of each plane from the center of its station, at least 0.03 [m], shape (a,)."""
        depths: FloatArray = self.planes[:, 1] - np.sum(directions(self.planes[:, 0]) * self.centers, axis=1)
        nearest: FloatArray = np.maximum(depths, 0.03)
        return nearest


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Pairs:
    """Pairs of arcs of different stations, with length [m] and bearing [rad] of the baseline."""

    first: IntArray
    second: IntArray
    length: FloatArray
    bearing: FloatArray

    def __getitem__(self, chosen: BoolArray) -> "_Pairs":
        return _Pairs(
            first=self.first[chosen],
            second=self.second[chosen],
            length=self.length[chosen],
            bearing=self.bearing[chosen],
        )


def propose_hypotheses(arc_measurements: ArcMeasurements, fresh: BoolArray, settings: CandidateSettings) -> FloatArray:
    """Return the kind and parameters of proposed walls, corners (which may be edges) and cylinders, shape (c, 4).

    Each arc of ``fresh``, shape (a,), suggests a wall; pairs of arcs are used if at least one of them is fresh.
    """
    pairs = _pairs(arc_measurements, fresh, settings)
    alone = arc_measurements.planes[fresh]
    walls, turn = (
        np.concatenate([alone, _tangents(arc_measurements, pairs, settings.wall_angle_gate)]),
        settings.point_angle_gate,
    )
    points = _circles(arc_measurements, pairs, radius=0.0, turn=turn)
    rounds = np.concatenate([_circles(arc_measurements, pairs, radius=radius, turn=turn) for radius in settings.radii])
    return np.concatenate(
        [
            _distinct(Kind.WALL, np.column_stack([walls, 0 * walls[:, 0]]), settings),
            _distinct(Kind.CORNER, points, settings),
            _distinct(Kind.CYLINDER, rounds, settings),
            _distinct(Kind.ROUND, _round_walls(arc_measurements, turn), settings),
        ]
    )


def _pairs(arc_measurements: ArcMeasurements, fresh: BoolArray, settings: CandidateSettings) -> _Pairs:
    """Return the pairs with a fresh arc whose stations differ and are neither too near nor too far apart."""
    first, second = np.triu_indices(len(fresh), 1)
    base = arc_measurements.centers[second] - arc_measurements.centers[first]
    length = np.hypot(*base.T)
    new = (fresh[first] | fresh[second]) & (arc_measurements.stations[first] != arc_measurements.stations[second])
    pairs = _Pairs(first=first, second=second, length=length, bearing=np.arctan2(base[:, 1], base[:, 0]))
    return pairs[new & (length > settings.min_baseline) & (length < settings.max_baseline)]


def _tangents(arc_measurements: ArcMeasurements, pairs: _Pairs, turn: float) -> FloatArray:
    """Return common outer tangents of pairs of range circles, ``n . (c2 - c1) = d1 - d2``, as normal angle, offset."""
    depths, normals = arc_measurements.depths, arc_measurements.planes[:, 0]
    difference = depths[pairs.first] - depths[pairs.second]
    likely = (np.abs(wrap(normals[pairs.first] - normals[pairs.second])) < turn) & (np.abs(difference) < pairs.length)
    pairs, difference = pairs[likely], difference[likely]
    opening = np.arccos(difference / pairs.length)
    angles = np.concatenate([pairs.bearing + opening, pairs.bearing - opening])
    first, second = np.tile(pairs.first, 2), np.tile(pairs.second, 2)
    fits = (np.abs(wrap(angles - normals[first])) < turn) & (np.abs(wrap(angles - normals[second])) < turn)
    offsets = depths[first] + np.sum(directions(angles) * arc_measurements.centers[first], axis=1)
    return np.column_stack([wrap(angles), offsets])[fits]


def _circles(arc_measurements: ArcMeasurements, pairs: _Pairs, *, radius: float, turn: float) -> FloatArray:
    """Return centers of circles of one radius that touch both range circles from outside, as (x, y, radius) [m]."""
    near, far = arc_measurements.depths[pairs.first] + radius, arc_measurements.depths[pairs.second] + radius
    along = (pairs.length**2 + near**2 - far**2) / (2 * pairs.length)
    square = near**2 - along**2
    # Circles that miss each other by no more than the error of the readings touch.
    meets = square > -0.02
    pairs, along, across = pairs[meets], along[meets], np.sqrt(np.maximum(square[meets], 0.0))
    ahead, aside = directions(pairs.bearing), directions(pairs.bearing + np.pi / 2)
    feet = arc_measurements.centers[pairs.first] + along[:, None] * ahead
    centers = np.concatenate([feet + across[:, None] * aside, feet - across[:, None] * aside])
    fits = np.ones(len(centers), dtype=bool)
    for ends in (np.tile(pairs.first, 2), np.tile(pairs.second, 2)):
        away = centers - arc_measurements.centers[ends]
        fits &= np.abs(wrap(np.arctan2(away[:, 1], away[:, 0]) - arc_measurements.planes[ends, 0])) < turn
    return np.column_stack([centers, np.full(len(centers), radius)])[fits]


def _round_walls(arc_measurements: ArcMeasurements, turn: float) -> FloatArray:
    """Return circles that the planes of arcs from enough stations touch from outside, as (x, y, radius) [m].

    The echo of a round wall returns along the line from the sensor through the centre, one way or the other. Any three
    planes touch a circle, so more of them must do so.
    """
    longest = np.sort(np.argsort(-arc_measurements.pings, kind="stable")[:_LONGEST_ARCS])
    stations, centers, offsets = (
        each[longest] for each in (arc_measurements.stations, arc_measurements.centers, arc_measurements.planes[:, 1])
    )
    normals = directions(arc_measurements.planes[longest, 0])
    triples = np.array(list(combinations(range(len(longest)), 3)), dtype=np.int64).reshape(-1, 3)
    lines = np.concatenate([normals[triples], np.ones((len(triples), 3, 1))], axis=2)
    spread = np.abs(np.linalg.det(lines)) > _LEAST_DETERMINANT
    circles = np.linalg.solve(lines[spread], offsets[triples[spread]][:, :, None])[:, :, 0]
    circles = circles[(circles[:, 2] > _ROUNDEST) & (circles[:, 2] < _FLATTEST)]
    away = centers - circles[:, None, :2]
    aside = np.abs(away[..., 0] * normals[:, 1] - away[..., 1] * normals[:, 0])
    touched = np.abs(circles[:, :2] @ normals.T + circles[:, 2:] - offsets) < _TOUCHED
    touched &= aside < math.sin(turn) * np.hypot(away[..., 0], away[..., 1])
    of_station = stations[:, None] == np.unique(stations)
    supporting: IntArray = (touched @ of_station).sum(axis=1)
    chosen: FloatArray = circles[supporting >= ROUND_STATIONS]
    return chosen


def _distinct(kind: Kind, candidates: FloatArray, settings: CandidateSettings) -> FloatArray:
    """Keep one proposal in each cell of a grid, shape (c, 4); of too many, those of the fullest cells."""
    if len(candidates):
        cells = np.round(candidates / LANDMARKS[kind].proposal_cell).astype(np.int64)
        _, index, counts = np.unique(cells, axis=0, return_index=True, return_counts=True)
        candidates = candidates[index[np.argsort(-counts, kind="stable")[: settings.max_candidates]]]
    return np.column_stack([np.full(len(candidates), float(kind)), candidates])
