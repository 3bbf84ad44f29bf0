"""Predicted echo of a reflector: its depth, its signal excess, and the range that the sonar would read.

The same sonar equation, beam, echo laws and range walk as elsewhere in this package, turned into tables so that
compiled functions can ask for millions of echoes a second.  Importing this module imports numba.
"""

import math
from enum import IntEnum
from typing import TypeAlias

from echoplan.acoustics.echo_model import COSINE_LIMIT, PER_SQUARED_SINE, SQUARED_SINES, EchoModel, SonarTables
from echoplan.acoustics.range_walk_model import EXCESS_STEP
from echoplan.arrays import FloatArray
from echoplan.compiled import inlined

__all__ = [
    "SILENCE",
    "EchoGeometry",
    "EchoModel",
    "Kind",
    "OffAxis",
    "Ping",
    "Shape",
    "SonarTables",
    "bistatic_excess_of",
    "differentiate",
    "echo_geometry",
    "excess_of",
    "predict_echo",
    "shape_of",
    "walk_of",
]


class Kind(IntEnum):
    """What a reflector can be to a sonar, and so what its three parameters mean.

    A reflector is kept as four numbers: its kind and ``normal_angle, offset, reflection_loss`` for a wall (in dB; 0 if
    it reflects all sound), ``x, y, radius`` for a cylinder, ``x, y, 0`` for a concave corner or a convex edge, and
    ``x, y, radius`` for a round wall, which is the inside of a cylinder.
    """

    WALL = 0
    CYLINDER = 1
    CORNER = 2
    EDGE = 3
    ROUND = 4


# Plain numbers, for compiled functions fold constants but not members of an enumeration.
_WALL, _CYLINDER, _EDGE, _ROUND = int(Kind.WALL), int(Kind.CYLINDER), int(Kind.EDGE), int(Kind.ROUND)

# The face of a transducer is not a point: depths below this count as this [m].
_NEAREST = 0.02
# Nearer to its centre a round wall counts as seen from here [m]: the direction of its echo is not defined there.
_NEAREST_CENTER = 0.05
# No cylinder is thinner than this [m]: it would be a fraction of a wavelength, and its echo law another.
_THINNEST = 1e-3
# An edge scatters 36 dB less than a plane at 1 m, falling off by 10 dB a decade more (GTD, 90 degree wedge).
_EDGE_LOSS = -36.0
_PER_NEPER = 20.0 / math.log(10.0)
SILENCE = -99.0


# A reflector as compiled functions want it: its kind and, for a wall, its unit normal, offset and reflection loss [dB];
# else as it is kept, without loss.
Shape: TypeAlias = tuple[int, float, float, float, float]

# Acoustic centre x, y [m] and unit vector of the beam axis.
Ping: TypeAlias = tuple[float, float, float, float]

# Depth [m]; cosine and sine of the angle from the reflector's direction to the beam axis; distance of the point that
# defines the reflector [m]; strength of the echo against that of a plane at the same depth [dB].
EchoGeometry: TypeAlias = tuple[float, float, float, float, float]

# Cosine and sine of an angle off the axis of a beam.
OffAxis: TypeAlias = tuple[float, float]


@inlined
def shape_of(reflector: FloatArray) -> Shape:
    """Make a reflector ready for many pings: the functions of its normal angle are asked for once.

    Parameters
    ----------
    reflector : ndarray, shape (4,)
        Value of ``Kind`` and three parameters.

    Returns
    -------
    Shape
        The same reflector.
    """
    kind = int(reflector[0])
    if kind == _WALL:
        return kind, math.cos(reflector[1]), math.sin(reflector[1]), reflector[2], reflector[3]
    return kind, reflector[1], reflector[2], reflector[3], 0.0


