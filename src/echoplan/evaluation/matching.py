"""Which estimate is of which true object, and how far it is off.

The rules are fixed beforehand and know nothing of how a map was made.  A true object counts for recall when
enough stations can detect it.  An estimate of an object that few stations can detect is right all the same.
"""

from collections.abc import Callable, Sequence
from typing import TypeVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.evaluation.matches import CylinderMatch, Match, Matches, Matching, WallMatch
from echoplan.evaluation.vertices import true_vertices
from echoplan.geometry import along, lines_through, signed_distances, wrap
from echoplan.model import Corner, Cylinder, FeatureMap, Truth, Wall
from echoplan.settings import Settings

__all__ = [
    "MatchingSettings",
    "angles_between",
    "match_corners",
    "match_cylinders",
    "match_map",
    "match_walls",
    "one_each",
]

Kind = TypeVar("Kind", bound=Match)

# A shorter wall has no direction [m].
_SHORTEST = 1e-6


class MatchingSettings(Settings):
    """When an estimate is taken to be of a true object."""

    wall_angle: float = Field(
        default=float(np.radians(10)), gt=0, description="Largest angle between an estimated and a true wall [rad]."
    )
    wall_distance: float = Field(
        default=0.10, gt=0, description="Largest distance of the midpoint of an estimated wall from the true line [m]."
    )
    wall_slack: float = Field(
        default=0.10, ge=0, description="Largest distance of a midpoint beyond the ends of the true wall [m]."
    )
    cylinder_distance: float = Field(
        default=0.15, gt=0, description="Largest distance between an estimated and a true centre [m]."
    )
    corner_distance: float = Field(
        default=0.15, gt=0, description="Largest distance of an estimated corner from a true vertex [m]."
    )
    opening_distance: float = Field(
        default=0.30, gt=0, description="Largest distance between the midpoints of an estimated and a true opening [m]."
    )
    opening_angle: float = Field(
        default=float(np.radians(15)), gt=0, description="Largest angle between an estimated and a true opening [rad]."
    )
    opening_reach: float = Field(
        default=4.0, gt=0, description="Largest distance of a station that faces an opening [m]: that of an HC-SR04."
    )
    min_stations: int = Field(
        default=2,
        ge=1,
        description="Smallest number of stations that can detect an object that counts for recall.",
    )


def match_map(feature_map: FeatureMap, truth: Truth, settings: MatchingSettings | None = None) -> Matches:
    """Match all that a map has with the truth.

    Parameters
    ----------
    feature_map : FeatureMap
        The estimates.
    truth : Truth
        The true objects.
    settings : MatchingSettings, optional
        When the two are the same.

    Returns
    -------
    Matches
        The matching of each class.
    """
    settings = settings or MatchingSettings()
    return Matches(
        walls=match_walls(feature_map.walls, truth, settings),
        corners=match_corners(feature_map.corners, truth, settings),
        cylinders=match_cylinders(feature_map.cylinders, truth, settings),
    )


def match_walls(walls: Sequence[Wall], truth: Truth, settings: MatchingSettings) -> Matching[WallMatch]:
    """Match walls: each with the nearest true wall that it is close to and along; of duplicates the nearest stands.

    Parameters
    ----------
    walls : sequence of Wall
        The estimates; a wall's direction is that of its ends.
    truth : Truth
        The true walls.
    settings : MatchingSettings
        How close, how nearly parallel.

    Returns
    -------
    Matching of WallMatch
        At most one right estimate for each true wall.
    """
    candidates = [_wall_candidate(number, wall, truth, settings) for number, wall in enumerate(walls)]
    return one_each(
        candidates, detected_by=truth.walls_detected_by, settings=settings, rank=lambda match: match.distance
    )


def match_cylinders(cylinders: Sequence[Cylinder], truth: Truth, settings: MatchingSettings) -> Matching[CylinderMatch]:
    """Match cylinders: each with the true one whose centre is nearest; of duplicates the first stands.

    Parameters
    ----------
    cylinders : sequence of Cylinder
        The estimates.
    truth : Truth
        The true cylinders.
    settings : MatchingSettings
        How close.

    Returns
    -------
    Matching of CylinderMatch
        At most one right estimate for each true cylinder.
    """
    candidates = [_cylinder_candidate(number, each, truth, settings) for number, each in enumerate(cylinders)]
    return one_each(
        candidates, detected_by=truth.cylinders_detected_by, settings=settings, rank=lambda match: match.estimate
    )


