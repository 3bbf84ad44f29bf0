"""Walls: from lines that several sweeps share to faces with ends."""

from dataclasses import replace

import numpy as np
from pydantic import BaseModel, Field

from echoplan.geometry import along
from echoplan.mapping.association import Group
from echoplan.mapping.junctions import Junction, Span, junctions
from echoplan.mapping.observations import shares
from echoplan.model import Wall

__all__ = ["WallSettings", "heard_span", "walls_of"]


class WallSettings(BaseModel, frozen=True, extra="forbid"):
    """How far walls go beyond what was heard of them."""

    max_extension: float = Field(
        default=1.5,
        ge=0.0,
        description="greatest length by which a wall is extended to meet its neighbour [m]: half a module's reach",
    )
    wavelength: float = Field(
        default=0.0086,
        gt=0.0,
        description="of the carrier [m]: a wall heard once is as long as its Fresnel zone",
    )


def heard_span(group: Group, settings: WallSettings) -> Span:
    """Tell which stretch of a line was heard.

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


def walls_of(groups: list[Group], settings: WallSettings) -> tuple[tuple[Wall, ...], list[Junction]]:
    """Make walls of lines, lengthened to where they meet their neighbours.

    Parameters
    ----------
    groups : list of Group
        Lines with their observations.
    settings : WallSettings
        How far a wall may be lengthened.

    Returns
    -------
    tuple of Wall
        One a group, in the same order.
    list of Junction
        Where they meet.
    """
    spans = [heard_span(group, settings) for group in groups]
    meetings = junctions(spans, max_extension=settings.max_extension)
    for meeting in meetings:
        for number, at_high in (
            (meeting.first, meeting.first_at_high),
            (meeting.second, meeting.second_at_high),
        ):
            end = float(along(spans[number].line, meeting.position_xy))
            spans[number] = replace(spans[number], high=end) if at_high else replace(spans[number], low=end)
    walls = tuple(_wall(group, span) for group, span in zip(groups, spans, strict=True))
    return walls, meetings


def _wall(group: Group, span: Span) -> Wall:
    return Wall(
        normal_angle=float(span.line[0]),
        offset=float(span.line[1]),
        endpoints_xy=np.stack([span.point_xy(span.low), span.point_xy(span.high)]),
        covariance=group.fit.covariance,
        class_probabilities=shares(group.degrees),
        pings=group.pings,
        stations=group.stations,
    )
