"""Walls: from lines that several sweeps share to faces with ends."""

import numpy as np
from pydantic import BaseModel, Field

from echoplan.arrays import FloatArray
from echoplan.geometry import along
from echoplan.mapping.association import Group
from echoplan.mapping.junctions import Junction, Span
from echoplan.mapping.observations import shares
from echoplan.model import Wall

__all__ = ["WallSettings", "heard_span", "walls_of"]


class WallSettings(BaseModel, frozen=True, extra="forbid"):
    """How far walls go beyond what was heard of them."""

    max_extension: float = Field(
        default=1.0,
        ge=0.0,
        description="greatest length by which a wall is extended to meet its neighbour unheard [m]",
    )
    heard_extension: float = Field(
        default=3.0, ge=0.0, description="likewise where the corner itself was heard [m]: the reach of a module"
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


def walls_of(groups: list[Group], spans: list[Span], meetings: list[Junction]) -> tuple[Wall, ...]:
    """Make walls of lines, lengthened to where they meet their neighbours.

    Parameters
    ----------
    groups : list of Group
        Lines with their observations.
    spans : list of Span
        How far each was heard.
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
