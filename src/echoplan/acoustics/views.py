"""Views: how far off its axis a sonar could detect a reflector at all, so that most pings need not be checked."""

import math
from typing import NamedTuple

import numpy as np

from echoplan.acoustics.echo_model import PER_SQUARED_SINE, SQUARED_SINES
from echoplan.acoustics.predicted_echo import Kind, Ping, Shape, SonarTables, echo_geometry, excess_of
from echoplan.arrays import FloatArray
from echoplan.compiled import inlined

__all__ = ["Views", "in_view", "views_of"]

_WALL, _ROUND = int(Kind.WALL), int(Kind.ROUND)
# Steps of depth.
_DEPTHS = 64
# Nearer than this everything is as loud as here [m].
_NEAREST = 0.02


class Views(NamedTuple):
    """Views of one reflector.

    Attributes
    ----------
    cosines : ndarray, shape (65,)
        Least cosine off the axis at which it could be detected, by even steps of its depth up to the reach.
    reach : float
        Depth of the farthest echo [m].
    widest : float
        Least of the cosines.
    """

    cosines: FloatArray
    reach: float
    widest: float


@inlined
def views_of(tables: SonarTables, shape: Shape, least: float, reach: float) -> Views:
    """Find how far off its axis a sonar could detect a reflector.

    Parameters
    ----------
    tables : SonarTables
        The sonar; its main lobe only falls off to the sides.
    shape : Shape
        The reflector.
    least : float
        Signal excess of the faintest echo that counts [dB].
    reach : float
        Depth of the farthest [m].

    Returns
    -------
    Views
        Never narrower than the formulas for a single ping.
    """
    cosines, node = np.empty(_DEPTHS + 1), SQUARED_SINES
    for step in range(_DEPTHS + 1):
        # Of all the depths in a step the nearest is the loudest; and the deeper, the nearer to the axis.
        aimed = excess_of(tables, echo_geometry(shape, _before(shape, max(step * reach / _DEPTHS, _NEAREST))))
        while node >= 0 and aimed + tables.beam[node] - tables.beam[0] <= least:
            node -= 1
        cosines[step] = math.sqrt(1.0 - min(node + 1, SQUARED_SINES) / PER_SQUARED_SINE)
    return Views(cosines, reach, cosines[0])


@inlined
def in_view(views: Views, shape: Shape, ping: Ping) -> bool:
    """Return whether a sensor could detect a reflector.

    Parameters
    ----------
    views : Views
        Views of the reflector.
    shape : Shape
        The reflector.
    ping : Ping
        Where the sensor is and where it looks.

    Returns
    -------
    bool
        False if it is behind, out of reach or too far off the axis.
    """
    kind, a, b, radius, _ = shape
    x, y, ux, uy = ping
    # Most look elsewhere: that is checked first, without a division.
    if kind == _WALL:
        cosine = ux * a + uy * b
        if cosine < views.widest:
            return False
        depth = radius - a * x - b * y
    else:
        dx, dy = a - x, b - y
        ahead, distance = ux * dx + uy * dy, math.sqrt(dx * dx + dy * dy) + 1e-12
        if (abs(ahead) if kind == _ROUND else ahead) < views.widest * distance:
            return False
        depth, cosine = distance - radius, ahead / distance
        if kind == _ROUND:
            depth, cosine = radius + distance if ahead > 0.0 else radius - distance, abs(cosine)
    return 0.0 < depth <= views.reach and cosine >= views.cosines[int(depth / views.reach * _DEPTHS)]


@inlined
def _before(shape: Shape, depth: float) -> Ping:
    """Place a sensor so deep before a reflector, looking at it."""
    kind, a, b, radius, _ = shape
    if kind == _WALL:
        return a * (radius - depth), b * (radius - depth), a, b
    return a + (radius - depth if kind == _ROUND else -depth - radius), b, 1.0, 0.0
