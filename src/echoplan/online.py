"""Mapping while a robot drives: sweeps are taken at once, and a process beside the caller maps them."""

import threading
from collections.abc import Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from multiprocessing import get_context
from types import TracebackType
from typing import Self

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.batch.local import prepare_process
from echoplan.errors import EchoplanError, InvalidValueError
from echoplan.geometry import compose, invert
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.methods import LocalMapper, check_order
from echoplan.model import FeatureMap, Rig, Sweep

__all__ = ["OnlineMapper"]


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class _Snapshot:
    """A map, the number of sweeps in it, and the pose of odometry in its frame, shape (3,) [m, m, rad]."""

    feature_map: FeatureMap
    sweeps: int
    map_from_odom: FloatArray


class OnlineMapper:
    """Maps while a robot drives.

    ``add``, ``result`` and ``map_from_odom`` return within milliseconds: a process beside the caller does the work, and
    makes a new map whenever it has mapped the sweeps of the one before.  Readings of faulty sensors are not removed, as
    that takes the whole recording.  In a script, use it below ``if __name__ == "__main__":``.

    Parameters
    ----------
    rig : Rig
        Sensors that make the sweeps.
    settings : JointSettings, optional
        Settings of joint.

    Raises
    ------
    InvalidValueError
        If the settings are of another type.

    Examples
    --------
    >>> import echoplan as ep
    >>> room = ep.simulate("square", seed=1)
    >>> with OnlineMapper(room.rig) as mapper:
    ...     for sweep in room:
    ...         mapper.add(sweep)
    ...     found = mapper.finish()
    >>> len(found.walls), mapper.behind
    (4, 0)
    """

    def __init__(self, rig: Rig, settings: JointSettings | None = None) -> None:
        if settings is not None and not isinstance(settings, JointSettings):
            raise InvalidValueError(f"the settings must be JointSettings, not {type(settings).__name__}")
        self.rig = rig
        self._lock = threading.Condition()
        self._waiting: list[Sweep] = []
        self._last: Sweep | None = None
        self._added = 0
        self._is_busy = self._is_closed = False
        self._snapshot = _Snapshot(feature_map=FeatureMap(method="joint"), sweeps=0, map_from_odom=np.zeros(3))
        self._failure: BaseException | None = None
        self._process = ProcessPoolExecutor(
            1, mp_context=get_context("spawn"), initializer=_begin, initargs=(rig, settings or JointSettings())
        )
        # The process starts now, and not with the first sweep.
        self._start = self._process.submit(bool)

    def __enter__(self) -> Self:
        """Begin to map."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        """End the process."""
        self.close()

    def add(self, sweep: Sweep) -> None:
        """Take one more sweep; one without pings says nothing.

        Parameters
        ----------
        sweep : Sweep
            Pings of one pass of the array.

        Raises
        ------
        UnknownNameError
            If a sensor id is not of the rig.
        InvalidValueError
            If the sweep does not follow the one before in index and time.
        EchoplanError
            If an earlier sweep could not be mapped, or the process was ended.
        """
        self._check()
        if not len(sweep):
            return
        self.rig.indices(sweep.sensor_ids)
        with self._lock:
            check_order(self._last, sweep)
            self._last = sweep
            self._waiting.append(sweep)
            self._added += 1
            if not self._is_busy:
                self._map_waiting()
        self._check()

    def result(self) -> FeatureMap:
        """Return the newest map, which may lack the last ``behind`` sweeps; an empty one before the first.

        Returns
        -------
        FeatureMap
            In the frame of the sweeps.

        Raises
        ------
        EchoplanError
            If a sweep could not be mapped.
        """
        self._check()
        return self._snapshot.feature_map

    @property
    def map_from_odom(self) -> FloatArray:
        """Pose of the frame of odometry in that of the newest map [m, m, rad], shape (3,); zero before the first.

        Where the robot is now: ``compose(map_from_odom, odom_from_base)``, with what odometry says at this moment.
        """
        return self._snapshot.map_from_odom.copy()

    @property
    def behind(self) -> int:
        """Number of sweeps that are not yet in the newest map."""
        return self._added - self._snapshot.sweeps

    def finish(self, timeout: float | None = None) -> FeatureMap:
        """Wait until all sweeps are mapped.

        Parameters
        ----------
        timeout : float, optional
            How long to wait at most [s].

        Returns
        -------
        FeatureMap
            The map of all sweeps, the same as ``JointMapper`` makes of them.

        Raises
        ------
        TimeoutError
            If it takes longer.
        EchoplanError
            If a sweep could not be mapped.
        """
        with self._lock:
            is_done = self._lock.wait_for(lambda: not self._is_busy, timeout)
        if not is_done:
            raise TimeoutError(f"{self.behind} sweeps are not mapped after {timeout:g} s")
        return self.result()

    def close(self) -> None:
        """End the process, once it has made the map that it is making; what is not mapped yet is lost."""
        with self._lock:
            self._is_closed = True
            self._waiting.clear()
        self._process.shutdown(wait=True, cancel_futures=True)

    def _map_waiting(self) -> None:
        try:
            mapping = self._process.submit(_mapped, self._waiting)
        except BrokenProcessPool as error:
            self._failure = error
            return
        self._waiting, self._is_busy = [], True
        mapping.add_done_callback(self._take)

    def _take(self, done: Future[_Snapshot]) -> None:
        """Keep a new map, and let the sweeps that came in the meantime be mapped."""
        with self._lock:
            self._is_busy = False
            if not done.cancelled():
                self._failure = done.exception()
                if self._failure is None:
                    self._snapshot = done.result()
                    if self._waiting:
                        self._map_waiting()
            self._lock.notify_all()

    def _check(self) -> None:
        """Raise what went wrong since the last call."""
        if self._is_closed:
            raise EchoplanError("the mapper is closed; make a new one")
        if isinstance(self._failure, BrokenProcessPool):
            if self._start.exception() is None:
                raise EchoplanError("the process that maps was ended from outside; make a new mapper")
            remedy = 'in a script, put the calls below `if __name__ == "__main__":`'
            raise EchoplanError(f"the process that maps could not start; {remedy}")
        if isinstance(self._failure, EchoplanError):
            raise self._failure
        if self._failure is not None:
            raise EchoplanError(f"the process that maps failed: {self._failure!r}")


# The mapper of the process: the functions that an executor calls there share nothing else.
_mapper: list[LocalMapper] = []


def _begin(rig: Rig, settings: JointSettings) -> None:
    prepare_process()
    _mapper.append(LocalMapper(JointMapper(rig, settings), rig))


def _mapped(sweeps: Sequence[Sweep]) -> _Snapshot:
    """Add sweeps to the mapper of this process, and return the map of all."""
    (mapper,) = _mapper
    for sweep in sweeps:
        mapper.add(sweep)
    found = mapper.result()
    return _Snapshot(
        feature_map=found,
        sweeps=len(found.sweeps),
        map_from_odom=compose(found.poses[-1], invert(sweeps[-1].station)),
    )
