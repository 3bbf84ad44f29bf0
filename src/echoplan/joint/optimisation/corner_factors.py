"""Corner factors: detected corners at the crossing of two walls, and the derivatives of such crossings."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.predicted_echo import Kind
from echoplan.arrays import FloatArray, IntArray
from echoplan.compiled import compiled
from echoplan.geometry import directions, intersections
from echoplan.joint.optimisation.factors import LinearFactor
from echoplan.joint.optimisation.layout import Layout

__all__ = ["ConstrainedCorner", "CornerFactorSettings", "constrained_corners", "corner_factors", "crossing_jacobian"]

_WALL = int(Kind.WALL)


class CornerFactorSettings(NamedTuple):
    """Settings of the corner factors."""

    # Standard deviation of a corner from the intersection of its walls [m].
    sigma: float = 0.001
    # Largest distance of a corner from the intersection of its walls [m].
    gate: float = 0.05
    # Largest deviation from 90 degrees of walls whose corner returns an echo from their vertex [rad].
    right_angle_tolerance: float = math.radians(3)


class ConstrainedCorner(NamedTuple):
    """Index of a corner, indices of the two walls that form it, and their crossing, shape (2,) [m]."""

    corner: int
    walls: tuple[int, int]
    crossing_xy: FloatArray


def crossing_jacobian(lines: FloatArray, crossing_xy: FloatArray) -> FloatArray:
    """Return the derivatives of the crossing of two lines: ``N dX = d(offset) - (t . X) d(angle)``.

    Lines have shape (2, 2), normal angle [rad] and offset [m]. The result has shape (2, 4): x and y by both parameters
    of the first line, then by those of the second.

    Examples
    --------
    >>> crossing_jacobian(np.array([[0.0, 2.0], [np.pi / 2, 1.0]]), np.array([2.0, 1.0])).round(6) + 0.0
    array([[-1.,  1.,  0.,  0.],
           [ 0.,  0.,  2.,  1.]])
    """
    inverse = np.linalg.inv(directions(lines[:, 0]))
    along = directions(lines[:, 0] + math.pi / 2) @ crossing_xy
    return np.column_stack([-along[0] * inverse[:, 0], inverse[:, 0], -along[1] * inverse[:, 1], inverse[:, 1]])


def corner_factors(reflectors: FloatArray, layout: Layout, settings: CornerFactorSettings) -> Iterator[LinearFactor]:
    """Yield a factor of two rows for each corner at a crossing of two walls: its distance from the crossing in x and y.

    Sound that is reflected by both of two walls at a right angle returns as if from their vertex.
    """
    for number, walls, crossing in constrained_corners(reflectors, settings):
        columns = np.concatenate([layout.starts[k] + np.arange(2) for k in (*walls, number)])
        jacobian = np.concatenate([crossing_jacobian(reflectors[list(walls), 1:3], crossing), -np.eye(2)], axis=1)
        yield LinearFactor(
            np.stack([columns, columns]),
            jacobian,
            -(crossing - reflectors[number, 1:3]),
            np.full(2, settings.sigma**-2),
        )


def constrained_corners(reflectors: FloatArray, settings: CornerFactorSettings) -> Iterator[ConstrainedCorner]:
    """Yield the corners near a crossing of two walls at a right angle, each with the nearest crossing."""
    pairs = _square_pairs(reflectors, settings.right_angle_tolerance)
    if not len(pairs):
        return
    crossings = intersections(reflectors[pairs[:, 0], 1:3], reflectors[pairs[:, 1], 1:3])
    for number in np.flatnonzero(reflectors[:, 0] == Kind.CORNER):
        distances = np.hypot(*(crossings - reflectors[number, 1:3]).T)
        best = int(np.argmin(distances))
        if distances[best] < settings.gate:
            yield ConstrainedCorner(int(number), (int(pairs[best, 0]), int(pairs[best, 1])), crossings[best])


@compiled
def _square_pairs(reflectors: FloatArray, tolerance: float) -> IntArray:
    """Return the index pairs of walls at a right angle, shape (p, 2)."""
    count = 0
    pairs = np.empty((len(reflectors) * len(reflectors) // 2, 2), np.int64)
    for one in range(len(reflectors)):
        for other in range(one + 1, len(reflectors)):
            if not reflectors[one, 0] == reflectors[other, 0] == _WALL:
                continue
            # At a right angle the cosine of the angle between the normals is zero, whichever way the walls face.
            if abs(math.cos(reflectors[one, 1] - reflectors[other, 1])) < math.sin(tolerance):
                pairs[count, 0], pairs[count, 1] = one, other
                count += 1
    return pairs[:count]
