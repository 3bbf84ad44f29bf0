"""Maps as DXF, for CAD programs: one layer a kind of feature, in metres, with dimensions."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.errors import MissingExtraError
from echoplan.geometry import outward_normals
from echoplan.io.files import by_name, write_bytes
from echoplan.model import FeatureMap, Opening, UnobservedStretch, Verdict, Wall

if TYPE_CHECKING:
    from ezdxf.document import Drawing
    from ezdxf.layouts.layout import Modelspace

__all__ = ["dxf_bytes", "write_dxf"]

# Name, AutoCAD colour and linetype of the layers; 7 is black on white paper.
_LAYERS = (
    ("WALLS", 7, "CONTINUOUS"),
    ("OPENINGS", 5, "CONTINUOUS"),
    ("UNOBSERVED", 8, "DOT"),
    ("CORNERS", 1, "CONTINUOUS"),
    ("CYLINDERS", 3, "CONTINUOUS"),
    ("DIMENSIONS", 8, "CONTINUOUS"),
    ("NOTES", 1, "CONTINUOUS"),
)
# Code of the unit metre (DXF reference, header variable $INSUNITS).
_METRES = 6
# Code of a cross (DXF reference, header variable $PDMODE): a single dot would be lost among the lines.
_CROSS = 3

# Sizes of text, arrows and dashes are those of a print on A4 [m on paper], of which the drawing takes this width.
_PAPER, _TEXT, _ARROW, _DASH, _GAP = 0.18, 0.0025, 0.002, 0.003, 0.0015
# Dimension lines run this far outside their walls [m on paper], and a shorter wall than this many heights of its text
# has none: four digits and two arrows would not fit.
_OUTSIDE, _SHORTEST = 0.008, 5.0
# Text that would fall more steeply than this runs upwards instead [rad]: all walls that are upright but for their
# uncertainty are read from the right.
_STEEPEST = np.radians(80.0)


@by_name
def write_dxf(path: Path, feature_map: FeatureMap) -> None:
    """Write a map as a drawing for CAD programs (DXF R2010).

    Parameters
    ----------
    path : Path or str
        The file.
    feature_map : FeatureMap
        The map.  Walls become lines of the faces that were detected, cylinders circles, corners points; walls and
        openings have aligned dimensions on their outer side.

    Raises
    ------
    MissingExtraError
        If ezdxf is not installed (extra ``cad``).
    OutputError
        If the file cannot be written.

    Notes
    -----
    The same map gives the same bytes.
    """
    write_bytes(path, dxf_bytes(lambda document: _draw(document, feature_map), units=_METRES))


def dxf_bytes(draw: Callable[[Drawing], None], *, units: int) -> bytes:
    """Return what a function draws in a new document (DXF R2010); the same drawing gives the same bytes.

    Raises ``MissingExtraError`` if ezdxf is not installed.
    """
    try:
        from ezdxf._options import options  # noqa: PLC0415 - an extra; its public name has no type
        from ezdxf.filemanagement import new  # noqa: PLC0415
    except ModuleNotFoundError as error:
        raise MissingExtraError("ezdxf", extra="cad") from error
    before = options.write_fixed_meta_data_for_testing
    # Constants instead of dates and random identifiers.
    options.write_fixed_meta_data_for_testing = True
    try:
        document = new("R2010", units=units)
        draw(document)
        # ezdxf would list the classes in the order of a set, which differs from process to process.
        for name in sorted(document.entitydb.dxf_types_in_use()):
            document.classes.add_class(name)
        stream = io.StringIO()
        document.write(stream)
        return document.encode(stream.getvalue())
    finally:
        options.write_fixed_meta_data_for_testing = before


def _bounds(feature_map: FeatureMap) -> tuple[FloatArray, FloatArray]:
    """Lower left and upper right corner of all features [m]; a metre at least each way."""
    circles = np.array([[*each.center_xy, each.radius] for each in feature_map.cylinders]).reshape(-1, 3)
    long: tuple[Wall | Opening | UnobservedStretch, ...] = (
        *feature_map.walls,
        *feature_map.openings,
        *feature_map.unobserved,
    )
    points = np.concatenate(
        [
            *(each.endpoints_xy for each in long),
            *(corner.position_xy[None] for corner in feature_map.corners),
            circles[:, :2] - circles[:, 2:],
            circles[:, :2] + circles[:, 2:],
        ]
    )
    points = points if len(points) else np.zeros((1, 2))
    low, high = points.min(axis=0), points.max(axis=0)
    short = np.maximum(1.0 - (high - low), 0.0) / 2
    return low - short, high + short


def _draw(document: Drawing, feature_map: FeatureMap) -> None:
    """Draw a map; what its coordinates do not say is as large as in a print on A4."""
    low, high = _bounds(feature_map)
    # Metres in the room for a metre on paper.
    scale = float((high - low).max()) / _PAPER
    _set_up(document, scale=scale)
    space = document.modelspace()
    _draw_features(space, feature_map)
    layer = {"layer": "DIMENSIONS"}
    for start, end, is_left, text in _dimensions(feature_map, shortest=_SHORTEST * _TEXT * scale):
        away = _OUTSIDE * scale if is_left else -_OUTSIDE * scale
        space.add_aligned_dim(start, end, away, text=text, dimstyle="ECHOPLAN", dxfattribs=layer).render()
    quality = feature_map.quality
    if quality is not None and quality.verdict is not Verdict.GOOD:
        note = space.add_text(f"echoplan: {quality.verdict} map", height=2 * _TEXT * scale)
        note.dxf.layer = "NOTES"
        note.set_placement((float(low[0]), float(high[1]) + 2 * _OUTSIDE * scale))
    margin = 3 * _OUTSIDE * scale
    space.reset_extents((*(low - margin).tolist(), 0.0), (*(high + margin).tolist(), 0.0))
    center = ((low + high) / 2).tolist()
    document.set_modelspace_vport(float((high - low).max()) + 2 * margin, center=(center[0], center[1]))


def _set_up(document: Drawing, *, scale: float) -> None:
    """Define layers, linetypes and the style of the dimensions."""
    dash, gap = _DASH * scale, _GAP * scale
    document.linetypes.add("DASHED", [dash + gap, dash, -gap], description="inferred __ __ __")
    document.linetypes.add("DOT", [gap, 0.0, -gap], description="unobserved . . . .")
    for name, color, linetype in _LAYERS:
        document.layers.add(name, color=color, linetype=linetype)
    document.header["$PDMODE"] = _CROSS
    document.header["$PDSIZE"] = _ARROW * scale
    style = document.dimstyles.new("ECHOPLAN")
    for name, value in {
        # Text above the line, centred; metres with two decimals and a point; ticks as in architecture.
        "dimtad": 1,
        "dimlunit": 2,
        "dimdec": 2,
        "dimzin": 0,
        "dimdsep": ord("."),
        "dimtxt": _TEXT * scale,
        "dimtsz": _ARROW * scale / 2,
        "dimasz": _ARROW * scale,
        "dimgap": _TEXT * scale / 4,
        "dimexo": _ARROW * scale / 2,
        "dimexe": _ARROW * scale / 2,
    }.items():
        style.dxf.set(name, value)


def _draw_features(space: Modelspace, feature_map: FeatureMap) -> None:
    """Draw every feature on its layer."""
    for wall in feature_map.walls:
        for piece, linetype in _pieces(wall):
            space.add_line(piece[0].tolist(), piece[1].tolist(), dxfattribs={"layer": "WALLS", "linetype": linetype})
    layers: dict[str, tuple[Opening | UnobservedStretch, ...]] = {
        "OPENINGS": feature_map.openings,
        "UNOBSERVED": feature_map.unobserved,
    }
    for layer, gaps in layers.items():
        for gap in gaps:
            start, end = gap.endpoints_xy.tolist()
            space.add_line(start, end, dxfattribs={"layer": layer})
    for corner in feature_map.corners:
        space.add_point(corner.position_xy.tolist(), dxfattribs={"layer": "CORNERS"})
    for cylinder in feature_map.cylinders:
        # CAD programs refuse circles without a radius.
        if cylinder.radius > 0.0:
            space.add_circle(cylinder.center_xy.tolist(), cylinder.radius, dxfattribs={"layer": "CYLINDERS"})
        else:
            space.add_point(cylinder.center_xy.tolist(), dxfattribs={"layer": "CYLINDERS"})


def _pieces(wall: Wall) -> Iterator[tuple[FloatArray, str]]:
    """Cut a wall where its inferred ends begin: ends of each piece, and its linetype."""
    first, last = np.array([0.0, wall.length]) + [1.0, -1.0] * wall.inferred
    first = float(np.clip(first, 0.0, wall.length))
    cuts = [0.0, first, float(np.clip(last, first, wall.length)), wall.length]
    way = (wall.endpoints_xy[1] - wall.endpoints_xy[0]) / wall.length
    for (near, far), linetype in zip(pairwise(cuts), ("DASHED", "BYLAYER", "DASHED"), strict=True):
        if far > near:
            piece = wall.endpoints_xy[0] + np.array([near, far])[:, None] * way
            # The ends of the wall themselves, to the last bit.
            piece[0] = wall.endpoints_xy[0] if near == 0.0 else piece[0]
            piece[1] = wall.endpoints_xy[1] if far == wall.length else piece[1]
            yield piece, linetype


def _dimensions(feature_map: FeatureMap, *, shortest: float) -> Iterator[tuple[list[float], list[float], bool, str]]:
    """List the dimensions of walls and openings that are long enough: ends, whether it lies to their left, and text."""
    walls, openings = feature_map.walls, feature_map.openings
    sides: tuple[Wall | Opening, ...] = (*walls, *openings)
    faces = [each.endpoints_xy for each in sides]
    normals = np.array([wall.normal_xy for wall in walls])
    outward = outward_normals(np.array(faces[: len(walls)]), feature_map.poses[:, :2], normals_xy=normals)
    # An opening has its dimension beside those of the wall that it interrupts.
    beside = [outward[each.walls[0]] if each.walls else np.zeros(2) for each in openings]
    for face, normal, text in zip(faces, [*outward, *beside], _lengths(feature_map), strict=True):
        along = face[1] - face[0]
        if np.hypot(*along) < shortest:
            continue
        # Text runs from the first end to the second and is read from below or from the right of the drawing.
        turn = 1 if (np.arctan2(along[1], along[0]) + _STEEPEST) % (2 * np.pi) < np.pi else -1
        first, second = face[::turn].tolist()
        yield first, second, bool(turn * (normal[1] * along[0] - normal[0] * along[1]) >= 0.0), text


def _lengths(feature_map: FeatureMap) -> Iterator[str]:
    """Yield the texts of dimensions of walls and then openings, as on the floor plan.

    Lengths that were partly inferred stand in brackets, and those of which an end was not observed are the least.
    """
    for wall, unobserved in zip(feature_map.walls, feature_map.unobserved_ends, strict=True):
        text = "\N{GREATER-THAN OR EQUAL TO} <>" if unobserved.any() else "<>"
        yield f"({text})" if wall.inferred.any() else text
    yield from ["<>"] * len(feature_map.openings)
