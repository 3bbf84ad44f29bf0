"""Features, stations and detections, as elements of an SVG drawing."""

import xml.etree.ElementTree as ET

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.features import Observation
from echoplan.classical.fuzzy import class_of
from echoplan.geometry import directions
from echoplan.model import Opening, Truth, Wall
from echoplan.viewer.changes import changed_lines
from echoplan.viewer.facts import (
    Facts,
    corner_facts,
    cylinder_facts,
    opening_facts,
    station_facts,
    unobserved_facts,
    wall_facts,
)
from echoplan.viewer.markup import coordinates, element, path, size
from echoplan.viewer.outline import body_pieces, jamb_strokes, label_turn, wall_bodies
from echoplan.viewer.plan import Plan, station_labels
from echoplan.viewer.sheet import Sheet
from echoplan.viewer.uncertainty import Ellipse, wall_band
from echoplan.viewer.wording import decimal

__all__ = [
    "change_marks",
    "corner_marks",
    "cylinder_marks",
    "detection_marks",
    "echo_marks",
    "gap_marks",
    "station_marks",
    "truth_marks",
    "wall_marks",
]

# A drawing stays light however long the recording: more echoes than this are thinned out.
_MOST_ECHOES = 20_000

# Sizes on paper [mm].
_TRIANGLE = np.array([[0.0, -1.5], [1.3, 0.75], [-1.3, 0.75]])
_TICK, _STATION, _AXIS, _REACH = 1.2, 0.7, 0.4, 3.0
# Below this width an opening has no room for its label, which is written this far from it [mm].
_LABELLED, _AWAY = 13.0, 1.2


def wall_marks(plan: Plan, sheet: Sheet) -> list[ET.Element]:
    """Draw walls: the face that was observed, a body behind it, the band of its uncertainty, and inferred ends apart.

    Parameters
    ----------
    plan : Plan
        The map.
    sheet : Sheet
        Where it lies on paper.

    Returns
    -------
    list of Element
        One a wall.
    """
    walls = plan.feature_map.walls
    bodies = wall_bodies(walls, plan.feature_map.poses[:, :2], thickness=plan.thickness)
    return [
        _feature(facts, *_wall(wall, body, sheet))
        for wall, body, facts in zip(walls, bodies, wall_facts(walls), strict=True)
    ]


def gap_marks(plan: Plan, sheet: Sheet) -> list[ET.Element]:
    """Draw what lies between walls: stretches that no station observed as dots, openings as jambs and a threshold."""
    found = plan.feature_map
    bodies = wall_bodies(found.walls, found.poses[:, :2], thickness=plan.thickness)
    return [
        *(
            _feature(facts, *_line(stretch.endpoints_xy, sheet, kind="stretch"))
            for stretch, facts in zip(found.unobserved, unobserved_facts(found.unobserved), strict=True)
        ),
        *(
            _feature(
                facts,
                *_line(opening.endpoints_xy, sheet, kind="threshold"),
                element(
                    "path",
                    class_="jamb",
                    d=path(sheet.paper(jamb_strokes(opening, bodies, thickness=plan.thickness))),
                ),
                *_width(opening, sheet),
            )
            for opening, facts in zip(found.openings, opening_facts(found.openings), strict=True)
        ),
    ]


def corner_marks(plan: Plan, sheet: Sheet) -> list[ET.Element]:
    """Draw corners: filled if concave, hollow if convex, with their ellipses.

    Parameters
    ----------
    plan : Plan
        The map.
    sheet : Sheet
        Where it lies on paper.

    Returns
    -------
    list of Element
        One a corner.
    """
    corners = plan.feature_map.corners
    return [
        _feature(
            facts,
            _ellipse(ellipse, sheet),
            _fixed(
                corner.position_xy,
                sheet,
                element("path", class_=f"mark {corner.kind}", d=path([_TRIANGLE], closed=True)),
            ),
        )
        for corner, ellipse, facts in zip(corners, plan.ellipses, corner_facts(corners), strict=False)
    ]


