"""What a floor plan shows and where: bodies of walls, rooms, dimensions and labels, none over another."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions, outward_normals
from echoplan.model import Cylinder, FeatureMap, Opening, UnobservedStretch
from echoplan.viewer.floor_dimensions import inner_dimensions, outer_dimensions
from echoplan.viewer.floor_marks import Dimension, Label, place
from echoplan.viewer.floor_sheet import FloorSheet, floor_sheet
from echoplan.viewer.outline import label_turn, wall_bodies, wall_depths
from echoplan.viewer.plan import Plan
from echoplan.viewer.rooms import Room, closed_rooms
from echoplan.viewer.wording import decimal

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

__all__ = ["FloorLayout", "floor_layout"]

# Walls of which no back was detected are drawn this thick [mm on paper]: 10 cm at 1:50.
_THICKNESS = 2.0
# Labels of walls and openings stand this far from them, and those of cylinders from their rims [mm on paper].
_AWAY = 1.0
# Rows and columns of the places in a room at which its area may stand.
_GRID = 13
# Where along a wall its number may stand, the best place first.
_PLACES = (0.5, 0.35, 0.65, 0.2, 0.8, 0.1, 0.9)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class FloorLayout:
    """A floor plan, ready to be drawn.

    Parameters
    ----------
    sheet : FloorSheet
        Paper and scale.
    bodies : tuple of ndarray, shape (4, 2)
        Outline of each wall: its face, then its back from end to start [m].
    has_unknown_thickness : bool
        Whether the back of a wall was not detected.
    rooms : tuple of Room
        Closed rooms.
    dimensions : tuple of Dimension
        Dimension lines.
    labels : tuple of Label
        Areas of rooms, and numbers of walls, openings and cylinders as in the tables of a report.
    """

    sheet: FloorSheet
    bodies: tuple[FloatArray, ...]
    has_unknown_thickness: bool
    rooms: tuple[Room, ...]
    dimensions: tuple[Dimension, ...]
    labels: tuple[Label, ...]

    @property
    def footprints(self) -> list[Polygon]:
        """What the dimensions and the labels cover on paper."""
        return [*(each.footprint for each in self.dimensions), *(each.footprint for each in self.labels)]


def floor_layout(feature_map: FeatureMap, *, foot: float) -> FloorLayout:
    """Lay out a floor plan above a foot of some height [mm]; whatever finds no free place is left out.

    Dimensions outside the walls come first, then areas, numbers and the dimensions inside.
    """
    found, stations = feature_map, feature_map.poses[:, :2]
    features = FeatureMap(
        method=found.method,
        walls=found.walls,
        openings=found.openings,
        unobserved=found.unobserved,
        corners=found.corners,
        cylinders=found.cylinders,
    )
    sheet = floor_sheet(Plan(feature_map=features).bounds_xy, foot=foot)
    measured = wall_depths(found.walls, stations)
    depths = np.where(np.isnan(measured), _THICKNESS / sheet.millimetres, measured)
    bodies = wall_bodies(found.walls, stations, thickness=depths)
    outward = outward_normals(
        np.array([wall.endpoints_xy for wall in found.walls]),
        stations,
        normals_xy=np.array([wall.normal_xy for wall in found.walls]).reshape(-1, 2),
    )
    rooms = closed_rooms(found)
    taken = _taken(found, sheet, bodies)
    outer, taken = place(outer_dimensions(found, sheet, outward=outward, depths=depths), taken, window=sheet.window)
    labels, taken = place(
        _labels(found, sheet, outward=outward, bodies=bodies, rooms=rooms), taken, window=sheet.window
    )
    inner, _ = place(
        inner_dimensions(found, sheet, outward=outward, depths=depths, placed=outer), taken, window=sheet.window
    )
    return FloorLayout(
        sheet=sheet,
        bodies=tuple(bodies),
        has_unknown_thickness=bool(np.isnan(measured).any()),
        rooms=rooms,
        dimensions=(*outer, *inner),
        labels=tuple(labels),
    )


def _taken(feature_map: FeatureMap, sheet: FloorSheet, bodies: Sequence[FloatArray]) -> list[BaseGeometry]:
    """List what is drawn of the features, on paper."""
    import shapely  # noqa: PLC0415 - a tenth of a second of import

    gaps: tuple[Opening | UnobservedStretch, ...] = (*feature_map.openings, *feature_map.unobserved)
    circles = [
        shapely.Point(sheet.on_paper(each.center_xy)).buffer(each.radius * sheet.millimetres + _AWAY / 2)
        for each in feature_map.cylinders
    ]
    return [
        # Mitred bodies may cross themselves where walls are shorter than they are thick.
        *(shapely.convex_hull(shapely.MultiPoint(sheet.on_paper(body))) for body in bodies),
        *(shapely.LineString(sheet.on_paper(gap.endpoints_xy)) for gap in gaps),
        *circles,
        *(shapely.Point(sheet.on_paper(each.position_xy)).buffer(_AWAY) for each in feature_map.corners),
    ]


def _labels(
    feature_map: FeatureMap,
    sheet: FloorSheet,
    *,
    outward: FloatArray,
    bodies: Sequence[FloatArray],
    rooms: Sequence[Room],
) -> Iterator[Iterable[Label]]:
    """List the labels, the most important first; each with its possible places."""
    for room in rooms:
        yield _area_labels(room, sheet)
    for number, opening in enumerate(feature_map.openings):
        yield _opening_labels(opening, sheet, number=number, bodies=bodies)
    longest_first = sorted(range(len(bodies)), key=lambda number: -feature_map.walls[number].length)
    for number in longest_first:
        yield _wall_labels(sheet.on_paper(bodies[number]), outward[number], number=number)
    for number, cylinder in enumerate(feature_map.cylinders):
        yield _cylinder_labels(cylinder, sheet, number=number)


def _area_labels(room: Room, sheet: FloorSheet) -> Iterator[Label]:
    """Write the area of a room in its middle, or near it; nowhere if the text is wider than the room."""
    import shapely  # noqa: PLC0415 - as above

    about = "\N{ALMOST EQUAL TO} " if room.is_inferred else ""
    text = f"{about}{decimal(room.area, 2)} m\N{SUPERSCRIPT TWO}"
    on_paper = shapely.transform(room.polygon, sheet.on_paper)
    # The centroid of an L may lie outside of it, or in a narrow place; and what stands in a room may cover both.
    middle = np.array(on_paper.centroid.coords[0])
    left, low, right, high = on_paper.bounds
    grid = np.stack(np.meshgrid(np.linspace(left, right, _GRID), np.linspace(low, high, _GRID)), axis=-1).reshape(-1, 2)
    nearest_first = grid[np.argsort(np.hypot(*(grid - middle).T), kind="stable")]
    places = [middle, np.array(shapely.maximum_inscribed_circle(on_paper).coords[0]), *nearest_first]
    labels = (Label(kind="area", text=text, middle=each) for each in places)
    return (label for label in labels if on_paper.contains(label.footprint))


def _wall_labels(body: FloatArray, outward: FloatArray, *, number: int) -> list[Label]:
    """Write the number of a wall on the side of the robot, else behind its body, shape (4, 2)."""
    first = Label(kind="wall", text=str(number), middle=body[0])
    away = float(first.half_size[0]) + _AWAY
    faces = ((body[:2], -away * outward), (body[:1:-1], away * outward))
    places = [face[0] + share * (face[1] - face[0]) + side for face, side in faces for share in _PLACES]
    return [Label(kind="wall", text=first.text, middle=each) for each in places]


def _opening_labels(opening: Opening, sheet: FloorSheet, *, number: int, bodies: Sequence[FloatArray]) -> list[Label]:
    """Write the number and the width of an opening along it, on either side."""
    text = f"O{number} {decimal(opening.width, 2)}"
    ends, turn = sheet.on_paper(opening.endpoints_xy), label_turn(opening.endpoints_xy)
    up = directions(np.radians(turn + 90.0))
    beside = np.concatenate([ends, *(sheet.on_paper(bodies[wall]) for wall in opening.walls)])
    heights = (beside - ends[0]) @ up
    half = float(Label(kind="opening", text=text, middle=ends[0]).half_size[1]) + _AWAY
    places = [ends.mean(axis=0) + away * up for away in (heights.max() + half, heights.min() - half)]
    return [Label(kind="opening", text=text, middle=each, turn=turn) for each in places]


def _cylinder_labels(cylinder: Cylinder, sheet: FloorSheet, *, number: int) -> list[Label]:
    """Write the number and the diameter of a cylinder beside it."""
    text = f"C{number} \N{LATIN CAPITAL LETTER O WITH STROKE}{decimal(2 * cylinder.radius, 2)}"
    middle = sheet.on_paper(cylinder.center_xy)
    half = Label(kind="cylinder", text=text, middle=middle).half_size
    reach = half + cylinder.radius * sheet.millimetres + _AWAY
    ways = np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
    return [Label(kind="cylinder", text=text, middle=middle + way * reach) for way in ways]
