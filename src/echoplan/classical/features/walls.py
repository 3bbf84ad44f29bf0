"""Walls: from lines that several sweeps share to faces with ends."""

from collections.abc import Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray
from echoplan.classical.features.association import Group
from echoplan.classical.features.junctions import Junction, Span
from echoplan.classical.features.observations import shares
from echoplan.geometry import along, lines_through, path_crossings
from echoplan.model import Wall
from echoplan.settings import Settings

__all__ = ["WallSettings", "detected_span", "opened_by", "walls_of"]

# A robot is at least this wide to each side of its path; shorter pieces of a wall are not kept [m].
_HALF_WIDTH = 0.1


class WallSettings(Settings):
    """How far walls extend beyond what was detected of them."""

    former_keys: ClassVar = {"heard_extension": "max_detected_extension"}

    max_extension: float = Field(
        default=1.0,
        ge=0.0,
        description="Largest length by which a wall is extended to a corner that is not detected [m].",
    )
    max_detected_extension: float = Field(
        default=3.0,
        ge=0.0,
        description="Largest length by which a wall is extended to a detected corner [m]: the range of a module.",
    )
    wavelength: float = Field(
        default=0.0086,
        gt=0.0,
        description="Wavelength of the carrier [m]: a wall detected once is as long as its Fresnel zone.",
    )


def detected_span(group: Group, settings: WallSettings) -> Span:
    """Return the stretch of a line that was detected.

    Parameters
    ----------
    group : Group
        Observations of a wall, with its line.
    settings : WallSettings
        The wavelength.

    Returns
    -------
    Span
        From the first echo point to the last, each with the first Fresnel zone of an echo from depth d about it,
        whose radius is ``sqrt(wavelength d / 2)``.
    """
    hubs = np.array([member.point.hub_xy for member in group.members])
    depths = np.array([member.point.distance for member in group.members])
    coordinates = along(group.fit.parameters, hubs)
    zones = np.sqrt(settings.wavelength * np.maximum(depths, 0.0) / 2)
    return Span(
        line=group.fit.parameters,
        low=float((coordinates - zones).min()),
        high=float((coordinates + zones).max()),
    )


def walls_of(groups: list[Group], spans: list[Span], meetings: list[Junction]) -> tuple[Wall, ...]:
    """Make walls of lines, lengthened to where they meet their neighbours.

    Parameters
    ----------
    groups : list of Group
        Lines with their observations.
    spans : list of Span
        Stretch of each that was detected.
    meetings : list of Junction
        Where they meet.

    Returns
    -------
    tuple of Wall
        One a group, in the same order.
    """
    ends = {end: meeting.position_xy for meeting in meetings for end in meeting.ends}
    return tuple(
        _wall(
            group,
            ends.get((number, False), span.point_xy(span.low)),
            ends.get((number, True), span.point_xy(span.high)),
        )
        for number, (group, span) in enumerate(zip(groups, spans, strict=True))
    )


def _wall(group: Group, start_xy: FloatArray, end_xy: FloatArray) -> Wall:
    return Wall(
        normal_angle=float(group.fit.parameters[0]),
        offset=float(group.fit.parameters[1]),
        endpoints_xy=np.stack([start_xy, end_xy]),
        covariance=group.fit.covariance,
        class_probabilities=shares(group.degrees),
        pings=group.pings,
        stations=group.stations,
    )


def opened_by(path_xy: FloatArray, walls: Sequence[Wall]) -> tuple[Wall, ...]:
    """Cut walls where the path of the robot, shape (p, 2) [m], leads through them."""
    return tuple(piece for wall in walls for piece in _pieces(wall, path_xy))


def _pieces(wall: Wall, path_xy: FloatArray) -> list[Wall]:
    start, unit = wall.endpoints_xy[0], (wall.endpoints_xy[1] - wall.endpoints_xy[0]) / wall.length
    line = lines_through(*wall.endpoints_xy)
    places = np.sort(path_crossings(line, path_xy) - along(line, start))
    places = places[(places > 0.0) & (places < wall.length)]
    if not len(places):
        return [wall]
    begins = np.concatenate([[0.0], places + _HALF_WIDTH])
    ends = np.concatenate([places - _HALF_WIDTH, [wall.length]])
    return [
        replace(
            wall,
            endpoints_xy=start + np.outer((begin, end), unit),
            pings=round(wall.pings * (end - begin) / wall.length),
            endpoint_sigmas=np.full(2, np.nan),
            inferred=np.zeros(2),
        )
        for begin, end in zip(begins, ends, strict=True)
        if end - begin > _HALF_WIDTH
    ]
