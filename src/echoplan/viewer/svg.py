"""A map as SVG: a drawing to scale that opens in a browser or in Inkscape."""

import xml.etree.ElementTree as ET
from importlib.resources import files

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray
from echoplan.viewer.marks import (
    change_marks,
    corner_marks,
    cylinder_marks,
    detection_marks,
    echo_marks,
    gap_marks,
    station_marks,
    truth_marks,
    wall_marks,
)
from echoplan.viewer.markup import coordinates, element, path, size
from echoplan.viewer.plan import Plan
from echoplan.viewer.quality import warning_of
from echoplan.viewer.sheet import Sheet

__all__ = ["plan_element", "plan_svg"]

_NAMESPACE = "http://www.w3.org/2000/svg"

# Sizes on paper [mm].
_MARGIN, _LEGEND, _ARROW = 10.0, 16.0, 6.0

# Below this width the legend would not fit [mm].
_NARROWEST = 110.0

# The axes of the map as directions on paper.
_AXES = {"x": (1.0, 0.0), "y": (0.0, -1.0)}


def plan_svg(plan: Plan) -> str:
    """Draw a map as a file of its own.

    Parameters
    ----------
    plan : Plan
        The map and what lies beneath it.

    Returns
    -------
    str
        An SVG document of the size of the drawing: printed as it is, it is to scale.
    """
    drawing = plan_element(plan)
    width, height = _sheet(plan).size
    css = files("echoplan.viewer").joinpath("map.css").read_text(encoding="utf-8")
    drawing.insert(1, element("style", text=css))
    drawing.attrib |= {"xmlns": _NAMESPACE, "width": f"{size(width)}mm", "height": f"{size(height)}mm"}
    ET.indent(drawing)
    return ET.tostring(drawing, encoding="unicode") + "\n"


def plan_element(plan: Plan) -> ET.Element:
    """Draw a map as part of a page.

    Parameters
    ----------
    plan : Plan
        The map and what lies beneath it.

    Returns
    -------
    Element
        An ``svg`` with a group for each layer; every feature has an id such as ``wall-0`` and all that is
        known of it in its title.  Its unit is a millimetre on paper; ``data-scale`` says how many it stands for, and
        ``data-origin`` where the origin of the map lies.
    """
    sheet = _sheet(plan)
    title, legend = f"Map made by {plan.feature_map.method}", _legend(sheet)
    # A map that is not good says so, in its title and above the drawing.
    if warning := warning_of(plan.feature_map.quality):
        title = f"{title}. {warning}"
        legend.append(element("text", text=warning, class_="warning", x=size(_MARGIN), y=size(_MARGIN / 2)))
    layers = {
        "grid": _grid(sheet),
        "echoes": [_window(sheet, echo_marks(plan, sheet))],
        "detections": [_window(sheet, detection_marks(plan, sheet))],
        "walls": wall_marks(plan, sheet),
        "gaps": gap_marks(plan, sheet),
        "changes": change_marks(plan, sheet),
        "truth": truth_marks(plan.truth, sheet) if plan.truth else [],
        "cylinders": cylinder_marks(plan, sheet),
        "corners": corner_marks(plan, sheet),
        "stations": station_marks(plan, sheet),
        "legend": legend,
    }
    width, height = (size(each) for each in sheet.size)
    return element(
        "svg",
        element("title", text=title),
        element("rect", class_="paper", width=width, height=height),
        *(element("g", *marks, class_=name) for name, marks in layers.items()),
        class_="map",
        viewBox=f"0 0 {width} {height}",
        data_scale=f"{sheet.scale:g}",
        data_origin=coordinates(sheet.paper([0.0, 0.0])),
    )


def _sheet(plan: Plan) -> Sheet:
    """Lay a map on paper, in the middle of what its legend needs."""
    sheet = Sheet(bounds_xy=plan.bounds_xy)
    short = max(_NARROWEST - float(sheet.size[0]), 0.0) / 2 / sheet.millimetres
    return Sheet(bounds_xy=sheet.bounds_xy + np.array([[-short, 0.0], [short, 0.0]]))


def _grid(sheet: Sheet) -> list[ET.Element]:
    """Lines at whole multiples of a round length, with their coordinates at the lower and the left edge."""
    xs, ys = sheet.lines
    (left, low), (right, high) = sheet.bounds_xy
    upright = [[[x, low], [x, high]] for x in xs]
    level = [[[left, y], [right, y]] for y in ys]
    strokes = sheet.paper(np.array([*upright, *level]).reshape(-1, 2, 2))
    return [
        element("path", class_="line", d=path(strokes)),
        *(_text(f"{x:z.6g}", sheet.paper([x, low]), shift=(0.0, 6.0), anchor="middle") for x in xs),
        *(_text(f"{y:z.6g}", sheet.paper([left, y]), shift=(-4.0, 1.0), anchor="end") for y in ys),
    ]


def _window(sheet: Sheet, marks: list[ET.Element]) -> ET.Element:
    """Cut off what lies beyond the drawing: false echoes may be anywhere."""
    width, height = sheet.size.tolist()
    frame = {"width": size(width), "height": size(height - _LEGEND)}
    return element("svg", *marks, overflow="hidden", viewBox=f"0 0 {frame['width']} {frame['height']}", **frame)


def _legend(sheet: Sheet) -> list[ET.Element]:
    """Scale bar, scale and the directions of the axes, below the drawing."""
    width, height = sheet.size.tolist()
    left, base = _MARGIN, height - _MARGIN / 2
    bar = sheet.millimetres * sheet.grid
    tail = np.array([width - _MARGIN - _ARROW, base])
    axes = [stroke for direction in _AXES.values() for stroke in _arrow(tail, np.array(direction))]
    return [
        element("path", class_="bar", d=path([[[left, base], [left + bar, base]]])),
        element("path", class_="bar half", d=path([[[left + bar / 2, base], [left + bar, base]]])),
        _text(f"{sheet.grid:g} m", [left + bar, base], shift=(2.0, 1.0)),
        _text(f"1 : {sheet.scale:g}", [left + bar, base], shift=(16.0, 1.0)),
        element("path", class_="axes", d=path(axes)),
        *(
            _text(name, tail + 1.4 * _ARROW * np.array(way), shift=(0.0, 1.0), anchor="middle")
            for name, way in _AXES.items()
        ),
    ]


def _arrow(tail: FloatArray, direction: FloatArray) -> list[FloatArray]:
    tip, side = tail + _ARROW * direction, direction[::-1]
    back = tip - 1.6 * direction
    return [np.stack([tail, tip]), np.stack([back + 0.8 * side, tip, back - 0.8 * side])]


def _text(text: str, place: ArrayLike, *, shift: tuple[float, float], anchor: str = "start") -> ET.Element:
    x, y = (size(each) for each in np.add(place, shift))
    return element("text", text=text, x=x, y=y, text_anchor=anchor)
