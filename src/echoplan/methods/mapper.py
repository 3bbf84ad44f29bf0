"""What turns sweeps into a map, and what can be asked of it."""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.features import Observation
from echoplan.model import FeatureMap, OccupancyGrid, Rig, Sweep
from echoplan.preprocessing import clean_sweeps, find_faults

__all__ = ["Mapper", "grid_of", "map_sweeps", "needs_places", "observations_of", "points_of"]


class Mapper(Protocol):
    """Anything that takes sweeps and gives a map."""

    rig: Rig

    def add(self, sweep: Sweep) -> None:
        """Take one more sweep.

        A mapper does not check its input: faults of sensors show only in all sweeps together, so ``clean_sweeps``
        must take them out before sweeps are given one by one. ``map_sweeps`` does so.

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


def map_sweeps(
    mapper: Mapper, sweeps: Iterable[Sweep], *, follow: Callable[[Sequence[Sweep]], Iterable[Sweep]] = iter
) -> FeatureMap:
    """Give a mapper all sweeps, without what faults of sensors put there, and take its map.

    Parameters
    ----------
    mapper : Mapper
        The mapper.
    sweeps : iterable of Sweep
        The sweeps, in the order of time.
    follow : callable, optional
        Is given the cleaned sweeps and passes them on: to show how far mapping is, or to listen in.

    Returns
    -------
    FeatureMap
        The map of all of them; of the poses alone where features would be invented: without positions, and from one
        place by a method that needs several.
    """
    recorded = tuple(sweeps)
    faults = find_faults(recorded, mapper.rig)
    followed = follow(clean_sweeps(recorded, mapper.rig, faults))
    if faults.has_no_poses or (needs_places(mapper) and faults.is_from_one_place):
        # Unless earlier sweeps are of other places.
        empty = mapper.result()
        if not len(empty.poses):
            return _with_poses_alone(empty, followed)
    for sweep in followed:
        mapper.add(sweep)
    return mapper.result()


def _with_poses_alone(empty: FeatureMap, sweeps: Iterable[Sweep]) -> FeatureMap:
    pinged = [sweep for sweep in sweeps if len(sweep)]
    return replace(
        empty,
        sweeps=np.array([sweep.index for sweep in pinged], dtype=np.int64),
        poses=np.array([sweep.station for sweep in pinged]).reshape(-1, 3),
    )


def needs_places(mapper: Mapper) -> bool:
    """Return True if a mapper would invent features from one place."""
    return getattr(mapper, "needs_places", False)


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
    """Return what a mapper detected in single sweeps.

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
