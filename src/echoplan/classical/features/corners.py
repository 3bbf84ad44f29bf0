"""Corners: the crossings of neighbouring walls, and the observations of the corners themselves."""

from typing import TypeAlias

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.features.association import AssociationSettings
from echoplan.classical.features.junctions import Junction
from echoplan.classical.features.observations import Observation, shares, stations_of
from echoplan.geometry import along, intersections, wrap
from echoplan.model import ClassProbabilities, Corner, Wall

__all__ = ["CornerObservations", "associate_corners", "corner_of", "crossing_covariance"]

# Observations associated with one corner.
CornerObservations: TypeAlias = tuple[Observation, ...]


def associate_corners(
    meetings: list[Junction], observations: list[Observation], settings: AssociationSettings
) -> list[CornerObservations]:
    """Associate observations of corners with crossings of walls.

    The direction of a corner is uncertain, because its echo is received in the window that the walls beside it leave;
    so the distance decides.

    Parameters
    ----------
    meetings : list of Junction
        Where walls may meet.
    observations : list of Observation
        Observations of corners.
    settings : AssociationSettings
        Gates of distance and direction.

    Returns
    -------
    list of tuple of Observation
        The observations of each meeting; one that fits several is given to that whose distance fits best.
    """
    associated: list[list[Observation]] = [[] for _ in meetings]
    for observation in observations:
        number = _nearest(observation, meetings, settings)
        if number is not None:
            associated[number].append(observation)
    return [tuple(each) for each in associated]


def corner_of(meeting: Junction, walls: tuple[Wall, ...], associated: CornerObservations) -> Corner:
    """Make a corner where two walls meet.

    Parameters
    ----------
    meeting : Junction
        Where they meet; numbers as in ``walls``.
    walls : tuple of Wall
        The walls.
    associated : tuple of Observation
        Observations of the corner itself.

    Returns
    -------
    Corner
        The corner.
    """
    degrees = np.sum([each.degrees for each in associated], axis=0) if associated else None
    return Corner(
        position_xy=meeting.position_xy,
        kind=meeting.kind,
        covariance=crossing_covariance(walls[meeting.first], walls[meeting.second]),
        class_probabilities=ClassProbabilities(corner=1.0) if degrees is None else shares(degrees),
        pings=sum(each.pings for each in associated),
        stations=stations_of(associated),
    )


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
    position = intersections(_line(first), _line(second))
    inverse = np.linalg.inv(np.stack([first.normal_xy, second.normal_xy]))
    covariance = np.zeros((2, 2))
    for column, wall in zip(inverse.T, (first, second), strict=True):
        slope = np.array([-float(along(_line(wall), position)), 1.0])
        covariance += np.outer(column, column) * float(slope @ wall.covariance @ slope)
    return covariance


def _line(wall: Wall) -> FloatArray:
    return np.array([wall.normal_angle, wall.offset])


def _nearest(observation: Observation, meetings: list[Junction], settings: AssociationSettings) -> int | None:
    point = observation.point
    away = np.array([meeting.position_xy for meeting in meetings]).reshape(-1, 2) - point.hub_xy
    misses = np.abs(np.hypot(*away.T) - point.distance)
    turns = np.abs(wrap(np.arctan2(away[:, 1], away[:, 0]) - point.bearing))
    fits = (misses <= settings.distance_gate) & (turns <= settings.bearing_gate + 3 * np.sqrt(point.covariance[0, 0]))
    return int(np.argmin(np.where(fits, misses, np.inf))) if fits.any() else None
