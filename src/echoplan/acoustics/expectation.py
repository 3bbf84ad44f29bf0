"""What a sonar should hear of a reflector: at what depth, how loud, and at what range it would read it.

The same sonar equation, beam, echo laws and range walk as elsewhere in this package, turned into tables so that
compiled functions can ask for millions of echoes a second.  Importing this module imports numba.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple, TypeAlias

import numpy as np

from echoplan.acoustics.air import Air
from echoplan.acoustics.beam import two_way_loss
from echoplan.acoustics.detection import peak_delay
from echoplan.acoustics.sonar import piston_ka
from echoplan.acoustics.walk import EXCESS_STEP, WalkCurve, physical_walk
from echoplan.arrays import FloatArray
from echoplan.compiled import compiled
from echoplan.model import Transducer

__all__ = [
    "SILENCE",
    "EchoModel",
    "Hearing",
    "Kind",
    "Ping",
    "Shape",
    "Sight",
    "differentiate",
    "excess_of",
    "expect",
    "lobe_excess_of",
    "look",
    "shape_of",
    "walk_of",
]


class Kind(IntEnum):
    """What a reflector can be to a sonar, and so what its three parameters mean.

    A reflector is kept as four numbers: its kind and ``normal_angle, offset, 0`` for a wall, ``x, y, radius`` for a
    cylinder, ``x, y, 0`` for a corner that is heard into or an edge that is heard around.
    """

    WALL = 0
    CYLINDER = 1
    CORNER = 2
    EDGE = 3


# Plain numbers, for compiled functions fold constants but not members of an enumeration.
_WALL, _CYLINDER, _EDGE = int(Kind.WALL), int(Kind.CYLINDER), int(Kind.EDGE)

# The beam is tabulated over the squared sine of the angle off its axis, up to 75 degrees; beyond that nothing is
# expected.  No sonar has a lobe there that anyone has measured.
_SQUARED_SINES = 2048
_COSINE_LIMIT = math.cos(math.radians(75.0))
_SQUARED_LIMIT = 1.0 - _COSINE_LIMIT**2
_PER_SQUARED_SINE = _SQUARED_SINES / _SQUARED_LIMIT
_BEAM_FLOOR = -80.0

# The face of a transducer is not a point: depths below this count as this [m].
_NEAREST = 0.02
# No cylinder is thinner than this [m]: it would be a fraction of a wavelength, and its echo law another.
_THINNEST = 1e-3
# An edge scatters 36 dB less than a plane at 1 m, falling off by 10 dB a decade more (GTD, 90 degree wedge).
_EDGE_LOSS = -36.0
_PER_NEPER = 20.0 / math.log(10.0)
SILENCE = -99.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class EchoModel:
    """A sonar as a recording shows it: loudness, beam, and how its readings relate to ranges.

    A reading z stands for the depth e by ``z (1 + range_scale) = e + range_offset + walk_gain (walk(M) - walk(M_1))``,
    where M is the signal excess and M_1 that of an aimed plane at 1 m: that is where a maker sets a module right.

    Parameters
    ----------
    figure_of_merit : float
        Signal excess of a plane at 0.5 m, whose path is 1 m long, without absorption [dB].
    ka : float
        Circumference of the piston in wavelengths.
    absorption : float
        Of the air [dB/m].
    walk : WalkCurve
        Shape of the range walk.
    walk_gain : float
        Walk at the threshold [m].
    range_offset : float
        Error of the reading of an aimed plane at 1 m [m].
    range_scale : float
        Share by which readings are too short.
    """

    figure_of_merit: float
    ka: float
    absorption: float
    walk: WalkCurve
    walk_gain: float
    range_offset: float = 0.0
    range_scale: float = 0.0

    @classmethod
    def of(cls, transducer: Transducer) -> "EchoModel":
        """Expect of a sonar what its transducer should do in air of 20 degrees Celsius.

        Parameters
        ----------
        transducer : Transducer
            Burst, resonators, piston and figure of merit.

        Returns
        -------
        EchoModel
            Set right, as by its maker.
        """
        air = Air()
        return cls(
            figure_of_merit=transducer.figure_of_merit,
            ka=piston_ka(transducer, air),
            absorption=float(air.absorption(transducer.frequency)),
            walk=physical_walk(transducer),
            walk_gain=0.5 * air.speed_of_sound * peak_delay(transducer),
        )

    @property
    def reference_excess(self) -> float:
        """Signal excess of an aimed plane at 1 m [dB]."""
        return self.figure_of_merit - 20 * math.log10(2.0) - 2 * self.absorption

    def tabulated(self) -> "Hearing":
        """Turn the model into numbers and tables.

        Returns
        -------
        Hearing
            What compiled functions read.
        """
        sines = np.sqrt(np.linspace(0.0, _SQUARED_LIMIT, _SQUARED_SINES + 1))
        gains = np.maximum(-two_way_loss(np.arcsin(sines), self.ka), _BEAM_FLOOR)
        shape = self.walk.values - float(self.walk(self.reference_excess))
        return Hearing(
            figure_of_merit=self.figure_of_merit,
            absorption=self.absorption,
            scale=1.0 + self.range_scale,
            # Behind the first null lobes come and go with the angle; a sonar is trusted no more there than in the null.
            beam=np.minimum.accumulate(gains),
            lobes=_lobes(self.ka),
            walk=self.range_offset + self.walk_gain * shape,
        )


class Hearing(NamedTuple):
    """An echo model as numbers and tables.

    Attributes
    ----------
    figure_of_merit, absorption : float
        As in the model [dB], [dB/m].
    scale : float
        What turns a reading into a range.
    beam : ndarray
        Two-way gain at even steps of the squared sine off the axis [dB].
    lobes : ndarray
        The same up to 90 degrees, as loud as the loudest lobe at or beyond each angle [dB].
    walk : ndarray
        Reading less depth at even steps of the signal excess [m].
    """

    figure_of_merit: float
    absorption: float
    scale: float
    beam: FloatArray
    lobes: FloatArray
    walk: FloatArray


# A reflector as compiled functions want it: its kind and, for a wall, its unit normal and offset; else as it is kept.
Shape: TypeAlias = tuple[int, float, float, float]

# Acoustic centre x, y [m] and unit vector of the beam axis.
Ping: TypeAlias = tuple[float, float, float, float]

# Depth [m]; cosine and sine of the angle from the reflector's direction to the beam axis; distance of the point that
# defines the reflector [m]; strength of the echo against that of a plane at the same depth [dB].
Sight: TypeAlias = tuple[float, float, float, float, float]


@compiled
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
        return kind, math.cos(reflector[1]), math.sin(reflector[1]), reflector[2]
    return kind, reflector[1], reflector[2], reflector[3]


@compiled
def look(shape: Shape, ping: Ping) -> Sight:
    """Look from a sensor at a reflector.

    Parameters
    ----------
    shape : Shape
        The reflector.
    ping : Ping
        Where the sensor is and where it looks.

    Returns
    -------
    Sight
        Depth, angle, distance and strength.
    """
    kind, a, b, radius = shape
    x, y, ux, uy = ping
    if kind == _WALL:
        depth = radius - a * x - b * y
        return depth, ux * a + uy * b, a * uy - b * ux, depth, 0.0
    dx, dy = a - x, b - y
    distance = math.sqrt(dx * dx + dy * dy) + 1e-12
    cosine, sine = (ux * dx + uy * dy) / distance, (dx * uy - dy * ux) / distance
    if kind == _CYLINDER:
        return distance - radius, cosine, sine, distance, 10.0 * math.log10(max(radius, _THINNEST) / distance)
    if kind == _EDGE:
        return distance, cosine, sine, distance, _EDGE_LOSS - 10.0 * math.log10(max(distance, _NEAREST))
    return distance, cosine, sine, distance, 0.0


@compiled
def excess_of(hearing: Hearing, sight: Sight) -> float:
    """Signal excess of an echo by the sonar equation.

    Parameters
    ----------
    hearing : Hearing
        The sonar.
    sight : Sight
        The reflector as the sensor sees it.

    Returns
    -------
    float
        ``S - 20 lg(2 e) - 2 alpha e + B + X`` [dB]; silence beyond 75 degrees off the axis.
    """
    depth, cosine, sine, _, strength = sight
    if cosine <= _COSINE_LIMIT:
        return SILENCE
    place = sine * sine * _PER_SQUARED_SINE
    node = min(int(place), _SQUARED_SINES - 1)
    beam = hearing.beam[node] + (place - node) * (hearing.beam[node + 1] - hearing.beam[node])
    depth = max(depth, _NEAREST)
    spreading = 20.0 * math.log10(2.0 * depth) + 2.0 * hearing.absorption * depth
    return float(hearing.figure_of_merit - spreading + beam + strength)


@compiled
def lobe_excess_of(hearing: Hearing, sight: Sight) -> float:
    """Greatest signal excess that an echo may have: side lobes count with their peaks.

    Parameters
    ----------
    hearing : Hearing
        The sonar.
    sight : Sight
        The reflector as the sensor sees it.

    Returns
    -------
    float
        As ``excess_of``, but with ``lobes`` for the beam [dB]; silence behind the sensor.
    """
    depth, cosine, sine, _, strength = sight
    if cosine <= 0.0:
        return SILENCE
    node = min(int(sine * sine * _SQUARED_SINES), _SQUARED_SINES)
    depth = max(depth, _NEAREST)
    spreading = 20.0 * math.log10(2.0 * depth) + 2.0 * hearing.absorption * depth
    return float(hearing.figure_of_merit - spreading + hearing.lobes[node] + strength)


@compiled
def walk_of(hearing: Hearing, excess: float) -> float:
    """Range walk of an echo.

    Parameters
    ----------
    hearing : Hearing
        The sonar.
    excess : float
        Signal excess [dB]; below the threshold the walk stays what it is there.

    Returns
    -------
    float
        Reading less depth [m].
    """
    place = min(max(excess, 0.0) / EXCESS_STEP, len(hearing.walk) - 1 - 1e-9)
    node = int(place)
    return float(hearing.walk[node] + (place - node) * (hearing.walk[node + 1] - hearing.walk[node]))


@compiled
def expect(hearing: Hearing, shape: Shape, ping: Ping) -> tuple[float, float, float]:
    """Expect the echo of a reflector.

    Parameters
    ----------
    hearing : Hearing
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
    sight = look(shape, ping)
    excess = excess_of(hearing, sight)
    return sight[0], excess, sight[0] + walk_of(hearing, excess)