def match_corners(corners: Sequence[Corner], truth: Truth, settings: MatchingSettings) -> Matching[Match]:
    """Match corners: each with the nearest vertex; several may be right about one.

    Parameters
    ----------
    corners : sequence of Corner
        The estimates.
    truth : Truth
        The true walls, whose ends are the vertices.
    settings : MatchingSettings
        How close.

    Returns
    -------
    Matching of Match
        Only vertices in which just two walls meet, both of them detectable, are wanted.  One is found if any corner is
        close, even if that corner is nearer to another vertex.
    """
    vertices = true_vertices(truth)
    positions = [corner.position_xy for corner in corners]
    reach = settings.corner_distance
    candidates = [_nearest(number, xy, vertices.positions_xy, reach=reach) for number, xy in enumerate(positions)]
    wanted = _wanted(vertices.detected_by, settings)
    return Matching(
        right=tuple(match for match in candidates if match),
        duplicate=(),
        spurious=_unmatched(candidates),
        detected_by=vertices.detected_by,
        wanted=wanted,
        found=tuple(
            vertex for vertex in wanted if (_distances(vertices.positions_xy[vertex], positions) <= reach).any()
        ),
    )


def _wall_candidate(number: int, wall: Wall, truth: Truth, settings: MatchingSettings) -> WallMatch | None:
    if wall.length < _SHORTEST:
        return None
    starts, ends = truth.walls_xy[:, 0], truth.walls_xy[:, 1]
    lines = lines_through(starts, ends)
    middle = wall.endpoints_xy.mean(axis=0)
    angles = angles_between(lines_through(*wall.endpoints_xy)[0], lines[:, 0])
    distances = np.abs(signed_distances(lines, middle))
    beyond = np.maximum(along(lines, starts) - along(lines, middle), along(lines, middle) - along(lines, ends))
    close = (angles <= settings.wall_angle) & (distances <= settings.wall_distance) & (beyond <= settings.wall_slack)
    if not close.any():
        return None
    nearest = int(np.where(close, distances, np.inf).argmin())
    return WallMatch(truth=nearest, estimate=number, distance=float(distances[nearest]), angle=float(angles[nearest]))


def _cylinder_candidate(
    number: int, cylinder: Cylinder, truth: Truth, settings: MatchingSettings
) -> CylinderMatch | None:
    match = _nearest(number, cylinder.center_xy, truth.cylinders[:, :2], reach=settings.cylinder_distance)
    if match is None:
        return None
    radius_error = cylinder.radius - float(truth.cylinders[match.truth, 2])
    return CylinderMatch(truth=match.truth, estimate=number, distance=match.distance, radius_error=radius_error)


def angles_between(direction: float, directions: FloatArray) -> FloatArray:
    """Angles between lines, which have no sense, in [0, pi/2] [rad]."""
    return np.abs(wrap(2 * (directions - direction))) / 2


def _nearest(number: int, position_xy: FloatArray, true_xy: FloatArray, *, reach: float) -> Match | None:
    distances = _distances(position_xy, true_xy)
    if not (distances <= reach).any():
        return None
    nearest = int(distances.argmin())
    return Match(truth=nearest, estimate=number, distance=float(distances[nearest]))


def _distances(position_xy: FloatArray, others_xy: FloatArray | Sequence[FloatArray]) -> FloatArray:
    offsets = np.reshape(others_xy, (-1, 2)) - position_xy
    return np.hypot(offsets[:, 0], offsets[:, 1])


def one_each(
    candidates: Sequence[Kind | None],
    *,
    detected_by: IntArray,
    settings: MatchingSettings,
    rank: Callable[[Kind], float],
) -> Matching[Kind]:
    """Let one estimate stand for each true object, the one of least rank."""
    groups: dict[int, list[Kind]] = {}
    for match in candidates:
        if match:
            groups.setdefault(match.truth, []).append(match)
    ranked = [sorted(group, key=rank) for group in groups.values()]
    wanted = _wanted(detected_by, settings)
    return Matching(
        right=tuple(group[0] for group in ranked),
        duplicate=tuple(match for group in ranked for match in group[1:]),
        spurious=_unmatched(candidates),
        detected_by=detected_by,
        wanted=wanted,
        found=tuple(number for number in wanted if number in groups),
    )


def _wanted(detected_by: IntArray, settings: MatchingSettings) -> tuple[int, ...]:
    return tuple(np.flatnonzero(detected_by >= settings.min_stations).tolist())


def _unmatched(candidates: Sequence[Match | None]) -> tuple[int, ...]:
    return tuple(number for number, match in enumerate(candidates) if match is None)
