"""Pictures of maps (Figure 13 of the paper): walls, corners, cylinders, stations and their uncertainty."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.model import (
    Corner,
    CornerKind,
    Cylinder,
    FeatureClass,
    FeatureMap,
    Opening,
    Truth,
    UnobservedStretch,
    Wall,
)
from echoplan.viewer.changes import draw_changes
from echoplan.viewer.outline import body_pieces, jamb_strokes, label_turn, wall_bodies
from echoplan.viewer.palette import COLORS, INK, MARKERS, MUTED, TRUTH
from echoplan.viewer.plan import Plan, station_labels
from echoplan.viewer.quality import warning_of
from echoplan.viewer.style import add_legend, dress_map
from echoplan.viewer.uncertainty import Ellipse
from echoplan.viewer.wording import decimal

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.path import Path

__all__ = [
    "draw_corners",
    "draw_cylinders",
    "draw_ellipses",
    "draw_openings",
    "draw_plan",
    "draw_stations",
    "draw_truth",
    "draw_unobserved",
    "draw_walls",
    "draw_widths",
]

# An opening narrower than this many thicknesses of a wall has no room for the label of its width.
_LABELLED = 6.0


def draw_plan(axes: Axes, plan: Plan) -> None:
    """Draw a whole map, over the true room where that is known (Figure 13).

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    plan : Plan
        The map and the truth.
    """
    found = plan.feature_map
    draw_walls(axes, found.walls, found.poses[:, :2], thickness=plan.thickness)
    draw_unobserved(axes, found.unobserved)
    draw_openings(axes, found, thickness=plan.thickness)
    draw_widths(axes, found.openings, thickness=plan.thickness)
    draw_cylinders(axes, found.cylinders)
    draw_changes(axes, found.changes)
    if plan.truth is not None:
        draw_truth(axes, plan.truth)
    draw_stations(axes, found)
    draw_ellipses(axes, plan.ellipses, magnification=plan.magnification)
    draw_corners(axes, found.corners)
    if warning := warning_of(found.quality):
        axes.set_title(warning, color=COLORS[FeatureClass.CORNER], fontsize=8.5, loc="left")
    dress_map(axes)
    add_legend(axes, columns=4, where="above")


def draw_truth(axes: Axes, truth: Truth) -> None:
    """Draw the room as it is.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    truth : Truth
        The room.
    """
    around = directions(np.linspace(0.0, 2 * np.pi, 73))
    circles = [xy + radius * around for *xy, radius in truth.cylinders]
    for number, points in enumerate([*truth.walls_xy, *circles]):
        label = "true room" if number == 0 else None
        axes.plot(*points.T, color=TRUTH, linewidth=0.9, linestyle=(0, (4, 2)), label=label)


def draw_walls(axes: Axes, walls: Sequence[Wall], stations_xy: FloatArray, *, thickness: float) -> None:
    """Draw walls with a body behind their faces; their inferred ends as dashed lines.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    walls : sequence of Wall
        The walls.
    stations_xy : ndarray, shape (s, 2)
        Positions from which they were detected [m].
    thickness : float
        How thick to draw them [m].
    """
    color = COLORS[FeatureClass.WALL]
    bodies = wall_bodies(walls, stations_xy, thickness=thickness)
    pieces = [body_pieces(body, wall.inferred) for wall, body in zip(walls, bodies, strict=True)]
    filled = [axes.fill(*each.T, color=color, linewidth=0.6) for observed, _ in pieces for each in observed]
    # Face and back of a piece are two lines.
    dashed = [
        axes.plot(*each.reshape(2, 2, 2).T, color=color, linewidth=0.8, linestyle=(0, (3, 2)))
        for _, inferred in pieces
        for each in inferred
    ]
    for drawn, label in ((filled, "wall"), (dashed, "inferred wall end")):
        if drawn:
            drawn[0][0].set_label(label)


def draw_unobserved(axes: Axes, unobserved: Sequence[UnobservedStretch]) -> None:
    """Draw stretches that no station observed, as dots."""
    for number, stretch in enumerate(unobserved):
        axes.plot(
            *stretch.endpoints_xy.T,
            color=COLORS[FeatureClass.WALL],
            linewidth=1.6,
            linestyle=(0, (0.01, 2)),
            dash_capstyle="round",
            label="unobserved" if number == 0 else None,
        )


def draw_openings(axes: Axes, feature_map: FeatureMap, *, thickness: float) -> None:
    """Draw the openings of a map: jambs at both ends and a threshold between; walls are as thick as given [m]."""
    color = COLORS[FeatureClass.WALL]
    bodies = wall_bodies(feature_map.walls, feature_map.poses[:, :2], thickness=thickness)
    for opening in feature_map.openings:
        axes.plot(*opening.endpoints_xy.T, color=color, linewidth=0.4, alpha=0.7)
        for jamb in jamb_strokes(opening, bodies, thickness=thickness):
            axes.plot(*jamb.T, color=color, linewidth=1.0)
    if feature_map.openings:
        axes.plot(
            [], [], linestyle="none", marker=_opening_marker(), markersize=14, mec=color, mew=0.8, label="opening"
        )


def _opening_marker() -> Path:
    """Make an opening for the legend: two jambs and the threshold between them."""
    from matplotlib.path import Path  # noqa: PLC0415 - with the rest of matplotlib

    strokes = [(-1.0, -0.35), (-1.0, 0.35), (-1.0, 0.0), (1.0, 0.0), (1.0, -0.35), (1.0, 0.35)]
    return Path(strokes, [Path.MOVETO, Path.LINETO] * 3)


def draw_widths(axes: Axes, openings: Sequence[Opening], *, thickness: float) -> None:
    """Write the widths of openings that were driven through along them, where there is room beside walls so thick."""
    for opening in openings:
        if opening.passed and opening.width >= _LABELLED * thickness:
            turn = label_turn(opening.endpoints_xy)
            away = 5.0 * directions(np.radians(turn + 90.0))
            axes.annotate(
                f"{decimal(opening.width, 2)} m",
                tuple(opening.endpoints_xy.mean(axis=0)),
                xytext=tuple(away),
                textcoords="offset points",
                ha="center",
                va="center",
                rotation=turn,
                fontsize=6.5,
                color=INK,
                bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4},
            )


def draw_corners(axes: Axes, corners: Sequence[Corner]) -> None:
    """Draw corners: filled if concave, hollow if convex.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    corners : sequence of Corner
        The corners.
    """
    color = COLORS[FeatureClass.CORNER]
    for kind in CornerKind:
        points = [each.position_xy for each in corners if each.kind is kind]
        if points:
            axes.plot(
                *np.array(points).T,
                MARKERS[FeatureClass.CORNER],
                markersize=5,
                color=color,
                mfc=color if kind is CornerKind.CONCAVE else "white",
                label=f"{kind} corner",
            )


def draw_cylinders(axes: Axes, cylinders: Sequence[Cylinder]) -> None:
    """Draw cylinders.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    cylinders : sequence of Cylinder
        The cylinders.
    """
    from matplotlib.patches import Circle  # noqa: PLC0415 - with the rest of matplotlib

    color = COLORS[FeatureClass.CYLINDER]
    for each in cylinders:
        x, y = each.center_xy.tolist()
        axes.add_patch(Circle((x, y), each.radius, color=color, linewidth=0))
    if cylinders:
        axes.plot([], [], "o", markersize=6, color=color, label="cylinder")


def draw_stations(axes: Axes, feature_map: FeatureMap) -> None:
    """Draw the stations in their order, with their letters.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    feature_map : FeatureMap
        A map with its poses.
    """
    points = feature_map.poses[:, :2]
    for path_xy in feature_map.paths_xy:
        axes.plot(*path_xy.T, ":", color=MUTED, linewidth=0.7)
    axes.plot(*points.T, "o", color=MUTED, markersize=2.5, label="station" if len(points) else None)
    for name, point in zip(station_labels(feature_map.sweeps, feature_map.poses[:, :2]), points, strict=True):
        if name:
            axes.annotate(name, tuple(point), xytext=(3, 3), textcoords="offset points", fontsize=7.5, color=INK)


def draw_ellipses(axes: Axes, ellipses: Sequence[Ellipse], *, magnification: float = 1.0) -> None:
    """Draw ellipses of 95 % probability.

    Parameters
    ----------
    axes : matplotlib.axes.Axes
        Where to draw.
    ellipses : sequence of Ellipse
        The ellipses.
    magnification : float, optional
        How many times greater to draw them.
    """
    from matplotlib.patches import Ellipse as Patch  # noqa: PLC0415 - with the rest of matplotlib

    for each in ellipses:
        x, y = each.center_xy.tolist()
        width, height = (2 * magnification * each.semi_axes).tolist()
        outline = Patch((x, y), width, height, angle=float(np.degrees(each.angle)), fill=False, linewidth=0.9)
        outline.set_edgecolor(COLORS[FeatureClass.CORNER])
        axes.add_patch(outline)
    name = "95 % ellipse" if magnification == 1.0 else f"95 % ellipse, enlarged {magnification:g} times"
    if ellipses:
        axes.plot([], [], "o", markersize=7, mfc="none", mec=COLORS[FeatureClass.CORNER], mew=0.9, label=name)