@inlined
def echo_geometry(shape: Shape, ping: Ping) -> EchoGeometry:
    """Geometry of the echo of a reflector, as a sensor sees it.

    Parameters
    ----------
    shape : Shape
        The reflector.
    ping : Ping
        Where the sensor is and where it looks.

    Returns
    -------
    EchoGeometry
        Depth, angle, distance and strength.
    """
    kind, a, b, radius, loss = shape
    x, y, ux, uy = ping
    if kind == _WALL:
        depth = radius - a * x - b * y
        return depth, ux * a + uy * b, a * uy - b * ux, depth, -loss
    dx, dy = a - x, b - y
    distance = math.sqrt(dx * dx + dy * dy) + 1e-12
    cosine, sine = (ux * dx + uy * dy) / distance, (dx * uy - dy * ux) / distance
    if kind == _CYLINDER:
        return distance - radius, cosine, sine, distance, 10.0 * math.log10(max(radius, _THINNEST) / distance)
    if kind == _ROUND:
        # From inside, sound returns from where the line through the centre meets the wall: ahead, or behind the centre.
        distance = max(distance, _NEAREST_CENTER)
        if cosine > 0.0:
            return radius + distance, cosine, sine, distance, 0.0
        return radius - distance, -cosine, -sine, -distance, 0.0
    if kind == _EDGE:
        return distance, cosine, sine, distance, _EDGE_LOSS - 10.0 * math.log10(max(distance, _NEAREST))
    return distance, cosine, sine, distance, 0.0


@inlined
def excess_of(tables: SonarTables, geometry: EchoGeometry) -> float:
    """Signal excess of an echo by the sonar equation.

    Parameters
    ----------
    tables : SonarTables
        The sonar.
    geometry : EchoGeometry
        The reflector as the sensor sees it.

    Returns
    -------
    float
        ``S - 20 lg(2 e) - 2 alpha e + B + X`` [dB]; silence beyond 75 degrees off the axis.
    """
    depth, cosine, sine, _, strength = geometry
    if cosine <= COSINE_LIMIT:
        return SILENCE
    place = sine * sine * PER_SQUARED_SINE
    node = min(int(place), SQUARED_SINES - 1)
    beam = tables.beam[node] + (place - node) * (tables.beam[node + 1] - tables.beam[node])
    depth = max(depth, _NEAREST)
    spreading = 20.0 * math.log10(2.0 * depth) + 2.0 * tables.absorption * depth
    return float(tables.figure_of_merit - spreading + beam + strength)


@inlined
def bistatic_excess_of(tables: SonarTables, depth: float, leaving: OffAxis, coming: OffAxis, strength: float) -> float:
    """Greatest signal excess of sound that left and came back at different angles: side lobes count with their peaks.

    Parameters
    ----------
    tables : SonarTables
        The sonar.
    depth : float
        Half of the way of the sound [m].
    leaving, coming : OffAxis
        Cosine and sine of the angle off the axis at either end.
    strength : float
        Of the echo against that of a plane at the same depth [dB].

    Returns
    -------
    float
        As ``excess_of``, but with ``lobes`` for the beam [dB]; silence behind the sensor.
    """
    if leaving[0] <= 0.0 or coming[0] <= 0.0:
        return SILENCE
    out = tables.lobes[min(int(leaving[1] * leaving[1] * SQUARED_SINES), SQUARED_SINES)]
    back = tables.lobes[min(int(coming[1] * coming[1] * SQUARED_SINES), SQUARED_SINES)]
    depth = max(depth, _NEAREST)
    spreading = 20.0 * math.log10(2.0 * depth) + 2.0 * tables.absorption * depth
    return float(tables.figure_of_merit - spreading + 0.5 * (out + back) + strength)


@inlined
def walk_of(tables: SonarTables, excess: float) -> float:
    """Range walk of an echo.

    Parameters
    ----------
    tables : SonarTables
        The sonar.
    excess : float
        Signal excess [dB]; below the threshold the walk stays what it is there.

    Returns
    -------
    float
        Reading less depth [m].
    """
    place = min(max(excess, 0.0) / EXCESS_STEP, len(tables.walk) - 1 - 1e-9)
    node = int(place)
    return float(tables.walk[node] + (place - node) * (tables.walk[node + 1] - tables.walk[node]))


