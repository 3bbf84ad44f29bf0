"""What ghosts alone explain: levels raised from nothing."""

import numpy as np

from echoplan.acoustics.predicted_echo import Hearing
from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.crosstalk import Bursts, add_volleys
from echoplan.joint.likelihood.double_bounces import add_ghosts_of_cylinder
from echoplan.joint.likelihood.image_sources import Extent
from echoplan.joint.likelihood.ping_scores import UNHEARD
from echoplan.preprocessing.ping_arrays import Soundings


def volleys_over(
    heard: tuple[Soundings, Hearing, Bursts],
    walls: tuple[FloatArray, FloatArray],
    extents: tuple[Extent, Extent],
    noise: float,
) -> FloatArray:
    """What bursts explain that come by way of walls and were not meant for these pings."""
    add_volleys(levels := levels_of_no_echo(heard[0]), heard, walls, extents, noise)
    return levels


def ghosts_of_cylinder(
    heard: tuple[Soundings, Hearing], wall: FloatArray, cylinder: FloatArray, noise: float
) -> FloatArray:
    """What echoes of a cylinder in a wall explain."""
    add_ghosts_of_cylinder(levels := levels_of_no_echo(heard[0]), heard, wall, cylinder, noise)
    return levels


def levels_of_no_echo(soundings: Soundings) -> FloatArray:
    """Levels of pings that nothing explains."""
    return np.full(len(soundings.readings), UNHEARD)