def cylinder_marks(plan: Plan, sheet: Sheet) -> list[ET.Element]:
    """Draw cylinders, with the ellipses of their axes.

    Parameters
    ----------
    plan : Plan
        The map.
    sheet : Sheet
        Where it lies on paper.

    Returns
    -------
    list of Element
        One a cylinder.
    """
    cylinders = plan.feature_map.cylinders
    ellipses = plan.ellipses[len(plan.feature_map.corners) :]
    return [
        _feature(
            facts,
            _circle(cylinder.center_xy, cylinder.radius, sheet, kind="body"),
            _ellipse(ellipse, sheet),
            _fixed(cylinder.center_xy, sheet, element("circle", class_="axis", r=size(_AXIS))),
        )
        for cylinder, ellipse, facts in zip(cylinders, ellipses, cylinder_facts(cylinders), strict=True)
    ]


def station_marks(plan: Plan, sheet: Sheet) -> list[ET.Element]:
    """Draw the way of the robot and its stations with their letters.

    Parameters
    ----------
    plan : Plan
        The map.
    sheet : Sheet
        Where it lies on paper.

    Returns
    -------
    list of Element
        The way, then one a station.
    """
    found = plan.feature_map
    spreads = [[_ellipse(each, sheet)] for each in plan.pose_ellipses] or [[] for _ in found.sweeps]
    labels = station_labels(found.sweeps, found.poses[:, :2])
    stations = zip(found.poses[:, :2], found.sweeps.tolist(), labels, station_facts(found), spreads, strict=True)
    return [
        element("path", class_="way", d=path(map(sheet.paper, found.paths_xy))),
        *(
            _feature(
                facts,
                *spread,
                _fixed(
                    position,
                    sheet,
                    element("circle", class_="mark", r=size(_STATION)),
                    element("text", text=label, class_="label", x=size(_STATION), y=size(-_STATION)),
                ),
                sweep=str(sweep),
            )
            for position, sweep, label, facts, spread in stations
        ),
    ]


def detection_marks(plan: Plan, sheet: Sheet) -> list[ET.Element]:
    """Draw the detections of single sweeps: a beam from the hub to each object, and a stroke along its face.

    Parameters
    ----------
    plan : Plan
        With the detections.
    sheet : Sheet
        Where it lies on paper.

    Returns
    -------
    list of Element
        One an observation.
    """
    return [
        element(
            "path",
            class_=f"beam {class_of(each.degrees)}",
            data_sweep=str(each.sweep),
            d=path([sheet.paper(np.stack([each.point.hub_xy, each.point.position_xy])), _stroke(each, sheet)]),
        )
        for each in plan.detections
    ]


