"""Maps as GeoJSON (RFC 7946): for QGIS, GDAL, and whatever else reads plain geometry."""

from collections.abc import Iterable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.geometry import along, directions
from echoplan.io.files import by_name, write_text
from echoplan.io.text import format_json
from echoplan.model import Corner, Cylinder, FeatureMap, Opening, UnobservedStretch, Wall

__all__ = ["LOCAL_METRES", "write_geojson"]

# The coordinates are metres in a frame of their own, and readers would take them for longitudes and latitudes: an
# engineering CRS of two axes anywhere (ISO 19162).  GDAL reads the name of a named CRS (GeoJSON 2008) as text of this
# kind; it takes "crs": null for WGS 84.
LOCAL_METRES = (
    'ENGCRS["local metres",EDATUM["origin of the map"],CS[Cartesian,2],'
    'AXIS["x",unspecified],AXIS["y",unspecified],LENGTHUNIT["metre",1]]'
)

# Vertices of the polygon of a cylinder: it runs at most 0.12 % of the radius inside the circle.
_VERTICES = 64


@by_name
def write_geojson(path: Path, feature_map: FeatureMap) -> None:
    """Write a map as a FeatureCollection in local metres.

    Parameters
    ----------
    path : Path or str
        The file.
    feature_map : FeatureMap
        The map.  Walls, openings, unobserved stretches and the path of the robot become lines, corners points, and
        cylinders polygons with their ``radius`` (points where it is 0).

    Raises
    ------
    OutputError
        If the file cannot be written.

    Notes
    -----
    The member ``crs`` declares an engineering coordinate reference system in metres, which GDAL and QGIS respect; the
    member ``echoplan`` has the name of the frame.  Readers that know only RFC 7946 ignore both.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "map.geojson"
    >>> write_geojson(path, FeatureMap(method="rcd"))
    >>> "FeatureCollection" in path.read_text()
    True
    """
    quality = {} if feature_map.quality is None else {"quality": asdict(feature_map.quality)}
    document = {
        "type": "FeatureCollection",
        "crs": {"type": "name", "properties": {"name": LOCAL_METRES}},
        "echoplan": {"frame": feature_map.frame, "unit": "m", "method": feature_map.method, **quality},
        "features": [
            *_features("wall", map(_wall, feature_map.walls)),
            *_features("opening", map(_gap, feature_map.openings)),
            *_features("unobserved", map(_gap, feature_map.unobserved)),
            *_features("corner", map(_corner, feature_map.corners)),
            *_features("cylinder", map(_cylinder, feature_map.cylinders)),
            *_features("path", _paths(feature_map.paths_xy)),
        ],
    }
    write_text(path, format_json(document) + "\n")


def _features(kind: str, shapes: Iterable[tuple[dict[str, Any], dict[str, Any]]]) -> Iterator[dict[str, Any]]:
    """Make features of geometries and their properties, numbered as in ``map.json`` and named as in ``map.svg``."""
    for number, (geometry, properties) in enumerate(shapes):
        yield {
            "type": "Feature",
            "id": f"{kind}-{number}",
            "properties": {"kind": kind, "number": number, **properties},
            "geometry": geometry,
        }


def _wall(wall: Wall) -> tuple[dict[str, Any], dict[str, Any]]:
    middle = along([wall.normal_angle, wall.offset], wall.endpoints_xy.mean(axis=0))
    jacobian = np.array([-middle, 1.0])
    start, end = (None if np.isnan(sigma) else sigma for sigma in wall.endpoint_sigmas.tolist())
    inferred_start, inferred_end = wall.inferred.tolist()
    properties = {
        "length": wall.length,
        "normal_angle": wall.normal_angle,
        "offset": wall.offset,
        # Of the middle across the wall.
        "sigma": _root(jacobian @ wall.covariance @ jacobian),
        "sigma_start": start,
        "sigma_end": end,
        "inferred_start": inferred_start,
        "inferred_end": inferred_end,
        "probability": wall.class_probabilities.wall,
    }
    return _line(wall.endpoints_xy), {**properties, **_support(wall)}


def _gap(gap: Opening | UnobservedStretch) -> tuple[dict[str, Any], dict[str, Any]]:
    length = float(np.hypot(*(gap.endpoints_xy[1] - gap.endpoints_xy[0])))
    evidence = {"sigma": gap.width_sigma, "passed": gap.passed} if isinstance(gap, Opening) else {}
    return _line(gap.endpoints_xy), {"length": length, **evidence, "walls": list(gap.walls)}


def _corner(corner: Corner) -> tuple[dict[str, Any], dict[str, Any]]:
    properties = {
        "shape": str(corner.kind),
        "sigma_x": _root(corner.covariance[0, 0]),
        "sigma_y": _root(corner.covariance[1, 1]),
        "probability": corner.class_probabilities.corner,
    }
    return {"type": "Point", "coordinates": corner.position_xy.tolist()}, {**properties, **_support(corner)}


def _cylinder(cylinder: Cylinder) -> tuple[dict[str, Any], dict[str, Any]]:
    # Counter-clockwise and closed by its first vertex, as RFC 7946 (section 3.1.6) asks.
    rim = cylinder.center_xy + cylinder.radius * directions(np.arange(_VERTICES) * (2 * np.pi / _VERTICES))
    ring = [*rim.tolist(), rim[0].tolist()]
    polygon = {"type": "Polygon", "coordinates": [ring]}
    point = {"type": "Point", "coordinates": cylinder.center_xy.tolist()}
    properties = {
        "radius": cylinder.radius,
        "sigma_x": _root(cylinder.covariance[0, 0]),
        "sigma_y": _root(cylinder.covariance[1, 1]),
        "sigma_radius": _root(cylinder.covariance[2, 2]),
        "probability": cylinder.class_probabilities.cylinder,
    }
    return polygon if cylinder.radius > 0.0 else point, {**properties, **_support(cylinder)}


def _paths(paths_xy: Iterable[FloatArray]) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
    """Make the path of the robot in each recording: a point where it stood still."""
    for path_xy in paths_xy:
        length = float(np.hypot(*np.diff(path_xy, axis=0).T).sum())
        point = {"type": "Point", "coordinates": path_xy[0].tolist()}
        yield _line(path_xy) if length > 0.0 else point, {"length": length, "stations": len(path_xy)}


def _line(points_xy: FloatArray) -> dict[str, Any]:
    return {"type": "LineString", "coordinates": points_xy.tolist()}


def _support(feature: Wall | Corner | Cylinder) -> dict[str, Any]:
    return {"pings": feature.pings, "stations": feature.stations}


def _root(variance: float) -> float:
    """Return a standard deviation; rounding may leave a variance of zero below it."""
    return float(np.sqrt(max(variance, 0.0)))