@compiled
def differentiate(hearing: Hearing, shape: Shape, ping: Ping, slopes: FloatArray) -> tuple[float, float]:
    """Expect the echo of a reflector, and how its reading changes with the reflector and the sensor.

    Parameters
    ----------
    hearing : Hearing
        The sonar.
    shape : Shape
        The reflector.
    ping : Ping
        Where the sensor is and where it looks.
    slopes : ndarray, shape (6,)
        Filled with the derivatives of the reading by the three parameters, by the sensor's x and y and by the
        direction of its beam.

    Returns
    -------
    depth, excess : float
        Depth [m] and signal excess [dB].
    """
    sight, kind = look(shape, ping), shape[0]
    depth, cosine, sine, distance, _ = sight
    excess = excess_of(hearing, sight)
    by_depth, by_strength, by_angle = _slopes(hearing, sight, excess)
    # Unit vector from the sensor to the reflector.
    ex, ey = cosine * ping[2] + sine * ping[3], cosine * ping[3] - sine * ping[2]
    slopes[2], slopes[5] = 0.0, by_angle
    if kind == _WALL:
        slopes[0], slopes[1] = -by_depth * (ex * ping[1] - ey * ping[0]) - by_angle, by_depth
        slopes[3], slopes[4] = -by_depth * ex, -by_depth * ey
        return depth, excess
    radial = by_depth - (by_strength * 0.5 * _PER_NEPER / distance if kind in (_CYLINDER, _EDGE) else 0.0)
    turning = by_angle / distance
    slopes[0], slopes[1] = radial * ex + turning * ey, radial * ey - turning * ex
    slopes[3], slopes[4] = -slopes[0], -slopes[1]
    if kind == _CYLINDER:
        slopes[2] = by_strength * 0.5 * _PER_NEPER / max(shape[3], _THINNEST) - by_depth
    return depth, excess


