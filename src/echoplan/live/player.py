"""Sources that are played: a recording, a bag or a simulation, ping by ping as if it were being recorded."""

from collections import deque
from collections.abc import Iterator
from dataclasses import replace
from queue import Empty, SimpleQueue
from threading import Event as Flag
from time import monotonic

import numpy as np

from echoplan.arrays import FloatArray, checked_number
from echoplan.live.feed import Complete, Control, Event, Notice, Partial
from echoplan.model import Rig, Route, Source, Sweep
from echoplan.simulation import Simulation

__all__ = ["Player", "SimulationPlayer"]

# Time between two events of one sweep: the page shows ten frames a second [s].
_MOMENT = 0.1
# Longest wait between two sweeps: the drive from station to station need not be watched [s].
_LONGEST_WAIT = 0.5


class Player:
    """A feed that plays a source by its stamps.

    Parameters
    ----------
    source : Source
        The sweeps.
    speed : float, optional
        How many times faster than they were recorded.

    Raises
    ------
    InvalidValueError
        If the speed is not positive.
    """

    def __init__(self, source: Source, *, speed: float = 1.0) -> None:
        checked_number(speed, name="speed", above=0.0)
        self._source = source
        self._speed = speed
        self._closed = Flag()
        self._playing = Flag()
        self._playing.set()

    @property
    def name(self) -> str:
        """Name of the source."""
        return self._source.name

    @property
    def rig(self) -> Rig:
        """Rig of the source."""
        return self._source.rig

    @property
    def controls(self) -> frozenset[Control]:
        """What is recorded can be paused, and no more."""
        return frozenset({Control.PAUSE})

    def events(self) -> Iterator[Event]:
        """Play all sweeps, with pauses between stations shortened."""
        yield from self._played()
        if not self._closed.is_set():
            yield Notice(text="All of the recording has been played.")

    def place(self, map_from_base: FloatArray) -> None:
        """Do nothing: a recording knows where its sweeps were made."""

    def sweep(self) -> None:
        """Do nothing: a recording cannot make new sweeps."""

    def play(self, *, playing: bool) -> None:
        """Go on, or pause."""
        if playing:
            self._playing.set()
        else:
            self._playing.clear()

    def close(self) -> None:
        """End ``events``."""
        self._closed.set()
        self._playing.set()

    def _played(self) -> Iterator[Event]:
        before_ns: int | None = None
        for sweep in self._source:
            if not len(sweep):
                continue
            if before_ns is not None:
                gap = (int(sweep.stamps_ns[0]) - before_ns) / 1e9 / self._speed
                self._closed.wait(min(gap, _LONGEST_WAIT))
            self._playing.wait()
            yield from self._pings_of(sweep)
            if self._closed.is_set():
                return
            before_ns = int(sweep.stamps_ns[-1])
            yield Complete(sweep=sweep)

    def _pings_of(self, sweep: Sweep) -> Iterator[Event]:
        """Yield the pings so far, every moment, until the sweep is complete or the feed is closed."""
        seconds = (sweep.stamps_ns - sweep.stamps_ns[0]) / 1e9 / self._speed
        elapsed, before = 0.0, monotonic()
        while elapsed < seconds[-1]:
            yield Partial(sweep=sweep[: int(np.searchsorted(seconds, elapsed, side="right"))])
            if self._closed.wait(min(_MOMENT, seconds[-1] - elapsed)):
                return
            now = monotonic()
            elapsed += now - before
            before = now
            if not self._playing.is_set():
                self._playing.wait()
                before = monotonic()


class SimulationPlayer(Player):
    """A feed that plays a simulation, and then simulates a sweep wherever a viewer asks for one.

    Parameters
    ----------
    source : Simulation
        The simulation.
    speed : float, optional
        How many times faster than in reality.
    """

    def __init__(self, source: Simulation, *, speed: float = 1.0) -> None:
        super().__init__(source, speed=speed)
        self._simulation = source
        self._pose = deque([source.route.map_from_base[0]], maxlen=1)
        self._requested: SimpleQueue[FloatArray] = SimpleQueue()

    @property
    def controls(self) -> frozenset[Control]:
        """A simulated robot sweeps wherever it is put."""
        return frozenset({Control.PAUSE, Control.SWEEP})

    def events(self) -> Iterator[Event]:
        """Play all sweeps, and between and after them what viewers ask for."""
        for event in self._played():
            yield event
            if isinstance(event, Complete):
                yield from self._asked_for()
        yield Notice(text="The route has been driven. Put the robot anywhere and sweep there.")
        while not self._closed.wait(_MOMENT):
            yield from self._asked_for()

    def place(self, map_from_base: FloatArray) -> None:
        """Put the robot somewhere else."""
        self._pose.append(map_from_base)

    def sweep(self) -> None:
        """Ask for one sweep from where the robot is."""
        self._requested.put(self._pose[0])

    def _asked_for(self) -> Iterator[Event]:
        while not self._closed.is_set():
            try:
                pose = self._requested.get_nowait()
            except Empty:
                return
            # Other noise for each request, even from the same place.
            seed = self._simulation.seed + 1 + round(monotonic() * 1e6)
            there = replace(self._simulation, route=Route(map_from_base=pose[None]), seed=seed)
            for sweep in there:
                yield from self._pings_of(sweep)
                if not self._closed.is_set():
                    yield Complete(sweep=sweep)
