"""What all mappers have in common: each sweep is checked, and mapped in a frame whose origin is near the robot."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.features import Observation
from echoplan.errors import InvalidValueError
from echoplan.joint.known_map import views_of
from echoplan.joint.mapper import JointMapper
from echoplan.joint.marginal_prior import MarginalPrior
from echoplan.methods.mapper import Mapper, grid_of, needs_places, observations_of, points_of
from echoplan.model import FeatureMap, OccupancyGrid, Rig, Sweep, Wall, translated, translated_wall

__all__ = ["LocalMapper", "check_order"]


class LocalMapper:
    """Checks sweeps and hands them to a mapper in a local frame.

    Coordinates of a country are so large that rounding alone would ruin normal equations.  The origin of the local
    frame is the position of the first station, in whole metres: so subtracting it is exact, and the cells of grids
    stay where they were.

    Parameters
    ----------
    mapper : Mapper
        What maps in the local frame.
    rig : Rig
        What made the sweeps.
    origin_xy : ndarray, shape (2,), optional
        Origin of the local frame, if the mapper knows something in it [m].
    """

    def __init__(self, mapper: Mapper, rig: Rig, *, origin_xy: FloatArray | None = None) -> None:
        self.mapper = mapper
        self.rig = rig
        self._origin_xy = origin_xy
        self._last: Sweep | None = None

    def add(self, sweep: Sweep) -> None:
        """Check one more sweep and map it; one without pings says nothing.

        Parameters
        ----------
        sweep : Sweep
            The pings of one pass of the array.

        Raises
        ------
        UnknownNameError
            If a sensor id is not of the rig.
        InvalidValueError
            If the sweep does not follow the one before in index and time; the mapper stays as it was.
        """
        if not len(sweep):
            return
        self.rig.indices(sweep.sensor_ids)
        check_order(self._last, sweep)
        origin_xy = np.round(sweep.station[:2]) if self._origin_xy is None else self._origin_xy
        self.mapper.add(replace(sweep, map_from_base=sweep.map_from_base - np.append(origin_xy, 0.0)))
        self._origin_xy, self._last = origin_xy, sweep

    def begin_recording(self, pose: FloatArray) -> None:
        """Go on with another recording of the same place.

        Parameters
        ----------
        pose : ndarray, shape (3,)
            Pose of its first sweep in the frame of the map [m, m, rad].

        Raises
        ------
        InvalidValueError
            If the mapper maps one recording only.
        """
        self._several.begin_recording(pose - np.append(self.origin_xy, 0.0))

    def prior(self) -> MarginalPrior | None:
        """Return what is known after all sweeps so far, in the local frame, with which another mapper can go on.

        Returns
        -------
        MarginalPrior or None
            None if the method maps one recording only, or there were no echoes.
        """
        return self.mapper.prior() if isinstance(self.mapper, JointMapper) else None

    def looks(self) -> tuple[FloatArray, FloatArray]:
        """Return along which lines of sight walls were detected, and where the robot drove.

        Returns
        -------
        views_xy : ndarray, shape (v, 2, 2)
            From the station to the wall [m].
        path_xy : ndarray, shape (p, 2)
            Places of the robot, with a row of NaN after each earlier recording [m]; none if it may have driven around
            walls between them.
        """
        prior = self.prior()
        if prior is None:
            return np.zeros((0, 2, 2)), np.zeros((0, 2))
        path_xy = prior.path_xy if self._several.settings.segments.driven else np.zeros((0, 2))
        return views_of(prior) + self.origin_xy, path_xy + self.origin_xy

    def forget(self, walls: Sequence[Wall]) -> None:
        """Forget what earlier recordings detected of some walls, since these are there no more.

        Parameters
        ----------
        walls : sequence of Wall
            Walls of the map, or pieces of them.

        Raises
        ------
        InvalidValueError
            If the mapper maps one recording only.
        """
        self._several.forget([translated_wall(each, -self.origin_xy) for each in walls])

    def misses(self, sweeps: Sequence[Sweep]) -> Callable[[Sequence[Wall]], FloatArray]:
        """Return how probable it is that some sweeps do not detect walls.

        Parameters
        ----------
        sweeps : sequence of Sweep
            At the poses of the map, not at the recorded ones.

        Returns
        -------
        callable
            Returns, for a sequence of n walls, or pieces of walls, the log probability that the stations of the sweeps
            do not detect each of them, shape (n,) [nats].

        Raises
        ------
        InvalidValueError
            If the mapper maps one recording only.
        """
        away = -self.origin_xy
        local = [replace(each, map_from_base=each.map_from_base + np.append(away, 0.0)) for each in sweeps]
        misses = self._several.misses(local)
        return lambda walls: misses([translated_wall(each, away) for each in walls])

    def result(self) -> FeatureMap:
        """Make the map of all sweeps so far.

        Returns
        -------
        FeatureMap
            In the frame of the sweeps.
        """
        return translated(self.mapper.result(), self.origin_xy)

    @property
    def _several(self) -> JointMapper:
        """The mapper, if it maps several recordings."""
        if not isinstance(self.mapper, JointMapper):
            raise InvalidValueError("the method maps one recording only")
        return self.mapper

    @property
    def needs_places(self) -> bool:
        """Whether the mapper would invent features from one place."""
        return needs_places(self.mapper)

    @property
    def points_xy(self) -> FloatArray:
        """Points of which the mapper makes its map [m], shape (n, 2)."""
        return points_of(self.mapper) + self.origin_xy

    @property
    def observations(self) -> tuple[Observation, ...]:
        """What the mapper located in single sweeps."""
        return tuple(
            replace(each, point=replace(each.point, hub_xy=each.point.hub_xy + self.origin_xy))
            for each in observations_of(self.mapper)
        )

    @property
    def origin_xy(self) -> FloatArray:
        """Origin of the local frame in the frame of the sweeps [m], shape (2,)."""
        return np.zeros(2) if self._origin_xy is None else self._origin_xy.copy()

    @property
    def grid(self) -> OccupancyGrid | None:
        """The grid beneath the map, if the mapper keeps one."""
        grid = grid_of(self.mapper)
        return grid and replace(grid, origin_xy=grid.origin_xy + self.origin_xy)


def check_order(last: Sweep | None, sweep: Sweep) -> None:
    """Check that a sweep follows the one before, if there is one, in index and time.

    Parameters
    ----------
    last : Sweep or None
        The sweep before.
    sweep : Sweep
        The sweep.

    Raises
    ------
    InvalidValueError
        If it does not.
    """
    if last is None:
        return
    if sweep.index <= last.index:
        raise InvalidValueError(f"the index of a sweep must increase, not go from {last.index} to {sweep.index}")
    begins, ended = int(sweep.stamps_ns[0]), int(last.stamps_ns[-1])
    if begins < ended:
        raise InvalidValueError(
            f"sweep {sweep.index} begins at {begins * 1e-9:g} s, before sweep {last.index} ends at {ended * 1e-9:g} s; "
            "add sweeps in the order of time"
        )
