"""What turns sweeps into a map, and what can be asked of it."""

from collections.abc import Iterable
from typing import Protocol

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.mapping import Observation
from echoplan.model import FeatureMap, OccupancyGrid, Rig, Sweep
from echoplan.preprocessing import clean_sweeps, find_faults

__all__ = ["Mapper", "grid_of", "map_sweeps", "observations_of", "points_of"]


class Mapper(Protocol):
    """Anything that takes sweeps and gives a map."""

    rig: Rig

    def add(self, sweep: Sweep) -> None:
        """Take one more sweep.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.
        """
        ...

    def result(self) -> FeatureMap:
        """Make the map of all sweeps so far.

        Returns
        -------
        FeatureMap
            The map; asking for it changes nothing.
        """
        ...


def map_sweeps(mapper: Mapper, sweeps: Iterable[Sweep]) -> FeatureMap:
    """Give a mapper all sweeps, without what faults of sensors put there, and take its map.

    Parameters
    ----------
    mapper : Mapper
        The mapper.
    sweeps : iterable of Sweep
        The sweeps, in the order of time.

    Returns
    -------
    FeatureMap
        The map of all of them.
    """
    recorded = tuple(sweeps)
    for sweep in clean_sweeps(recorded, mapper.rig, find_faults(recorded, mapper.rig)):
        mapper.add(sweep)
    return mapper.result()


def points_of(mapper: Mapper) -> FloatArray:
    """Ask a mapper for the points of which it makes its map.

    Parameters
    ----------
    mapper : Mapper
        A mapper that was given sweeps.

    Returns
    -------
    ndarray, shape (n, 2)
        The points [m]; none if it makes its map of something else.
    """
    points: FloatArray = getattr(mapper, "points_xy", np.zeros((0, 2)))
    return points


def observations_of(mapper: Mapper) -> tuple[Observation, ...]:
    """Ask a mapper what single sweeps heard.

    Parameters
    ----------
    mapper : Mapper
        A mapper that was given sweeps.

    Returns
    -------
    tuple of Observation
        What was located, sweep by sweep; empty if the mapper locates nothing in single sweeps.
    """
    return tuple(getattr(mapper, "observations", ()))


def grid_of(mapper: Mapper) -> OccupancyGrid | None:
    """Ask a mapper for the grid beneath its map.

    Parameters
    ----------
    mapper : Mapper
        A mapper that was given sweeps.

    Returns
    -------
    OccupancyGrid or None
        None if the mapper keeps no grid.
    """
    return getattr(mapper, "grid", None)
