"""What ghosts alone explain: levels raised from nothing."""

import numpy as np

from echoplan.acoustics.predicted_echo import SonarTables
from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.crosstalk import Emissions, add_crosstalk
from echoplan.joint.likelihood.double_bounces import add_ghosts_of_cylinder
from echoplan.joint.likelihood.image_sources import Extent
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.preprocessing.measurements import Measurements


def volleys_over(
    detected: tuple[Measurements, SonarTables, Emissions],
    walls: tuple[FloatArray, FloatArray],
    extents: tuple[Extent, Extent],
    noise: float,
) -> FloatArray:
    """What bursts explain that come by way of walls and were not meant for these pings."""
    add_crosstalk(log_densities := levels_of_no_echo(detected[0]), detected, walls, extents, noise)
    return log_densities


def ghosts_of_cylinder(
    detected: tuple[Measurements, SonarTables], wall: FloatArray, cylinder: FloatArray, noise: float
) -> FloatArray:
    """What echoes of a cylinder in a wall explain."""
    add_ghosts_of_cylinder(log_densities := levels_of_no_echo(detected[0]), detected, wall, cylinder, noise)
    return log_densities


def levels_of_no_echo(measurements: Measurements) -> FloatArray:
    """Levels of pings that nothing explains."""
    return np.full(len(measurements.readings), NO_ECHO)
