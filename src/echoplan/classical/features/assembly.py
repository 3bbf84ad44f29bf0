"""Assembly: from groups of observations to a map."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

import numpy as np
from pydantic import Field

from echoplan.classical.features.association import AssociationSettings, Group
from echoplan.classical.features.corners import CornerObservations, associate_corners, corner_of
from echoplan.classical.features.cylinders import CylinderSettings, cylinder_of
from echoplan.classical.features.junctions import Junction, Span, junctions, settle
from echoplan.classical.features.observations import Observation, stations_of
from echoplan.classical.features.walls import WallSettings, detected_span, walls_of
from echoplan.model import FeatureMap, Sweep
from echoplan.settings import Settings

__all__ = ["AssemblySettings", "Grouped", "assemble"]

_NONE: Mapping[str, object] = MappingProxyType({})


class AssemblySettings(Settings):
    """How observations of many sweeps become one map."""

    association: AssociationSettings = Field(default_factory=AssociationSettings)
    min_stations: int = Field(default=2, ge=1, description="Smallest number of stations that must detect an object.")
    walls: WallSettings = Field(default_factory=WallSettings)
    cylinders: CylinderSettings = Field(default_factory=CylinderSettings)


@dataclass(frozen=True, slots=True, kw_only=True)
class Grouped:
    """Observations put together by object, and the objects by class.

    Parameters
    ----------
    lines : list of Group
        Walls.
    corners : list of Observation
        Observations of corners themselves.
    cylinders : list of tuple of Observation
        Cylinders.
    """

    lines: list[Group] = field(default_factory=list)
    corners: list[Observation] = field(default_factory=list)
    cylinders: list[tuple[Observation, ...]] = field(default_factory=list)

    def confirmed(self, min_stations: int) -> "Grouped":
        """Keep the walls and cylinders that enough stations detected; corners need walls that meet anyway.

        Parameters
        ----------
        min_stations : int
            Smallest number of stations.

        Returns
        -------
        Grouped
            Without the others.
        """
        return Grouped(
            lines=[group for group in self.lines if group.stations >= min_stations],
            corners=self.corners,
            cylinders=[members for members in self.cylinders if stations_of(members) >= min_stations],
        )


def assemble(
    grouped: Grouped,
    sweeps: list[Sweep],
    settings: AssemblySettings,
    *,
    method: str,
    parameters: Mapping[str, object] = _NONE,
) -> FeatureMap:
    """Make a map of grouped observations: fit, extend and intersect.

    Parameters
    ----------
    grouped : Grouped
        Observations by object.
    sweeps : list of Sweep
        What the map was made of; their poses are taken as given.
    settings : AssemblySettings
        Gates and prior knowledge.
    method : str
        Name of the method.
    parameters : mapping, optional
        Its settings, ready for JSON.

    Returns
    -------
    FeatureMap
        Walls that end where they meet, corners where they cross, cylinders with their radius.
    """
    sure = grouped.confirmed(settings.min_stations)
    spans = [detected_span(group, settings.walls) for group in sure.lines]
    corners = _corners(spans, sure.corners, settings)
    walls = walls_of(sure.lines, spans, [meeting for meeting, _ in corners])
    cylinders = [
        cylinder_of(members, settings.cylinders, association=settings.association) for members in sure.cylinders
    ]
    return FeatureMap(
        method=method,
        parameters=parameters,
        walls=walls,
        corners=tuple(corner_of(meeting, walls, associated) for meeting, associated in corners),
        cylinders=tuple(cylinder for cylinder in cylinders if cylinder is not None),
        sweeps=np.array([sweep.index for sweep in sweeps], dtype=np.int64),
        poses=np.array([sweep.station for sweep in sweeps]).reshape(-1, 3),
    )


def _corners(
    spans: list[Span], observations: list[Observation], settings: AssemblySettings
) -> list[tuple[Junction, CornerObservations]]:
    """Decide which walls meet: first where the corner was detected, then in order of the extension needed."""
    possible = junctions(spans, max_extension=settings.walls.max_detected_extension)
    associated = dict(zip(possible, associate_corners(possible, observations, settings.association), strict=True))
    trusted = [each for each in possible if associated[each] or each.longest <= settings.walls.max_extension]
    return [(each, associated[each]) for each in settle(sorted(trusted, key=lambda each: not associated[each]))]
