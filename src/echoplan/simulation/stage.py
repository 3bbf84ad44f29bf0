"""What the ray tracer is given, and the two ends of every path.

These are named tuples because such cross into machine code.  Points and directions in the plane are complex numbers,
x + jy, so that mirroring and turning are products.
"""

from typing import NamedTuple

from echoplan.simulation.scene import Scene
from echoplan.simulation.shots import Shots
from echoplan.simulation.sonar import Sonar

__all__ = ["Receiver", "Source", "Stage"]


class Stage(NamedTuple):
    """All that decides what is detected: what stands around, transducer and air, all pings."""

    scene: Scene
    sonar: Sonar
    shots: Shots


class Source(NamedTuple):
    """A source of sound, or the image of one: place [m], axis of the beam, when it fired after the ping [s]."""

    place: complex
    axis: complex
    fired: float


class Receiver(NamedTuple):
    """A receiver, or the image of one: place [m], axis, their rates [m/s, rad/s], and its window.

    It listens until the deadline [s]; paths shorter or longer than two lengths [m] cannot arrive in time.
    """

    place: complex
    axis: complex
    velocity: complex
    turn: float
    deadline: float
    shortest: float
    longest: float
