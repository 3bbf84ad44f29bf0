"""Log densities of pings by multipath alone."""

import numpy as np

from echoplan.acoustics.predicted_echo import SonarTables
from echoplan.arrays import FloatArray
from echoplan.joint.likelihood.crosstalk import Emissions, add_crosstalk
from echoplan.joint.likelihood.double_bounces import add_ghosts_of_cylinder
from echoplan.joint.likelihood.image_sources import Extent
from echoplan.joint.likelihood.ping_scores import NO_ECHO
from echoplan.preprocessing.measurements import Measurements


def crosstalk_log_densities(
    inputs: tuple[Measurements, SonarTables, Emissions],
    walls: tuple[FloatArray, FloatArray],
    extents: tuple[Extent, Extent],
    noise: float,
) -> FloatArray:
    """What bursts explain that come by way of walls and were not meant for these pings."""
    add_crosstalk(log_densities := log_densities_without_echo(inputs[0]), inputs, walls, extents, noise)
    return log_densities


def ghosts_of_cylinder(
    inputs: tuple[Measurements, SonarTables], wall: FloatArray, cylinder: FloatArray, noise: float
) -> FloatArray:
    """What echoes of a cylinder in a wall explain."""
    add_ghosts_of_cylinder(log_densities := log_densities_without_echo(inputs[0]), inputs, wall, cylinder, noise)
    return log_densities


def log_densities_without_echo(measurements: Measurements) -> FloatArray:
    """Log densities of pings without any echo."""
    return np.full(len(measurements.readings), NO_ECHO)
