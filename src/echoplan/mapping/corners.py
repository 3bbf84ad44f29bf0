"""Corners: the crossings of neighbouring walls, and whether they were heard by themselves."""

from itertools import combinations

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import along, intersections
from echoplan.mapping.junctions import Junction
from echoplan.mapping.observations import Observation, shares
from echoplan.model import ClassProbabilities, Corner, CornerKind, Wall

__all__ = ["corners_of", "crossing_covariance"]


def corners_of(
    walls: tuple[Wall, ...], meetings: list[Junction], heard: list[tuple[Observation, ...]], *, gate: float
) -> tuple[Corner, ...]:
    """Make corners where walls meet, and where a corner was heard at the crossing of two walls.

    Parameters
    ----------
    walls : tuple of Wall
        The walls.
    meetings : list of Junction
        Where they meet; numbers as in ``walls``.
    heard : list of tuple of Observation
        Groups of observations of corners.
    gate : float
        Greatest distance between a crossing and the corner heard at it [m].

    Returns
    -------
    tuple of Corner
        The corners; what was heard where no two walls cross is none.
    """
    pairs = {(meeting.first, meeting.second): meeting.kind for meeting in meetings}
    voices: dict[tuple[int, int], list[Observation]] = {pair: [] for pair in pairs}
    for group in heard:
        pair = _nearest_crossing(walls, group, preferred=list(pairs), gate=gate)
        if pair is not None:
            voices.setdefault(pair, []).extend(group)
    # A corner that answers with an echo of its own is heard into: an edge is some 30 dB fainter.
    return tuple(_corner(walls, pair, pairs.get(pair, CornerKind.CONCAVE), group) for pair, group in voices.items())


def crossing_covariance(first: Wall, second: Wall) -> FloatArray:
    """Covariance of the crossing of two walls by the delta method.

    The crossing x solves ``N x = c`` with the normals as rows of N; an error of an angle moves the right side by
    ``-(t . x)`` times as much, one of an offset by itself.

    Parameters
    ----------
    first, second : Wall
        Walls that are not parallel.

    Returns
    -------
    ndarray, shape (2, 2)
        Of x and y [m].
    """
    position = _crossing(first, second)
    inverse = np.linalg.inv(np.stack([first.normal_xy, second.normal_xy]))
    covariance = np.zeros((2, 2))
    for column, wall in zip(inverse.T, (first, second), strict=True):
        slope = np.array([-float(along(_line(wall), position)), 1.0])
        covariance += np.outer(column, column) * float(slope @ wall.covariance @ slope)
    return covariance


def _line(wall: Wall) -> FloatArray:
    return np.array([wall.normal_angle, wall.offset])


def _crossing(first: Wall, second: Wall) -> FloatArray:
    return intersections(_line(first), _line(second))


def _nearest_crossing(
    walls: tuple[Wall, ...], group: tuple[Observation, ...], *, preferred: list[tuple[int, int]], gate: float
) -> tuple[int, int] | None:
    """Pair of walls that cross nearest to where a corner was heard: one that meets, else any within the gate."""
    position = np.mean([member.point.position_xy for member in group], axis=0)
    for pairs in (preferred, list(combinations(range(len(walls)), 2))):
        crossings = np.array([_crossing(walls[i], walls[j]) for i, j in pairs]).reshape(-1, 2)
        distances = np.nan_to_num(np.hypot(*(crossings - position).T), nan=np.inf)
        if len(pairs) and distances.min() <= gate:
            return pairs[int(distances.argmin())]
    return None


def _corner(walls: tuple[Wall, ...], pair: tuple[int, int], kind: CornerKind, heard: list[Observation]) -> Corner:
    first, second = walls[pair[0]], walls[pair[1]]
    degrees = np.sum([each.degrees for each in heard], axis=0) if heard else None
    return Corner(
        position_xy=_crossing(first, second),
        kind=kind,
        covariance=crossing_covariance(first, second),
        class_probabilities=ClassProbabilities(corner=1.0) if degrees is None else shares(degrees),
        pings=sum(each.pings for each in heard),
        stations=len({each.sweep for each in heard}),
    )
