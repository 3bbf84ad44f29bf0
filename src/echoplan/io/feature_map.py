"""Maps in JSON: ``map.json``."""

from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.io.files import by_name, inside, write_text
from echoplan.io.map_form import MapForm
from echoplan.io.structure import read_json
from echoplan.io.text import format_json
from echoplan.model import Changes, Corner, Cylinder, FeatureMap, Opening, UnobservedStretch, Wall

__all__ = ["read_map", "write_map"]


@by_name
def read_map(path: Path) -> FeatureMap:
    """Read a map.

    Parameters
    ----------
    path : Path or str
        The file, or the folder with ``map.json``; what other programs added to it is passed over.

    Returns
    -------
    FeatureMap
        The map.

    Raises
    ------
    InputError
        If the file cannot be read, is of another version or holds no possible map.
    """
    return read_json(inside(path, "map.json"), MapForm).value()


@by_name
def write_map(path: Path, feature_map: FeatureMap) -> None:
    """Write a map.

    Parameters
    ----------
    path : Path or str
        The file.
    feature_map : FeatureMap
        The map.

    Raises
    ------
    InvalidValueError
        If its parameters do not fit into JSON.
    OutputError
        If the file cannot be written.

    Examples
    --------
    >>> path = getfixture("tmp_path") / "map.json"
    >>> write_map(path, FeatureMap(method="rcd"))
    >>> read_map(path).method
    'rcd'
    """
    document = {
        "format": "echoplan-map/1",
        "frame": feature_map.frame,
        "method": feature_map.method,
        **({} if feature_map.quality is None else {"quality": asdict(feature_map.quality)}),
        "parameters": dict(feature_map.parameters),
        "walls": _numbered(map(_wall, feature_map.walls)),
        "corners": _numbered(
            {"position": each.position_xy.tolist(), "kind": each.kind, **_evidence(each)}
            for each in feature_map.corners
        ),
        "cylinders": _numbered(map(_cylinder, feature_map.cylinders)),
        "poses": _poses(feature_map),
        **_gaps(feature_map),
        **({"changes": [_changes(each) for each in feature_map.changes]} if feature_map.changes else {}),
    }
    write_text(path, format_json(document) + "\n")


def _numbered(features: Iterable[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{"id": number, **feature} for number, feature in enumerate(features)]


def _poses(feature_map: FeatureMap) -> list[dict[str, Any]]:
    poses = [
        {"sweep": sweep, "x": x, "y": y, "yaw": yaw}
        for sweep, (x, y, yaw) in zip(feature_map.sweeps.tolist(), feature_map.poses.tolist(), strict=True)
    ]
    if not len(feature_map.pose_covariances):
        return poses
    covariances = feature_map.pose_covariances.tolist()
    return [{**pose, "covariance": covariance} for pose, covariance in zip(poses, covariances, strict=True)]


def _gaps(feature_map: FeatureMap) -> dict[str, Any]:
    """List openings and unobserved stretches; a map without them is written as it was before there were any."""
    lists = {
        "openings": _numbered(
            {**_endpoints(each), "width_sigma": each.width_sigma, "walls": list(each.walls), "passed": each.passed}
            for each in feature_map.openings
        ),
        "unobserved": _numbered({**_endpoints(each), "walls": list(each.walls)} for each in feature_map.unobserved),
    }
    return {name: entries for name, entries in lists.items() if entries}


def _changes(changes: Changes) -> dict[str, Any]:
    return {
        "recording": changes.recording,
        **({} if changes.first_sweep is None else {"first_sweep": changes.first_sweep}),
        "gone": _changed(changes.gone_walls, changes.gone_cylinders),
        "new": _changed(changes.new_walls, changes.new_cylinders),
    }


def _changed(walls: Iterable[FloatArray], cylinders: Iterable[Cylinder]) -> dict[str, Any]:
    pieces = [{"start": start, "end": end} for start, end in (each.tolist() for each in walls)]
    return {"walls": pieces, "cylinders": [_cylinder(each) for each in cylinders]}


def _wall(wall: Wall) -> dict[str, Any]:
    """List what is known of a wall: there is no NaN in JSON, and zero goes without saying."""
    sigmas = [None if np.isnan(sigma) else sigma for sigma in wall.endpoint_sigmas.tolist()]
    return {
        **_endpoints(wall),
        "normal_angle": wall.normal_angle,
        "offset": wall.offset,
        **_evidence(wall),
        **({} if sigmas == [None, None] else {"endpoint_sigmas": sigmas}),
        **({"inferred": wall.inferred.tolist()} if wall.inferred.any() else {}),
        **({"reflection_loss": wall.reflection_loss} if wall.reflection_loss else {}),
    }


def _endpoints(feature: Wall | Opening | UnobservedStretch) -> dict[str, Any]:
    start, end = feature.endpoints_xy.tolist()
    return {"start": start, "end": end}


def _cylinder(cylinder: Cylinder) -> dict[str, Any]:
    return {"center": cylinder.center_xy.tolist(), "radius": cylinder.radius, **_evidence(cylinder)}


def _evidence(feature: Wall | Corner | Cylinder) -> dict[str, Any]:
    return {
        "covariance": feature.covariance.tolist(),
        "class_probabilities": asdict(feature.class_probabilities),
        "pings": feature.pings,
        "stations": feature.stations,
    }