def echo_marks(plan: Plan, sheet: Sheet) -> list[ET.Element]:
    """Draw echoes as dots.

    Parameters
    ----------
    plan : Plan
        The echoes.
    sheet : Sheet
        Where they lie on paper.

    Returns
    -------
    list of Element
        One path whose strokes are points.
    """
    points = sheet.paper(plan.echoes_xy[:: -(-len(plan.echoes_xy) // _MOST_ECHOES) or 1])
    return [element("path", class_="dots", d="".join(f"M{coordinates(point)}h0" for point in points))]


def truth_marks(truth: Truth, sheet: Sheet) -> list[ET.Element]:
    """Draw the room as it is.

    Parameters
    ----------
    truth : Truth
        The room.
    sheet : Sheet
        Where it lies on paper.

    Returns
    -------
    list of Element
        The walls as one path, then one circle a cylinder.
    """
    return [
        element("path", class_="true", d=path(sheet.paper(truth.walls_xy))),
        *(_circle(circle[:2], float(circle[2]), sheet, kind="true") for circle in truth.cylinders),
    ]


def change_marks(plan: Plan, sheet: Sheet) -> list[ET.Element]:
    """Draw what is gone since earlier recordings as dashed lines, and mark what is new."""
    gone, new = changed_lines(plan.feature_map.changes)
    return [
        element("path", element("title", text=kind), class_=kind, d=path(sheet.paper(line) for line in lines))
        for kind, lines in (("gone", gone), ("new", new))
        if lines
    ]


def _feature(facts: Facts, *parts: ET.Element, **data: str) -> ET.Element:
    """Group what belongs to one thing, with all there is to know of it in its title."""
    attributes = {"id": facts.key, "class": f"feature {facts.kind}", "tabindex": "0", "role": "img"}
    data = {f"data_{name}": value for name, value in data.items()}
    return element("g", element("title", text=facts.text), *parts, **attributes, **data)


def _wall(wall: Wall, body: FloatArray, sheet: Sheet) -> list[ET.Element]:
    observed, inferred = body_pieces(body, wall.inferred)
    return [
        *(element("path", class_="body", d=path([sheet.paper(each)], closed=True)) for each in observed),
        *(element("path", class_="body inferred", d=path([sheet.paper(each)], closed=True)) for each in inferred),
        _band(wall, sheet),
        *(element("path", class_="face", d=path([sheet.paper(each[:2])])) for each in observed),
        *(element("path", class_="face inferred", d=path([sheet.paper(each[:2])])) for each in inferred),
    ]


def _line(ends_xy: FloatArray, sheet: Sheet, *, kind: str) -> list[ET.Element]:
    """Draw a thin line, and around it what a pointer can hit."""
    drawn = path([sheet.paper(ends_xy)])
    return [element("path", class_="grip", d=drawn), element("path", class_=kind, d=drawn)]


def _width(opening: Opening, sheet: Sheet) -> list[ET.Element]:
    """Write the width of an opening that was driven through along it, if there is room."""
    start, end = sheet.paper(opening.endpoints_xy)
    if not opening.passed or np.hypot(*(end - start)) < _LABELLED:
        return []
    words = f"{decimal(opening.width, 2)} m"
    label = element("text", text=words, class_="width", text_anchor="middle", y=size(-_AWAY))
    turn = size(-label_turn(opening.endpoints_xy))
    place = f"translate({coordinates((start + end) / 2)}) rotate({turn})"
    return [element("g", element("g", label, class_="fixed"), transform=place)]


def _fixed(point_xy: FloatArray, sheet: Sheet, *parts: ET.Element) -> ET.Element:
    """Place what has a size of its own, whatever the scale of the map; with a margin for fingers."""
    reach = element("circle", class_="reach", r=size(_REACH))
    own = element("g", reach, *parts, class_="fixed")
    return element("g", own, transform=f"translate({coordinates(sheet.paper(point_xy))})")


def _ellipse(ellipse: Ellipse, sheet: Sheet) -> ET.Element:
    rx, ry = (size(each) for each in sheet.millimetres * ellipse.semi_axes)
    # On paper y points down, so angles turn the other way.
    turn = f"rotate({size(-float(np.degrees(ellipse.angle)))})"
    place = f"translate({coordinates(sheet.paper(ellipse.center_xy))}) {turn}"
    return element("g", element("ellipse", class_="ellipse", rx=rx, ry=ry), transform=place)


def _band(wall: Wall, sheet: Sheet) -> ET.Element:
    start, end = sheet.paper(wall.endpoints_xy)
    along, half = sheet.millimetres * wall_band(wall).T
    outline = np.concatenate([np.stack([along, half], axis=-1), np.stack([along, -half], axis=-1)[::-1]])
    turn = float(np.degrees(np.arctan2(*(end - start)[::-1])))
    place = f"translate({coordinates(start)}) rotate({size(turn)})"
    return element("g", element("path", class_="band", d=path([outline], closed=True)), transform=place)


def _circle(center_xy: FloatArray, radius: float, sheet: Sheet, *, kind: str) -> ET.Element:
    x, y = (size(each) for each in sheet.paper(center_xy))
    return element("circle", class_=kind, cx=x, cy=y, r=size(sheet.millimetres * radius))


def _stroke(observation: Observation, sheet: Sheet) -> FloatArray:
    across = directions(observation.point.bearing + np.pi / 2) / sheet.millimetres * _TICK
    return sheet.paper(observation.point.position_xy + np.stack([-across, across]))