@inlined
def predict_echo(tables: SonarTables, shape: Shape, ping: Ping) -> tuple[float, float, float]:
    """Predict the echo of a reflector.

    Parameters
    ----------
    tables : SonarTables
        The sonar.
    shape : Shape
        The reflector.
    ping : Ping
        Where the sensor is and where it looks.

    Returns
    -------
    depth, excess, reading : float
        Depth [m], signal excess [dB] and the range as it would be read, scaled [m].
    """
    geometry = echo_geometry(shape, ping)
    excess = excess_of(tables, geometry)
    return geometry[0], excess, geometry[0] + walk_of(tables, excess)


@inlined
def differentiate(
    tables: SonarTables, shape: Shape, ping: Ping, jacobian: FloatArray, attenuation: float = 0.0
) -> tuple[float, float]:
    """Predict the echo of a reflector, and how its reading changes with the reflector and the sensor.

    Parameters
    ----------
    tables : SonarTables
        The sonar.
    shape : Shape
        The reflector.
    ping : Ping
        Where the sensor is and where it looks.
    jacobian : ndarray, shape (8,)
        Filled with the derivatives of the reading by the three parameters, by the sensor's x and y, by the direction
        of its beam, by the level of the echo in decibels and by the logarithm of ``ka``.
    attenuation : float, optional
        How much fainter than all of the reflector it is from there [dB].

    Returns
    -------
    depth, excess : float
        Depth [m] and signal excess [dB].
    """
    geometry, kind = echo_geometry(shape, ping), shape[0]
    depth, cosine, sine, distance, _ = geometry
    excess = excess_of(tables, geometry) - attenuation
    by_depth, by_strength, by_angle = _derivatives(tables, geometry, excess)
    # Unit vector from the sensor to the reflector.
    ex, ey = cosine * ping[2] + sine * ping[3], cosine * ping[3] - sine * ping[2]
    jacobian[2], jacobian[5], jacobian[6] = 0.0, by_angle, by_strength
    # The beam depends on ka sin(angle).
    jacobian[7] = by_angle * sine / max(cosine, COSINE_LIMIT)
    if kind == _WALL:
        jacobian[0], jacobian[1] = -by_depth * (ex * ping[1] - ey * ping[0]) - by_angle, by_depth
        jacobian[3], jacobian[4] = -by_depth * ex, -by_depth * ey
        return depth, excess
    radial = by_depth - (by_strength * 0.5 * _PER_NEPER / distance if kind in (_CYLINDER, _EDGE) else 0.0)
    turning = by_angle / distance
    jacobian[0], jacobian[1] = radial * ex + turning * ey, radial * ey - turning * ex
    jacobian[3], jacobian[4] = -jacobian[0], -jacobian[1]
    if kind == _ROUND:
        jacobian[2] = by_depth
    if kind == _CYLINDER:
        jacobian[2] = by_strength * 0.5 * _PER_NEPER / max(shape[3], _THINNEST) - by_depth
    return depth, excess


@inlined
def _derivatives(tables: SonarTables, geometry: EchoGeometry, excess: float) -> tuple[float, float, float]:
    """Differentiate the reading by the depth, by the strength of the echo and by the angle off the axis."""
    depth, cosine, sine, _, _ = geometry
    if not 0.0 < excess < EXCESS_STEP * (len(tables.walk) - 1):
        return 1.0, 0.0, 0.0
    node = int(excess / EXCESS_STEP)
    steepness = (tables.walk[node + 1] - tables.walk[node]) / EXCESS_STEP
    fading = -_PER_NEPER / depth - 2.0 * tables.absorption if depth > _NEAREST else 0.0
    node = min(int(sine * sine * PER_SQUARED_SINE), SQUARED_SINES - 1)
    narrowing = (tables.beam[node + 1] - tables.beam[node]) * PER_SQUARED_SINE * 2.0 * sine * cosine
    return 1.0 + steepness * fading, steepness, steepness * narrowing
