"""Features of points: walls with their ends, the corners in which they meet, circles of what is left."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray, checked_floats, checked_integers
from echoplan.classical.features.corners import crossing_covariance
from echoplan.classical.features.junctions import Junction, Span, junctions, settle
from echoplan.classical.points.circles import Circle, CircleSettings, find_circles
from echoplan.classical.points.clouds import Cloud
from echoplan.classical.points.peaks import find_segments
from echoplan.classical.points.segments import Segment, SegmentSettings
from echoplan.geometry import signed_distances
from echoplan.model import Corner, Cylinder, Wall
from echoplan.settings import Settings

__all__ = ["PointFeatureSettings", "PointFeatures", "features_of_points", "join_segments"]

Found = TypeVar("Found", Segment, Circle)


class PointFeatureSettings(Settings):
    """What makes walls, corners and cylinders of points."""

    segments: SegmentSettings = Field(default_factory=SegmentSettings)
    circles: CircleSettings = Field(default_factory=CircleSettings)
    min_stations: int = Field(
        default=2,
        ge=1,
        description="Smallest number of stations that must detect a feature, where the stations are known.",
    )
    max_extension: float = Field(
        default=0.5, ge=0.0, description="Largest length by which a wall is extended to meet its neighbour [m]."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PointFeatures:
    """What points show.

    Parameters
    ----------
    walls : tuple of Wall
        Segments, lengthened to where they meet.
    corners : tuple of Corner
        Where they meet.
    cylinders : tuple of Cylinder
        Circles.
    """

    walls: tuple[Wall, ...] = ()
    corners: tuple[Corner, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()


def features_of_points(
    points_xy: FloatArray,
    weights: FloatArray,
    settings: PointFeatureSettings | None = None,
    *,
    origins_xy: FloatArray | None = None,
    sweeps: IntArray | None = None,
) -> PointFeatures:
    """Find walls, corners and cylinders among points.

    Walls are the peaks of a Hough vote, fitted by orthogonal regression; corners the crossings of walls whose ends
    are near each other; cylinders are circles, by Taubin's fit, of knots of points that no wall explains.

    Parameters
    ----------
    points_xy : ndarray, shape (n, 2)
        Points of reflectors, or centres of occupied cells [m].
    weights : ndarray, shape (n,)
        Weight of each; a point of weight 2 counts as two points, one of weight 0 as none.
    settings : PointFeatureSettings, optional
        What makes a feature.
    origins_xy : ndarray, shape (n, 2), optional
        Where each point was observed from [m].  It gives the side of a wall, and so concave corners
        from convex ones.  Without it, one stood in the middle of all points.
    sweeps : ndarray of int, shape (n,), optional
        Sweep of each point.  It gives the number of stations that detected a feature.

    Returns
    -------
    PointFeatures
        The features, the heaviest first.

    Raises
    ------
    InvalidValueError
        If shapes differ, a number is not finite or a weight is negative.

    Examples
    --------
    >>> x, y = np.linspace(0.0, 2.0, 21), np.linspace(0.0, 1.5, 16)
    >>> points = np.concatenate([np.column_stack([x, 0 * x]), np.column_stack([0 * y + 2.2, y + 0.2])])
    >>> found = features_of_points(points, np.ones(len(points)))
    >>> [round(wall.length, 3) for wall in found.walls], found.corners[0].kind.value
    ([2.2, 1.7], 'concave')
    """
    settings = settings or PointFeatureSettings()
    points = checked_floats(points_xy, name="points_xy", shape=(None, 2))
    counted = checked_floats(weights, name="weights", shape=(len(points),)) != 0
    cloud = Cloud(points_xy=points[counted], weights=np.asarray(weights)[counted])
    if not len(cloud):
        return PointFeatures()
    origins = np.tile(cloud.centroid_xy, (len(points), 1)) if origins_xy is None else origins_xy
    origins = checked_floats(origins, name="origins_xy", shape=(len(points), 2))[counted]
    counted_sweeps = None if sweeps is None else checked_integers(sweeps, name="sweeps", shape=(len(points),))[counted]
    lines = find_segments(cloud, settings.segments)
    segments = [_facing(segment, cloud, origins) for segment in lines.found]
    circles = [
        replace(circle, members=lines.rest[circle.members])
        for circle in find_circles(cloud[lines.rest], settings.circles)
    ]
    return join_segments(
        _confirmed(segments, counted_sweeps, settings.min_stations),
        _confirmed(circles, counted_sweeps, settings.min_stations),
        max_extension=settings.max_extension,
    )


def join_segments(
    segments: Sequence[Segment], circles: Sequence[Circle] = (), *, max_extension: float
) -> PointFeatures:
    """Make walls of segments, lengthened to where they meet, and corners of the meetings.

    Parameters
    ----------
    segments : sequence of Segment
        Their normals away from the side from which they were observed.
    circles : sequence of Circle, optional
        What becomes cylinders.
    max_extension : float
        Greatest length by which a segment is extended to meet its neighbour [m].

    Returns
    -------
    PointFeatures
        Walls and cylinders in the given order.
    """
    spans = [Span(line=segment.line, low=segment.low, high=segment.high) for segment in segments]
    meetings = settle(junctions(spans, max_extension=max_extension))
    ends = {end: meeting.position_xy for meeting in meetings for end in meeting.ends}
    walls = tuple(
        _wall(
            segment,
            ends.get((number, False), span.point_xy(span.low)),
            ends.get((number, True), span.point_xy(span.high)),
        )
        for number, (segment, span) in enumerate(zip(segments, spans, strict=True))
    )
    return PointFeatures(
        walls=walls,
        corners=tuple(_corner(meeting, walls) for meeting in meetings),
        cylinders=tuple(_cylinder(circle) for circle in circles),
    )


def _confirmed(found: Sequence[Found], sweeps: IntArray | None, min_stations: int) -> list[Found]:
    """Count the stations of each feature, and keep those that enough stations detected; all if stations are unknown."""
    if sweeps is None:
        return list(found)
    counted = [replace(each, stations=len(np.unique(sweeps[each.members]))) for each in found]
    return [each for each in counted if each.stations >= min_stations]


def _facing(segment: Segment, cloud: Cloud, origins_xy: FloatArray) -> Segment:
    """Turn the normal of a segment away from where most of its weight was observed."""
    beyond = signed_distances(segment.line, origins_xy[segment.members])
    return segment.turned() if cloud.weights[segment.members] @ np.sign(beyond) > 0 else segment


def _wall(segment: Segment, start_xy: FloatArray, end_xy: FloatArray) -> Wall:
    return Wall(
        normal_angle=float(segment.line[0]),
        offset=float(segment.line[1]),
        endpoints_xy=np.stack([start_xy, end_xy]),
        covariance=segment.covariance,
        pings=len(segment.members),
        stations=segment.stations,
    )


def _corner(meeting: Junction, walls: tuple[Wall, ...]) -> Corner:
    return Corner(
        position_xy=meeting.position_xy,
        kind=meeting.kind,
        covariance=crossing_covariance(walls[meeting.first], walls[meeting.second]),
    )


def _cylinder(circle: Circle) -> Cylinder:
    return Cylinder(
        center_xy=circle.parameters[:2],
        radius=float(circle.parameters[2]),
        covariance=circle.covariance,
        pings=len(circle.members),
        stations=circle.stations,
    )
