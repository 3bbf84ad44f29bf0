"""Corners: the crossings of neighbouring walls, and whether they were heard by themselves."""

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import along, intersections, wrap
from echoplan.mapping.association import AssociationSettings
from echoplan.mapping.junctions import Junction
from echoplan.mapping.observations import Observation, shares, stations_of
from echoplan.model import ClassProbabilities, Corner, Wall

__all__ = ["corners_of", "crossing_covariance"]


def corners_of(
    walls: tuple[Wall, ...], meetings: list[Junction], heard: list[Observation], settings: AssociationSettings
) -> tuple[Corner, ...]:
    """Make corners where walls meet, and give each what was heard of it.

    Parameters
    ----------
    walls : tuple of Wall
        The walls.
    meetings : list of Junction
        Where they meet; numbers as in ``walls``.
    heard : list of Observation
        Observations of corners.
    settings : AssociationSettings
        How near the heard distance and direction must be to the crossing's.

    Returns
    -------
    tuple of Corner
        One for each meeting; what was heard where no two walls meet is none.
    """
    voices: list[list[Observation]] = [[] for _ in meetings]
    for observation in heard:
        number = _heard_at(observation, meetings, settings)
        if number is not None:
            voices[number].append(observation)
    return tuple(_corner(walls, meeting, group) for meeting, group in zip(meetings, voices, strict=True))


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


def _heard_at(observation: Observation, meetings: list[Junction], settings: AssociationSettings) -> int | None:
    """Tell at which meeting a corner was heard: the one whose distance fits best, within the gates.

    A corner says little of its direction: it answers in whatever window the walls beside it leave.
    """
    point = observation.point
    away = np.array([meeting.position_xy for meeting in meetings]).reshape(-1, 2) - point.hub_xy
    misses = np.abs(np.hypot(*away.T) - point.distance)
    turns = np.abs(wrap(np.arctan2(away[:, 1], away[:, 0]) - point.bearing))
    fits = (misses <= settings.distance_gate) & (turns <= settings.bearing_gate + 3 * np.sqrt(point.covariance[0, 0]))
    return int(np.argmin(np.where(fits, misses, np.inf))) if fits.any() else None


def _corner(walls: tuple[Wall, ...], meeting: Junction, heard: list[Observation]) -> Corner:
    degrees = np.sum([each.degrees for each in heard], axis=0) if heard else None
    return Corner(
        position_xy=meeting.position_xy,
        kind=meeting.kind,
        covariance=crossing_covariance(walls[meeting.first], walls[meeting.second]),
        class_probabilities=ClassProbabilities(corner=1.0) if degrees is None else shares(degrees),
        pings=sum(each.pings for each in heard),
        stations=stations_of(tuple(heard)),
    )
