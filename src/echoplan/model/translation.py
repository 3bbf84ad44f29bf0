"""Maps and grids in a translated frame."""

from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.model.changes import Changes
from echoplan.model.feature_map import FeatureMap
from echoplan.model.features import Cylinder, Wall

__all__ = ["translated", "translated_wall"]


def translated(feature_map: FeatureMap, by_xy: FloatArray) -> FeatureMap:
    """Express a map in a frame with parallel axes.

    Parameters
    ----------
    feature_map : FeatureMap
        The map.
    by_xy : ndarray, shape (2,)
        Added to the coordinates of all points [m].

    Returns
    -------
    FeatureMap
        The same map in the other frame.

    Examples
    --------
    >>> translated(FeatureMap(method="none", sweeps=[0], poses=[[1.0, 2.0, 0.5]]), np.array([100.0, 0.0])).poses
    array([[101. ,   2. ,   0.5]])
    """
    if not by_xy.any():
        return feature_map
    return replace(
        feature_map,
        walls=tuple(translated_wall(each, by_xy) for each in feature_map.walls),
        corners=tuple(replace(each, position_xy=each.position_xy + by_xy) for each in feature_map.corners),
        cylinders=_cylinders(feature_map.cylinders, by_xy),
        openings=tuple(replace(each, endpoints_xy=each.endpoints_xy + by_xy) for each in feature_map.openings),
        unobserved=tuple(replace(each, endpoints_xy=each.endpoints_xy + by_xy) for each in feature_map.unobserved),
        poses=feature_map.poses + np.append(by_xy, 0.0),
        changes=tuple(_changes(each, by_xy) for each in feature_map.changes),
    )


def translated_wall(wall: Wall, by_xy: FloatArray) -> Wall:
    """Express a wall in a frame with parallel axes.

    Parameters
    ----------
    wall : Wall
        The wall.
    by_xy : ndarray, shape (2,)
        Added to the coordinates of all points [m].

    Returns
    -------
    Wall
        The same wall: its offset and its covariance refer to the origin of the other frame.

    Examples
    --------
    >>> wall = Wall(normal_angle=0.0, offset=2.0, endpoints_xy=[[2.0, 0.0], [2.0, 1.0]], covariance=np.eye(2) * 1e-4)
    >>> moved = translated_wall(wall, np.array([3.0, 1.0]))
    >>> moved.offset, moved.covariance.tolist()
    (5.0, [[0.0001, 0.0001], [0.0001, 0.0002]])
    """
    normal = wall.normal_xy
    # The derivative of n . by_xy by the angle of n.
    jacobian = np.array([[1.0, 0.0], [float(normal[0] * by_xy[1] - normal[1] * by_xy[0]), 1.0]])
    covariance = jacobian @ wall.covariance @ jacobian.T
    return replace(
        wall,
        offset=float(wall.offset + normal @ by_xy),
        endpoints_xy=wall.endpoints_xy + by_xy,
        covariance=(covariance + covariance.T) / 2.0,
    )


def _changes(changes: Changes, by_xy: FloatArray) -> Changes:
    return replace(
        changes,
        gone_walls=tuple(ends + by_xy for ends in changes.gone_walls),
        new_walls=tuple(ends + by_xy for ends in changes.new_walls),
        gone_cylinders=_cylinders(changes.gone_cylinders, by_xy),
        new_cylinders=_cylinders(changes.new_cylinders, by_xy),
    )


def _cylinders(cylinders: tuple[Cylinder, ...], by_xy: FloatArray) -> tuple[Cylinder, ...]:
    return tuple(replace(each, center_xy=each.center_xy + by_xy) for each in cylinders)
