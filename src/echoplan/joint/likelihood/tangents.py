"""Tangents of a round wall: the flat walls that a station detects in its place, by one reflection or by two."""

import math

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray
from echoplan.geometry import directions

__all__ = ["PATHS", "tangents"]

# The paths of sound from a station and back, by the tangents that reflect it.
PATHS = np.array([(0, 0), (1, 1), (2, 3)])
# Part of a tangent, to either side of the point where it touches, that reflects sound [m].
_FACING = 0.2


def tangents(round_wall: FloatArray, center_xy: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the walls, shape (4, 4), and their extents, shape (4, 2) [m], that a station at ``center_xy`` detects.

    The first two return sound along the line through the station and the centre. The others return it by the path that
    is symmetric to that line and meets the round wall at bearings b and -b from it. The law of reflection there is
    r sin b = -d cos b, with the distances r of the station from the centre and d from the point.
    """
    away, radius = center_xy - round_wall[1:3], float(round_wall[3])
    beyond = math.hypot(*away)
    # With u = -cos b, since d^2 = r^2 + R^2 + 2 r R u.
    roots = np.roots([2.0 * beyond * radius, 2.0 * beyond**2 + radius**2, 0.0, -(beyond**2)])
    turn = math.acos(-min(max(float(roots.real.max()), 0.0), 1.0))
    normals = directions(math.atan2(away[1], away[0]) + np.array([0.0, math.pi, turn, -turn]))
    walls = np.zeros((4, 4))
    walls[:, 0] = Kind.WALL
    walls[:, 1] = np.arctan2(normals[:, 1], normals[:, 0])
    walls[:, 2] = normals @ round_wall[1:3] + radius
    feet = normals[:, 0] * round_wall[2] - normals[:, 1] * round_wall[1]
    return walls, feet[:, None] + np.array([-_FACING, _FACING])
