"""A running ROS 2 as a feed: its robot drives by itself, and gets the map that grows."""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from threading import Event as Flag

from echoplan.arrays import FloatArray
from echoplan.errors import EchoplanError
from echoplan.geometry import compose, identity, invert
from echoplan.io.ros import BagOptions
from echoplan.io.ros.series import Role, Row
from echoplan.io.ros.wire import (
    Advance,
    Incoming,
    Listening,
    MapPublisher,
    Transport,
    Window,
    WireAddress,
    advance,
    open_transport,
    wait_for_sweeps,
)
from echoplan.live.feed import Complete, Control, Event, Notice, Partial
from echoplan.live.mapping import MapUpdate
from echoplan.model import Rig

__all__ = ["Ros2Feed"]

# After so long without a reading, the current sweep is over, and the page says so [s].
_SILENCE, _QUIET = 2.0, "No readings come."
# After a fault, messages of all sensors are awaited for so long [s].
_RECOVERY = 5.0


class Ros2Feed:
    """A feed of the sweeps of a robot with ROS 2, to which it publishes the map.

    Parameters
    ----------
    address : WireAddress
        Where the robot is.
    options : BagOptions, optional
        Which topics and fields to read; by default they are found by their types.
    report : callable, optional
        Is given a line about what is missing, while it waits for the first messages.
    connect : callable, optional
        What joins the network.

    Raises
    ------
    InputError
        If the network cannot be joined, or ranges, mountings or poses are missing.
    UnknownNameError
        If a topic that the user names is not there.
    MissingExtraError
        If cyclonedds, eclipse-zenoh or rosbags is not installed.
    """

    def __init__(
        self,
        address: WireAddress,
        *,
        options: BagOptions | None = None,
        report: Callable[[str], None] = lambda line: None,  # noqa: ARG005 - nobody listens
        connect: Callable[[WireAddress], Transport] = open_transport,
    ) -> None:
        self.name = address.text
        self._address = address
        self._transport = connect(address)
        with ExitStack() as undone:
            undone.callback(self._transport.close)
            self._incoming = Incoming(self._transport, options or BagOptions())
            start = wait_for_sweeps(self._incoming, address, report=report)
            # Nobody else may place the frame of odometry.
            world = "" if start.advanced.world_parent else start.advanced.world
            self._publisher = MapPublisher(self._transport, world=world)
            undone.pop_all()
        self._listening, self._first = start.listening, start.advanced
        self._rig = replace(start.advanced.rig, name=f"sensors at {address.text}")
        # Where odometry had the robot in each sweep, by the time of its last ping [ns].
        self._odom_from_base: dict[int, FloatArray] = {}
        self._map_from_odom = identity()
        self._closed = Flag()

    @property
    def rig(self) -> Rig:
        """The sensors as the messages have described them so far."""
        return self._rig

    @property
    def notes(self) -> tuple[str, ...]:
        """What the user should know about how the first messages were read, and what others publish, too."""
        notes, world, parent = [*self._first.notes], self._first.world, self._first.world_parent
        if parent:
            notes.append(f"The transform from {parent} to {world} comes from another program; echoplan publishes none.")
        if any(topic.name == "/map" for topic in self._listening.topics):
            notes.append("Another program publishes /map, too: stop it, or subscribers get two maps.")
        return tuple(notes)

    @property
    def controls(self) -> frozenset[Control]:
        """Nothing: other programs drive the robot."""
        return frozenset()

    def events(self) -> Iterator[Event]:
        """Yield sweeps as their messages come, until it is closed."""
        yield from self._taken(self._first)
        reception, problem, last_reading = _Reception(self._first.window, self._listening), "", time.monotonic()
        while not self._closed.is_set():
            before, now = problem, time.monotonic()
            try:
                rows = self._incoming.rows()
                is_new = Role.READING in {row.key.role for row in rows}
                last_reading = now if is_new else last_reading
                is_quiet = now - last_reading > _SILENCE
                advanced = reception.take(rows, is_silent=is_quiet)
            except EchoplanError as error:
                problem = str(self._incoming.explained(error, self._address))
            else:
                yield from self._taken(advanced)
                problem = _problem_after(advanced, before, is_new=is_new, is_quiet=is_quiet)
            if problem != before:
                yield Notice(text=problem or "Readings come again.", is_problem=bool(problem))

    def place(self, map_from_base: FloatArray) -> None:
        """Do nothing: odometry knows where the robot is."""

    def sweep(self) -> None:
        """Do nothing: the sensors of the robot measure by themselves."""

    def play(self, *, playing: bool) -> None:
        """Do nothing: other programs drive the robot."""

    def publish(self, update: MapUpdate) -> None:
        """Publish a new map, and where odometry lies in it."""
        for stamp_ns in [each for each in self._odom_from_base if each < update.last_ns]:
            del self._odom_from_base[stamp_ns]
        odom_from_base = self._odom_from_base.get(update.last_ns)
        if odom_from_base is not None:
            self._map_from_odom = compose(update.map_from_base, invert(odom_from_base))
        self._publisher.publish(update.feature_map, grid=update.grid, map_from_odom=self._map_from_odom)

    def close(self) -> None:
        """End ``events`` and leave the network."""
        self._closed.set()
        self._publisher.close()
        self._transport.close()

    def _taken(self, advanced: Advance | None) -> Iterator[Event]:
        """Yield the sweeps that new messages brought."""
        if advanced is None:
            return
        self._rig = replace(advanced.rig, name=self._rig.name)
        self._publisher.set_clock(advanced.clock_offset_ns)
        for sweep in advanced.finished:
            self._odom_from_base[int(sweep.stamps_ns[-1])] = sweep.station
            yield Complete(sweep=sweep)
        if advanced.partial is not None:
            yield Partial(sweep=advanced.partial)


class _Reception:
    """Cuts sweeps from messages, and begins anew after a fault, such as a jump of the clock.

    Then messages wait until all sensors came again, for some seconds: some fire once a second only.
    """

    def __init__(self, window: Window, listening: Listening) -> None:
        self._window = window
        self._listening = listening
        self._waiting: list[Row] = []
        self._begun_anew = -math.inf

    def take(self, rows: Sequence[Row], *, is_silent: bool) -> Advance | None:
        """Return what messages bring; None while they wait for others."""
        now = time.monotonic()
        try:
            advanced = advance(self._window, [*self._waiting, *rows], listening=self._listening, is_silent=is_silent)
        except EchoplanError:
            if now - self._begun_anew < _RECOVERY:
                self._waiting += rows
                return None
            self._window, self._waiting, self._begun_anew = self._window.emptied(), [], now
            raise
        self._window, self._waiting, self._begun_anew = advanced.window, [], -math.inf
        return advanced


def _problem_after(advanced: Advance | None, before: str, *, is_new: bool, is_quiet: bool) -> str:
    """Return what the page says is wrong, after messages were taken."""
    if is_quiet:
        return _QUIET
    return "" if is_new and advanced is not None else before
