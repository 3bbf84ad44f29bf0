"""Floor plans to scale, as an architect draws them: walls with dimensions, rooms with areas, and a title block."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from echoplan.geometry import directions, lines_through
from echoplan.model import Corner, FeatureMap
from echoplan.viewer.floor_layout import FloorLayout, floor_layout
from echoplan.viewer.floor_marks import TEXT_SIZES, Dimension, Label
from echoplan.viewer.outline import body_pieces
from echoplan.viewer.palette import INK, MUTED
from echoplan.viewer.plan import Plan
from echoplan.viewer.style import FONT, png, printable
from echoplan.viewer.title_block import FILL, STROKES, TitleBlock, draw_foot, foot_height

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["draw_floor_plan", "floor_plan_figure", "floor_plan_pdf", "floor_plan_png"]

# Thin lines [pt]: 0.18 mm.  Ticks of dimension lines have this length [mm], and extension lines begin and end this far
# from the wall and behind the dimension line [mm].
_THIN, _TICK, _EXTENSION = 0.5, 2.0, 1.2
# A corner nearer to the end of a wall than this is the end of the wall [m].
_AT_WALL = 0.03


def floor_plan_pdf(plan: Plan, *, name: str = "Floor plan", date: str = "") -> bytes:
    """Draw a floor plan to scale on A4 or A3.

    Parameters
    ----------
    plan : Plan
        The map; nothing else of the plan is drawn, not even the true room.
    name : str, optional
        What it shows, for the title block.
    date : str, optional
        When it was made, for the title block.

    Returns
    -------
    bytes
        A PDF file of one page at a standard scale such as 1:50, where a metre is 20 mm long.  The same plan gives the
        same bytes.

    Examples
    --------
    >>> floor_plan_pdf(Plan(feature_map=FeatureMap(method="rcd")))[:5]
    b'%PDF-'
    """
    buffer = io.BytesIO()
    figure = floor_plan_figure(plan, name=name, date=date)
    figure.savefig(buffer, format="pdf", metadata={"CreationDate": None, "Title": printable(name)})
    return buffer.getvalue()


def floor_plan_png(plan: Plan, *, name: str = "Floor plan", date: str = "") -> bytes:
    """Draw a floor plan as a picture.

    Parameters
    ----------
    plan : Plan
        The map; nothing else of the plan is drawn, not even the true room.
    name : str, optional
        What it shows, for the title block.
    date : str, optional
        When it was made, for the title block.

    Returns
    -------
    bytes
        A PNG file of 200 dots an inch: printed at that size, it is to scale.  The same plan gives the same bytes.
    """
    return png(floor_plan_figure(plan, name=name, date=date))


def floor_plan_figure(plan: Plan, *, name: str, date: str) -> Figure:
    """Draw a floor plan on a figure of the size of its paper."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415 - half a second of import
    from matplotlib.figure import Figure  # noqa: PLC0415

    layout = floor_layout(plan.feature_map, foot=foot_height(plan.feature_map))
    width, height = layout.sheet.size.tolist()
    figure = Figure(figsize=(width / 25.4, height / 25.4), facecolor="white")
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set(xlim=(0.0, width), ylim=(0.0, height))
    axes.set_axis_off()
    draw_floor_plan(axes, layout, feature_map=plan.feature_map)
    block = TitleBlock(name=name, date=date, signs=tuple(_signs(plan.feature_map, layout)))
    draw_foot(axes, layout.sheet, feature_map=plan.feature_map, block=block)
    return figure


def draw_floor_plan(axes: Axes, layout: FloorLayout, *, feature_map: FeatureMap) -> None:
    """Draw what is above the title block on axes whose unit is the millimetre on paper."""
    _draw_walls(axes, layout, feature_map=feature_map)
    _draw_gaps(axes, layout, feature_map=feature_map)
    _draw_points(axes, layout, feature_map=feature_map)
    for dimension in layout.dimensions:
        _draw_dimension(axes, dimension)
    for label in layout.labels:
        _draw_label(axes, label)
    if not feature_map.walls:
        x, y = layout.sheet.window.mean(axis=0).tolist()
        axes.text(
            x,
            y,
            "No walls found",
            fontsize=14.0,
            ha="center",
            va="center",
            color=MUTED,
            fontfamily=FONT,
        )


def _draw_walls(axes: Axes, layout: FloorLayout, *, feature_map: FeatureMap) -> None:
    """Draw bodies in grey, the faces that were detected as thick lines, and those that were inferred as dashed ones.

    Backs have no line: nothing was detected there.
    """
    pieces = [body_pieces(body, wall.inferred) for wall, body in zip(feature_map.walls, layout.bodies, strict=True)]
    on_paper = layout.sheet.on_paper
    for observed, _ in pieces:
        for each in observed:
            axes.fill(*on_paper(each).T, facecolor=FILL, edgecolor=FILL, linewidth=0.2)
    for observed, inferred in pieces:
        for each in observed:
            axes.plot(*on_paper(each[:2]).T, **STROKES["wall"])
        for each in inferred:
            axes.plot(*on_paper(each[:2]).T, **STROKES["inferred"])


