"""Markers of a map for RViz and Foxglove. Namespaces can be hidden separately; numbers are those of ``map.json``."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.io.ros.map_messages import Types, header, point, pose_message, vector
from echoplan.model import Corner, Cylinder, FeatureMap, Wall

__all__ = ["marker_array"]

# Red, green, blue, opacity; visible on the dark background of RViz and the light one of Foxglove.
_BLUE, _GREEN, _GREY = (0.25, 0.55, 0.9, 1.0), (0.2, 0.7, 0.35, 1.0), (0.55, 0.55, 0.55, 1.0)
_ORANGE, _TEAL = (0.9, 0.45, 0.15, 1.0), (0.15, 0.65, 0.6, 1.0)
_FAINT = 0.35
# Line widths, point diameters, text heights and the height of flat markers [m].
_LINE, _DOT, _TEXT, _FLAT = 0.03, 0.06, 0.12, 0.01
# RViz refuses a marker without extent [m].
_THINNEST = 1e-3
# Root of the quantile of a chi-squared variable of two degrees of freedom: semi-axes of the 95 % ellipse by sigma.
_ELLIPSE_95 = math.sqrt(-2.0 * math.log(0.05))


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Shape:
    """A marker without its header: ``kind`` is a constant of visualization_msgs/Marker."""

    namespace: str
    number: int
    kind: str
    scale: tuple[float, float, float]
    color: tuple[float, float, float, float]
    pose: FloatArray = field(default_factory=lambda: np.zeros(3))
    points_xy: FloatArray = field(default_factory=lambda: np.zeros((0, 2)))
    text: str = ""


def marker_array(types: Types, feature_map: FeatureMap, *, stamp: int, replaces: bool = False) -> Any:
    """Make the markers of a map; they may replace all those that were published before."""
    markers = [_marker(types, shape, frame=feature_map.frame, stamp=stamp) for shape in _shapes(feature_map)]
    if replaces:
        shape = _Shape(namespace="", number=0, kind="CUBE", scale=(_DOT, _DOT, _DOT), color=_GREY)
        first = _marker(types, shape, frame=feature_map.frame, stamp=stamp)
        markers.insert(0, replace(first, action=first.DELETEALL))
    return types["visualization_msgs/msg/MarkerArray"](markers=markers)


def _shapes(feature_map: FeatureMap) -> Iterator[_Shape]:
    """List what is drawn, namespace by namespace."""
    for number, wall in enumerate(feature_map.walls):
        yield from _wall(wall, number)
    for number, opening in enumerate(feature_map.openings):
        yield _lines("openings", number, points_xy=opening.endpoints_xy, color=_GREEN)
        yield _label("opening", number, position_xy=opening.endpoints_xy.mean(axis=0))
    for number, stretch in enumerate(feature_map.unobserved):
        yield _lines("unobserved", number, points_xy=stretch.endpoints_xy, color=(*_GREY[:3], _FAINT))
    for number, corner in enumerate(feature_map.corners):
        yield from _corner(corner, number)
    for number, cylinder in enumerate(feature_map.cylinders):
        yield from _cylinder(cylinder, number)


def _wall(wall: Wall, number: int) -> Iterator[_Shape]:
    start, end = wall.endpoints_xy
    along = (end - start) / wall.length
    # If inferred pieces overlap, no detected piece is left between them.
    first = min(float(wall.inferred[0]), wall.length)
    last = max(wall.length - float(wall.inferred[1]), first)
    marks = start + np.array([[0.0], [first], [last], [wall.length]]) * along
    if last > first:
        yield _lines("walls", number, points_xy=marks[1:3], color=_BLUE)
    inferred = np.concatenate([marks[:2] if first > 0.0 else marks[:0], marks[2:] if last < wall.length else marks[:0]])
    if len(inferred):
        yield _lines("inferred", number, points_xy=inferred, color=(*_BLUE[:3], _FAINT))
    yield _label("wall", number, position_xy=wall.endpoints_xy.mean(axis=0))


def _corner(corner: Corner, number: int) -> Iterator[_Shape]:
    pose = np.append(corner.position_xy, 0.0)
    yield _Shape(namespace="corners", number=number, kind="SPHERE", scale=(_DOT, _DOT, _DOT), color=_ORANGE, pose=pose)
    variances, axes = np.linalg.eigh(corner.covariance)
    short, long = np.maximum(2.0 * _ELLIPSE_95 * np.sqrt(np.maximum(variances, 0.0)), _THINNEST).tolist()
    yield _Shape(
        namespace="corner ellipses",
        number=number,
        kind="CYLINDER",
        scale=(long, short, _FLAT),
        color=(*_ORANGE[:3], _FAINT),
        pose=np.append(corner.position_xy, np.arctan2(axes[1, 1], axes[0, 1])),
    )
    yield _label("corner", number, position_xy=corner.position_xy)


def _cylinder(cylinder: Cylinder, number: int) -> Iterator[_Shape]:
    diameter = max(2.0 * cylinder.radius, _THINNEST)
    yield _Shape(
        namespace="cylinders",
        number=number,
        kind="CYLINDER",
        scale=(diameter, diameter, _FLAT),
        color=_TEAL,
        pose=np.append(cylinder.center_xy, 0.0),
    )
    yield _label("cylinder", number, position_xy=cylinder.center_xy)


def _lines(namespace: str, number: int, *, points_xy: FloatArray, color: tuple[float, float, float, float]) -> _Shape:
    scale = (_LINE, 0.0, 0.0)
    return _Shape(namespace=namespace, number=number, kind="LINE_LIST", scale=scale, color=color, points_xy=points_xy)


def _label(kind: str, number: int, *, position_xy: FloatArray) -> _Shape:
    return _Shape(
        namespace=f"{kind} numbers",
        number=number,
        kind="TEXT_VIEW_FACING",
        scale=(0.0, 0.0, _TEXT),
        color=_GREY,
        pose=np.append(position_xy, 0.0),
        text=f"{kind} {number}",
    )


def _marker(types: Types, shape: _Shape, *, frame: str, stamp: int) -> Any:
    marker = types["visualization_msgs/msg/Marker"]
    red, green, blue, opacity = shape.color
    no_picture = types["sensor_msgs/msg/CompressedImage"](
        header=header(types, "", stamp=0), format="", data=np.zeros(0, dtype=np.uint8)
    )
    return marker(
        header=header(types, frame, stamp=stamp),
        ns=shape.namespace,
        id=shape.number,
        type=getattr(marker, shape.kind),
        action=marker.ADD,
        # Markers lie above the grid at 0, and text above markers.
        pose=pose_message(types, shape.pose, z=_TEXT if shape.text else _LINE),
        scale=vector(types, shape.scale),
        color=types["std_msgs/msg/ColorRGBA"](r=red, g=green, b=blue, a=opacity),
        # Never expires.
        lifetime=types["builtin_interfaces/msg/Duration"](sec=0, nanosec=0),
        frame_locked=True,
        points=[point(types, each) for each in shape.points_xy],
        colors=[],
        texture_resource="",
        texture=no_picture,
        uv_coordinates=[],
        text=shape.text,
        mesh_resource="",
        mesh_file=types["visualization_msgs/msg/MeshFile"](filename="", data=np.zeros(0, dtype=np.uint8)),
        mesh_use_embedded_materials=False,
    )
