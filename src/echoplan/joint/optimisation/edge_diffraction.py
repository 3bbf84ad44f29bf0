"""Edge diffraction: convex edges at which walls end, and the weaker echo of a wall near such an end."""

import math
from typing import TypeAlias

import numpy as np

from echoplan.acoustics.predicted_echo import (
    EchoGeometry,
    Kind,
    Ping,
    Shape,
    SonarTables,
    differentiate,
    echo_geometry,
    excess_of,
    walk_of,
)
from echoplan.arrays import FloatArray
from echoplan.compiled import compiled, inlined

__all__ = ["WallExtent", "diffracted", "diffracted_jacobian", "edges_of", "is_ended"]

_WALL = int(Kind.WALL)
# Walls at a smaller angle to each other cross too far away (sine).
_TURN = math.sin(math.radians(20))
# The detected extent of a wall may exceed an edge, or fall short of it, by this much [m].
_PAST, _BEFORE = 0.1, 0.5
# Fresnel parameter up to which an edge causes no loss (ITU-R P.526).
_CLEAR = -0.78
# Distance before an end within which diffraction is computed [m]: at 4 m the loss begins 7 cm before the end.
_ZONE = 0.1
# Step of the central difference [m].
_STEP = 1e-4

# Lower and upper bound of the detected extent of a wall, and positions of the edges at which it ends, along it [m].
WallExtent: TypeAlias = tuple[float, float, float, float]


@compiled
def edges_of(reflectors: FloatArray, extents: FloatArray) -> FloatArray:
    """Return the convex edges at which walls end, shape (f, 2, 6), from their extents, shape (f, 2) [m].

    Two walls form an edge at their crossing if each lies behind the other, both were detected up to it, and neither was
    detected beyond it. For the lower and the upper end of each wall the columns are: position along the wall [m],
    infinite without an edge; its derivatives by normal angle and offset of the wall, and by those of the other wall of
    the edge; index of the other wall, -1 without an edge.
    """
    ends = np.zeros((len(reflectors), 2, 6))
    ends[:, 0, 0], ends[:, 1, 0], ends[:, :, 5] = -np.inf, np.inf, -1.0
    for one in range(len(reflectors)):
        for other in range(one + 1, len(reflectors)):
            if reflectors[one, 0] == _WALL and reflectors[other, 0] == _WALL:
                _meet(reflectors, extents, ends, one, other)
    return ends


@inlined
def is_ended(shape: Shape, place: Ping, reach: WallExtent) -> bool:
    """Return whether a sensor is so near an end of a wall, or past it, that diffraction matters; False for others."""
    foot = shape[1] * place[1] - shape[2] * place[0]
    return bool(shape[0] == _WALL and max(reach[2] - foot, foot - reach[3]) > -_ZONE)


@inlined
def diffracted(geometry: EchoGeometry, below: float, above: float, wavelength: float) -> EchoGeometry:
    """Return the sight of a wall with the knife-edge loss of ITU-R P.526 and, past its end, along the path to the end.

    ``below`` and ``above`` are the distances of the foot of the perpendicular past the lower and the upper end [m],
    negative before them; ``wavelength`` is that of the carrier [m].
    """
    depth, cosine, sine, distance, strength = geometry
    over = max(below, above)
    passing = 2.0 * over / math.sqrt(depth * wavelength)
    if passing <= _CLEAR:
        return geometry
    grazing = passing - 0.1
    strength -= 6.9 + 20.0 * math.log10(math.sqrt(grazing * grazing + 1.0) + grazing)
    if over <= 0.0:
        return depth, cosine, sine, distance, strength
    away = math.hypot(depth, over)
    aside, ahead = (over if below > above else -over) / away, depth / away
    return away, cosine * ahead + sine * aside, sine * ahead - cosine * aside, distance, strength


@inlined
def diffracted_jacobian(
    tables: SonarTables,
    shape: Shape,
    place: Ping,
    end: tuple[FloatArray, float],
    jacobian: tuple[FloatArray, FloatArray],
) -> int:
    """Differentiate the reading of a wall near its end, and return the index of the other wall of that edge.

    ``end`` holds a row of ``edges_of``, shape (2, 6), and the attenuation from this station [dB]. ``jacobian`` is
    filled: shape (8,) as by ``differentiate``, and shape (2,) by normal angle and offset of the other wall. Past the
    end, derivatives other than those by the distance past it are taken along the normal.
    """
    (ends, attenuation), (own, neighbours) = end, jacobian
    geometry, foot = echo_geometry(shape, place), shape[1] * place[1] - shape[2] * place[0]
    below, above = ends[0, 0] - foot, foot - ends[1, 0]
    lost = geometry[4] - diffracted(geometry, below, above, tables.wavelength)[4]
    differentiate(tables, shape, place, own, attenuation + lost)
    near = _read(tables, diffracted(geometry, below - _STEP, above - _STEP, tables.wavelength), attenuation)
    far = _read(tables, diffracted(geometry, below + _STEP, above + _STEP, tables.wavelength), attenuation)
    side, sign = (0, 1.0) if below > above else (1, -1.0)
    slope = sign * (far - near) / (2.0 * _STEP)
    # ``slope`` is by the position of the end; the foot of the perpendicular enters with the opposite sign.
    own[0] += slope * (ends[side, 1] + shape[3] - geometry[0])
    own[1] += slope * ends[side, 2]
    own[3] += slope * shape[2]
    own[4] -= slope * shape[1]
    neighbours[0], neighbours[1] = slope * ends[side, 3], slope * ends[side, 4]
    return int(ends[side, 5])


@inlined
def _read(tables: SonarTables, geometry: EchoGeometry, attenuation: float) -> float:
    return geometry[0] + walk_of(tables, excess_of(tables, geometry) - attenuation)


@inlined
def _meet(reflectors: FloatArray, extents: FloatArray, ends: FloatArray, one: int, other: int) -> None:
    """Set the ends of two walls to the edge that they form, if any, unless other edges shorten them more."""
    turn = reflectors[other, 1] - reflectors[one, 1]
    across, ahead = math.sin(turn), math.cos(turn)
    if abs(across) < _TURN:
        return
    # Position of the crossing along each wall, from both offsets and the angle between the normals.
    place = (reflectors[other, 2] - reflectors[one, 2] * ahead) / across
    beyond = (reflectors[other, 2] * ahead - reflectors[one, 2]) / across
    # If the direction of the first wall leads behind the other one, the crossing is its lower end, else its upper end.
    side = 0 if across > 0.0 else 1
    if _reaches(extents[one], side, place) and _reaches(extents[other], 1 - side, beyond):
        _end(ends[one], side, place, reflectors[one, 2], (ahead, across), other)
        _end(ends[other], 1 - side, beyond, reflectors[other, 2], (ahead, -across), one)


@inlined
def _reaches(extent: FloatArray, side: int, place: float) -> bool:
    """Return whether the extent of a wall ends near a position on its lower (0) or upper (1) side."""
    gap = extent[0] - place if side == 0 else place - extent[1]
    return bool(-_PAST < gap < _BEFORE)


@inlined
def _end(ends: FloatArray, side: int, place: float, offset: float, turn: tuple[float, float], neighbour: int) -> None:
    """Set an end of a wall to its crossing with a neighbour, turned by this cosine and sine, unless it ends before."""
    if (place > ends[side, 0]) != (side == 0):
        return
    cosine, sine = turn
    turning = place * cosine / sine - offset
    ends[side, 0], ends[side, 5] = place, neighbour
    ends[side, 1], ends[side, 2], ends[side, 3], ends[side, 4] = turning, -cosine / sine, -turning, 1.0 / sine
