"""A device as a feed: it sweeps when a viewer asks for it, or at each station of a route that it drives."""

import time
from collections import deque
from collections.abc import Callable, Iterator
from queue import Empty, SimpleQueue
from threading import Event as Flag
from threading import Thread

from echoplan.arrays import FloatArray
from echoplan.errors import EchoplanError
from echoplan.hardware.driver import Device
from echoplan.hardware.messages import Begin, Echo, Record
from echoplan.hardware.port import Port, open_port
from echoplan.hardware.readings import Timed, sweep_of
from echoplan.live.feed import Complete, Control, Event, Notice, Partial
from echoplan.model import Conventions, Rig

__all__ = ["DeviceFeed"]

# Time between two events of one sweep; without a record for so long, a device that sweeps is not there [s].
_MOMENT, _SILENCE = 0.1, 3.0


class DeviceFeed:
    """A feed of the sweeps of a device.

    Parameters
    ----------
    address : str
        ``serial:///dev/ttyUSB0`` or ``tcp://echoplan.local:4000``.
    rig : Rig
        Its sensors.
    conventions : Conventions, optional
        How its servo angles are counted.
    sweeps : int, optional
        Sweeps at each station.
    connect : callable, optional
        What opens the port.

    Raises
    ------
    InputError
        If the port cannot be opened, or no device answers.
    """

    def __init__(
        self,
        address: str,
        *,
        rig: Rig,
        conventions: Conventions | None = None,
        sweeps: int = 1,
        connect: Callable[[str], Port] = open_port,
    ) -> None:
        self.name = address
        self.rig = rig
        self._conventions = conventions or Conventions()
        self._sweeps = sweeps
        self._events: SimpleQueue[Event | None] = SimpleQueue()
        # Poses at which to sweep; None ends the work.
        self._requests: SimpleQueue[FloatArray | None] = SimpleQueue()
        self._pending: list[Timed] = []
        self._shown_ns = deque([0], maxlen=1)
        self._closed, self._playing, self._busy = Flag(), Flag(), Flag()
        self._playing.set()
        self._device = Device(address, watch=self._watch, connect=connect)
        self._pose = deque([self._device.pose], maxlen=1)
        # Without the geometry of its wheels, nobody knows where it has driven.
        self._drives = "drive" in self._device.capabilities and self._device.wheels is not None

    @property
    def controls(self) -> frozenset[Control]:
        """It sweeps where it is put; a route that it drives can be paused at each station."""
        return frozenset({Control.SWEEP, Control.PAUSE} if self._drives else {Control.SWEEP})

    def events(self) -> Iterator[Event]:
        """Yield what the device measures until it is closed, and say so if it does not answer."""
        Thread(target=self._work, name="echoplan device", daemon=True).start()
        is_lost = False
        while not self._closed.is_set():
            try:
                event = self._events.get(timeout=_SILENCE)
            except Empty:
                if self._busy.is_set() and not is_lost:
                    is_lost = True
                    yield Notice(text="The device does not answer; trying again.", is_problem=True)
                continue
            if event is None:
                return
            if is_lost and isinstance(event, Partial | Complete):
                is_lost = False
                yield Notice(text="The device answers again.")
            yield event

    def place(self, map_from_base: FloatArray) -> None:
        """Set where the device stands."""
        self._pose.append(map_from_base)

    def sweep(self) -> None:
        """Ask for the sweeps of one station from there."""
        self._requests.put(self._pose[0])

    def play(self, *, playing: bool) -> None:
        """Drive on, or stay at the next station."""
        if playing:
            self._playing.set()
        else:
            self._playing.clear()

    def close(self) -> None:
        """End ``events``; the device completes the sweep that it makes."""
        self._closed.set()
        self._playing.set()
        self._requests.put(None)
        self._events.put(None)

    def _work(self) -> None:
        """Make the sweeps, in a thread of its own: the driver waits for the device."""
        with self._device:
            if self._drives:
                self._try_to(self._drive)
            while (pose := self._requests.get()) is not None:
                self._device.place(pose)
                self._try_to(self._sweep)

    def _try_to(self, work: Callable[[], None]) -> None:
        try:
            work()
        except EchoplanError as error:
            self._events.put(Notice(text=str(error), is_problem=True))

    def _drive(self) -> None:
        """Sweep at each station of the route of the device."""
        self._sweep()
        while not self._closed.is_set() and self._device.move():
            self._sweep()
            self._playing.wait()
        self._events.put(Notice(text="The device has driven its route."))

    def _sweep(self) -> None:
        self._busy.set()
        try:
            for sweep in self._device.sweeps(self._sweeps, rig=self.rig):
                self._pending.clear()
                self._events.put(Complete(sweep=self._conventions.apply(sweep)))
                if self._closed.is_set():
                    return
        finally:
            self._busy.clear()

    def _watch(self, record: Record) -> None:
        """Show the pings of a sweep that is being made."""
        now_ns = time.time_ns()
        if isinstance(record, Begin):
            self._pending.clear()
        if isinstance(record, Echo):
            self._pending.append(Timed(record=record, stamp_ns=now_ns))
            if now_ns - self._shown_ns[0] >= _MOMENT * 1e9:
                self._shown_ns.append(now_ns)
                sweep = sweep_of(self._pending, index=0, rig=self.rig, poses=[(now_ns, self._device.pose)])
                self._events.put(Partial(sweep=self._conventions.apply(sweep)))
