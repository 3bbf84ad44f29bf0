"""Fusion of two maps of walls: the tangents of arcs, and lines of triangulated points (Ismail and Balachandran 2015).

As recalled: features of circular arcs and Hough lines of triangulated points, each weak by itself, are put together.
"""

from collections.abc import Sequence

import numpy as np
from pydantic import Field

from echoplan.classical.features.kalman import KalmanSettings, misfits, update
from echoplan.classical.points import Segment
from echoplan.geometry import along
from echoplan.model import Wall
from echoplan.settings import Settings

__all__ = ["FusionSettings", "fuse_walls", "segment_of_wall"]


class FusionSettings(Settings):
    """When two walls are one, and what needs no witness."""

    same: KalmanSettings = Field(default_factory=KalmanSettings)
    min_stations: int = Field(
        default=3,
        ge=1,
        description="Smallest number of stations of a tangent that needs no line of points beside it: any two "
        "arcs share a tangent.",
    )


def fuse_walls(tangents: Sequence[Wall], lines: Sequence[Wall], settings: FusionSettings) -> list[Segment]:
    """Fuse the tangents of arcs with the lines of points that agree with them.

    Parameters
    ----------
    tangents : sequence of Wall
        Walls that arcs touch, with the number of their stations.
    lines : sequence of Wall
        Walls on which triangulated points lie.
    settings : FusionSettings
        What agrees.

    Returns
    -------
    list of Segment
        For each tangent its mean with the line that fits it best, weighted by information; itself, if no line fits but
        enough stations detected it.  A line that no arc touches is none.
    """
    witnesses = [segment_of_wall(line) for line in lines]
    fused = []
    for tangent in tangents:
        segment = segment_of_wall(tangent)
        apart = misfits(witnesses, segment, settings.same)
        if (apart <= settings.same.gate).any():
            fused.append(update(segment, witnesses[int(np.argmin(apart))]))
        elif tangent.stations >= settings.min_stations:
            fused.append(segment)
    return fused


def segment_of_wall(wall: Wall) -> Segment:
    """Take the segment out of a wall.

    Parameters
    ----------
    wall : Wall
        The wall.

    Returns
    -------
    Segment
        The same line between the same ends.
    """
    line = np.array([wall.normal_angle, wall.offset])
    ends = along(line, wall.endpoints_xy)
    return Segment(
        line=line, covariance=wall.covariance, low=float(ends.min()), high=float(ends.max()), stations=wall.stations
    )