def _draw_gaps(axes: Axes, layout: FloorLayout, *, feature_map: FeatureMap) -> None:
    """Draw openings as jambs and the edges of their thresholds, and unobserved stretches as dots."""
    on_paper = layout.sheet.on_paper
    for stretch in feature_map.unobserved:
        axes.plot(*on_paper(stretch.endpoints_xy).T, **STROKES["unobserved"])
    for opening in feature_map.openings:
        normal = directions(lines_through(*opening.endpoints_xy)[0])
        beside = np.concatenate([opening.endpoints_xy, *(layout.bodies[wall] for wall in opening.walls)])
        depths = (beside - opening.endpoints_xy[0]) @ normal
        edges = [on_paper(opening.endpoints_xy + depth * normal) for depth in (depths.min(), depths.max())]
        for edge in edges:
            axes.plot(*edge.T, **STROKES["opening"])
        for jamb in zip(*edges, strict=True):
            axes.plot(*np.array(jamb).T, color=INK, linewidth=1.0)


def _draw_points(axes: Axes, layout: FloorLayout, *, feature_map: FeatureMap) -> None:
    """Draw cylinders as circles to scale, and corners that are at no end of a wall as crosses."""
    from matplotlib.patches import Circle  # noqa: PLC0415 - with the rest of matplotlib

    sheet = layout.sheet
    for cylinder in feature_map.cylinders:
        x, y = sheet.on_paper(cylinder.center_xy).tolist()
        axes.add_patch(
            Circle((x, y), cylinder.radius * sheet.millimetres, facecolor=FILL, edgecolor=INK, linewidth=0.8)
        )
        axes.plot([x], [y], "+", color=INK, markersize=3.0, markeredgewidth=_THIN)
    for corner in _lone_corners(feature_map):
        x, y = sheet.on_paper(corner.position_xy).tolist()
        axes.plot([x], [y], "x", color=INK, markersize=4.0, markeredgewidth=0.6)


def _draw_dimension(axes: Axes, dimension: Dimension) -> None:
    """Draw a dimension: its line with ticks at both ends, extension lines to what it measures, and its text."""
    thin: dict[str, Any] = {"color": INK, "linewidth": _THIN, "solid_capstyle": "butt"}
    axes.plot(*dimension.line.T, **thin)
    tick = _TICK / 2 * directions(np.radians(dimension.turn + 45.0))
    for end, foot in zip(dimension.line, dimension.ends, strict=True):
        axes.plot(*np.stack([end - tick, end + tick]).T, color=INK, linewidth=0.9)
        away = float(np.hypot(*(end - foot)))
        way = (end - foot) / away
        axes.plot(*np.stack([foot + min(_EXTENSION, away / 2) * way, end + _EXTENSION * way]).T, **thin)
    x, y = dimension.text_place.tolist()
    axes.text(
        x,
        y,
        dimension.text,
        fontsize=TEXT_SIZES["dimension"],
        rotation=dimension.turn,
        rotation_mode="anchor",
        ha="center",
        va="baseline",
        color=INK,
        fontfamily=FONT,
    )


def _draw_label(axes: Axes, label: Label) -> None:
    """Draw a label: the number of a wall in a circle, the area of a room in bold letters."""
    from matplotlib.patches import Circle  # noqa: PLC0415 - with the rest of matplotlib

    x, y = label.middle.tolist()
    if label.kind == "wall":
        axes.add_patch(Circle((x, y), float(label.half_size[0]), facecolor="white", edgecolor=MUTED, linewidth=_THIN))
    axes.text(
        x,
        y,
        label.text,
        fontsize=TEXT_SIZES[label.kind],
        fontweight="bold" if label.kind == "area" else "normal",
        rotation=label.turn,
        rotation_mode="anchor",
        ha="center",
        va="center_baseline",
        color=INK,
        fontfamily=FONT,
    )


def _lone_corners(feature_map: FeatureMap) -> list[Corner]:
    """List corners at which no wall ends."""
    ends = np.concatenate([np.zeros((0, 2)), *(wall.endpoints_xy for wall in feature_map.walls)])
    return [
        corner
        for corner in feature_map.corners
        if np.hypot(*(ends - corner.position_xy).T).min(initial=np.inf) > _AT_WALL
    ]


def _signs(feature_map: FeatureMap, layout: FloorLayout) -> Iterator[str]:
    """Name the signs that a drawing uses and that its legend explains."""
    texts = [dimension.text for dimension in layout.dimensions]
    is_used = {
        "wall": feature_map.walls,
        "thickness": layout.has_unknown_thickness,
        "number": any(label.kind != "area" for label in layout.labels),
        "opening": feature_map.openings,
        "inferred": any(wall.inferred.any() for wall in feature_map.walls),
        "unobserved": feature_map.unobserved,
        "cylinder": feature_map.cylinders,
        "corner": _lone_corners(feature_map),
        "brackets": any(text.startswith("(") for text in texts),
        "at least": any("\N{GREATER-THAN OR EQUAL TO}" in text for text in texts),
    }
    yield from (sign for sign, used in is_used.items() if used)