@compiled
def _slopes(hearing: Hearing, sight: Sight, excess: float) -> tuple[float, float, float]:
    """Differentiate the reading by the depth, by the strength of the echo and by the angle off the axis."""
    depth, cosine, sine, _, _ = sight
    if not 0.0 < excess < EXCESS_STEP * (len(hearing.walk) - 1):
        return 1.0, 0.0, 0.0
    node = int(excess / EXCESS_STEP)
    steepness = (hearing.walk[node + 1] - hearing.walk[node]) / EXCESS_STEP
    fading = -_PER_NEPER / depth - 2.0 * hearing.absorption if depth > _NEAREST else 0.0
    node = min(int(sine * sine * _PER_SQUARED_SINE), _SQUARED_SINES - 1)
    narrowing = (hearing.beam[node + 1] - hearing.beam[node]) * _PER_SQUARED_SINE * 2.0 * sine * cosine
    return 1.0 + steepness * fading, steepness, steepness * narrowing


def _lobes(ka: float) -> FloatArray:
    sines = np.sqrt(np.linspace(0.0, 1.0, _SQUARED_SINES + 1))
    gains = np.maximum(-two_way_loss(np.arcsin(sines), ka), _BEAM_FLOOR)
    outward: FloatArray = np.maximum.accumulate(gains[::-1])[::-1]
    return outward
