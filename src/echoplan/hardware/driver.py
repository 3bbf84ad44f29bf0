"""The driver of a device: complete sweeps, whatever happens to the connection."""

import logging
import math
import time
from collections import Counter, deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from itertools import count
from threading import Thread
from typing import Self

from echoplan.acoustics import Air
from echoplan.arrays import FloatArray
from echoplan.errors import EchoplanError, InputError, InvalidValueError
from echoplan.geometry import identity
from echoplan.hardware.jobs import ask, change_setting, current_job, end_job, identify, records_of, settings_of
from echoplan.hardware.messages import Accepted, Begin, Done, End, Hello, Move, Record, Refused, Stop, Sweeps, Wheels
from echoplan.hardware.port import Port, open_port, port_names
from echoplan.hardware.readings import Timed, Track, Wheelbase, driven, sweep_of, timed
from echoplan.model import Firing, Rig, Sweep

__all__ = ["Device", "device_settings", "find_device"]

_LOG = logging.getLogger(__name__)
# A lost connection is tried again this often [s], and one that was never made whole so many times.
_AGAIN, _ATTEMPTS = 0.5, 5
# Time between the pings of a rig that does not state it [s]: HC-SR04 need that long.
_PERIOD = 0.06
# No job has this number.
_RESET = -1


class Device:
    """A connected device: a context manager that makes complete sweeps.

    Parameters
    ----------
    address : str
        ``serial:///dev/ttyUSB0`` or ``tcp://echoplan.local:4000``.
    watch : callable, optional
        What is called with every record as it arrives.
    connect : callable, optional
        What opens the port.

    Raises
    ------
    InputError
        If the port cannot be opened, or no device answers.
    MissingExtraError
        If pyserial is not installed.
    """

    def __init__(
        self,
        address: str,
        *,
        watch: Callable[[Record], None] = lambda _: None,
        connect: Callable[[str], Port] = open_port,
    ) -> None:
        self.address = address
        self._watch = watch
        self._connect = connect
        self._counts = Counter[str]()
        # Each holds its newest value only.
        self._ports = deque[Port](maxlen=1)
        self._tracks = deque([Track(pose=identity())], maxlen=1)
        self._stamps_ns = deque([0], maxlen=1)
        # The jobs that were last asked for and accepted.
        self._current, self._accepted = deque([0], maxlen=1), deque([-1], maxlen=1)
        self._ports.append(connect(address))
        self._greetings = deque[_Greeting](maxlen=1)
        with ExitStack() as undo:
            undo.callback(self.close)
            job = self._greeted()
            undo.pop_all()
        # The last job of the device may still be going on: it is not continued.
        self._jobs = (number % 65535 + 1 for number in count(job))

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def hello(self) -> Hello:
        """What the device is."""
        return self._greetings[0].hello

    @property
    def wheels(self) -> Wheelbase | None:
        """The geometry of its wheels; None if it has none, or does not state it."""
        return self._greetings[0].wheels

    @property
    def capabilities(self) -> frozenset[str]:
        """What it has: ``servo``, ``air``, ``wheels``, ``drive``."""
        return frozenset(self.hello.capabilities.split("-"))

    @property
    def pose(self) -> FloatArray:
        """Pose of the robot [m, m, rad], shape (3,): where it was placed, or driven since."""
        return self._tracks[0].pose

    @property
    def counts(self) -> Mapping[str, int]:
        """How often something went wrong: damaged lines, lost connections, interrupted sweeps."""
        return Counter({"damaged lines": sum(port.damaged for port in self._ports)}) + self._counts

    def place(self, pose: FloatArray) -> None:
        """State where the robot is, shape (3,) [m, m, rad]."""
        self._tracks.append(replace(self._tracks[0], pose=pose))

    def close(self) -> None:
        """Close the port."""
        for port in self._ports:
            port.close()

    def sweeps(self, number: int, *, rig: Rig) -> Iterator[Sweep]:
        """Yield sweeps, numbered from 0; those of a device with wheels may be made while it drives.

        A sweep that a reset or a lost connection interrupts is dropped and made again.

        Parameters
        ----------
        number : int
            How many; 0 until no more are asked for.
        rig : Rig
            Its sensors; its servo and firing become the settings of the device.

        Raises
        ------
        InputError
            If the rig does not fit the device, or the device does not answer.
        """
        self._check_fits(rig)
        settings = device_settings(rig)
        made = 0
        while not number or made < number:
            pending, poses = list[Timed](), list[tuple[int, FloatArray]]()
            command = Sweeps(job=next(self._jobs), count=max(number - made, 0))
            for each in self._job(command, settings):
                if isinstance(each.record, Begin):
                    pending, poses = [], [(each.stamp_ns, self.pose)]
                if not isinstance(each.record, Done):
                    pending.append(each)
                if isinstance(each.record, Wheels):
                    poses.append((each.stamp_ns, self.pose))
                if isinstance(each.record, End):
                    yield sweep_of(pending, index=made, rig=rig, poses=poses)
                    pending, made = [], made + 1
            self._counts["interrupted sweeps"] += bool(pending)

    def move(self) -> bool:
        """Let the device drive to its next station; False if its wheels did not turn: there is none.

        Raises
        ------
        InputError
            If the device is reset on the way, so that the pose is unknown.
        """
        counts = set[tuple[int, int]]()
        job = 0
        while job != self._accepted[0]:
            job = next(self._jobs)
            for each in self._job(Move(job=job), {}):
                if isinstance(each.record, Wheels):
                    counts.add((each.record.left, each.record.right))
                if isinstance(each.record, Done):
                    return len(counts) > 1
        remedy = "place the robot by hand and continue with --append"
        raise InputError(self.address, "the device was reset while the robot moved", remedy=remedy)

    def push(self, until: Callable[[], None]) -> None:
        """Measure by the wheels where the robot is pushed, until a call returns.

        Raises
        ------
        InputError
            If the device is reset on the way, so that the pose is unknown.
        """
        errors = list[EchoplanError]()

        def move() -> None:
            """Move, and keep the error for the thread that waits."""
            try:
                self.move()
            except EchoplanError as error:
                errors.append(error)

        # A second interrupt ends the program even if the device does not answer.
        thread = Thread(target=move, name="echoplan push", daemon=True)
        thread.start()
        try:
            until()
        finally:
            while thread.is_alive():
                # Repeated, because a line may be damaged; the thread makes a lost connection again.
                with suppress(OSError):
                    self._ports[0].send(Stop(job=self._current[0]))
                thread.join(_AGAIN)
        for error in errors:
            raise error

    def _greeted(self) -> int:
        """Greet a new device as often as it takes."""
        try:
            return self._greet()
        except OSError as error:
            return self._connect_again(error)

    def _greet(self) -> int:
        """Ask the device what it is, and return its job; 0 after a reset."""
        port = self._ports[0]
        hello = identify(port)
        wheels = wheelbase_of(port) if "wheels" in hello.capabilities.split("-") else None
        self._greetings.append(_Greeting(hello=hello, wheels=wheels))
        return current_job(port)

    def _check_fits(self, rig: Rig) -> None:
        """Refuse a rig with other sensors than those of the device, all of which fire."""
        strange = sorted(set(rig.sensor_ids.tolist()) ^ set(range(self.hello.sensors)))
        if strange:
            has = "has a" if strange[0] in rig.sensor_ids else "has no"
            problem = f"the device has {self.hello.sensors} sensors, and the rig {rig.name!r} {has} sensor {strange[0]}"
            raise InputError(self.address, problem, remedy="name a rig.toml with the sensors of this device by --rig")

    def _begin(self, command: Sweeps | Move, settings: Mapping[str, int], *, is_begun: bool) -> bool:
        """Begin a job with some settings; False if the device was reset meanwhile and lost them."""
        port = self._ports[0]
        if not is_begun:
            if end_job(port) == 0:
                self._forget_counts()
            known = settings_of(port, *settings)
            # A device refuses a start that is not before its stop: which of the two goes first depends on both.
            is_stop_first = "stop" in known and settings["stop"] > known["start"]
            for name in sorted(settings, reverse=is_stop_first):
                if settings[name] != known[name]:
                    change_setting(port, name, value=settings[name])
            answer = ask(port, command, answer=Accepted)
            if isinstance(answer, Refused):
                problem = f"the device refuses to {command.WORD} ({answer.reason})"
                raise InputError(self.address, problem, remedy="reset it, or update its firmware")
            self._accepted.append(command.job)
        return settings_of(port, *settings) == settings

    def _job(self, command: Sweeps | Move, settings: Mapping[str, int]) -> Iterator[Timed]:
        """Yield the records of a job; without ``Done`` at the end, the device was reset."""
        records = self._records(command, {**settings, "window": self.hello.window})
        # The clock of a device may be fast: times must not go back from one job to the next.
        for each in timed(records, now_ns=lambda: max(time.time_ns(), self._stamps_ns[0])):
            if isinstance(each.record, Wheels) and self.wheels is not None:
                self._tracks.append(driven(self._tracks[0], each.record, wheels=self.wheels))
            self._stamps_ns.append(each.stamp_ns)
            self._watch(each.record)
            yield each

    def _records(self, command: Sweeps | Move, settings: Mapping[str, int]) -> Iterator[Record]:
        """Begin a job and yield its records; a job that still exists after a lost connection goes on."""
        self._current.append(command.job)
        job = following = 0
        while job in (0, command.job):
            reason = None
            try:
                if not self._begin(command, settings, is_begun=bool(job)):
                    # The next job ends this one.
                    break
                for record in records_of(self._ports[0], command.job, start=following):
                    following = record.number + 1
                    yield record
                    if isinstance(record, Done):
                        return
            except OSError as error:
                reason = error
            except GeneratorExit:
                # Nobody asks for more.
                with suppress(OSError, InputError):
                    ask(self._ports[0], Stop(job=command.job), answer=Accepted)
                raise
            job = self._connect_again(reason) or _RESET
        self._forget_counts()

    def _forget_counts(self) -> None:
        """Forget the counts of the wheels, which begin at zero after a reset."""
        self._tracks.append(replace(self._tracks[0], counts=None))

    def _connect_again(self, reason: Exception | None) -> int:
        """Wait until the device answers, and return its job; 0 after a reset."""
        _LOG.warning("%s: the connection is lost (%s); trying again", self.address, reason or "the device was reset")
        self._counts["lost connections"] += 1
        for attempt in count():
            try:
                # After a reset the port is still open.
                if attempt or reason:
                    self._ports[0].close()
                    port = self._connect(self.address)
                    self._counts["damaged lines"] += self._ports[0].damaged
                    self._ports.append(port)
                job = self._greet()
            except (InputError, OSError) as error:
                if not self._greetings and attempt == _ATTEMPTS:
                    remedy = "check that the device runs the firmware of echoplan"
                    raise InputError(self.address, "the connection is lost at once", remedy=remedy) from error
                time.sleep(_AGAIN)
            else:
                break
        return job


@dataclass(frozen=True, slots=True, kw_only=True)
class _Greeting:
    """What a device reports about itself."""

    hello: Hello
    wheels: Wheelbase | None


def device_settings(rig: Rig) -> dict[str, int]:
    """Return the settings of a device that do what a rig states.

    The angles of the servo are those that the device records, before any conventions.  Raises ``InvalidValueError`` if
    no device can fire like this.
    """
    firing = rig.firing or Firing(period=_PERIOD, groups=tuple((each,) for each in rig.sensor_ids.tolist()))
    if len(firing.groups) > 1 and max(map(len, firing.groups)) > 1:
        problem = f"a device fires all sensors together or one after the other, not in groups {firing.groups}"
        raise InvalidValueError(problem)
    guard_ms = math.ceil(1000 * firing.period - 1e-6)
    flight_ms = 2000 * rig.max_ranges.max() / (rig.speed_of_sound or Air().speed_of_sound)
    settings = {
        "guard": guard_ms,
        "dwell": guard_ms * len(firing.groups),
        "together": int(len(firing.groups[0]) > 1),
        "listen": min(math.ceil(flight_ms), guard_ms),
    }
    if rig.servo is None:
        return settings
    angles = {"start": rig.servo.start, "stop": rig.servo.stop, "step": rig.servo.step}
    return settings | {name: round(100 * math.degrees(angle)) for name, angle in angles.items()}


def wheelbase_of(port: Port) -> Wheelbase | None:
    """Return the geometry of the wheels of a device; None if it does not state it."""
    values = settings_of(port, "tick", "base")
    tick, base = 1e-6 * values["tick"], 1e-4 * values["base"]
    return Wheelbase(tick=tick, width=base) if tick and base else None


def find_device() -> str:
    """Return the address of the only device that answers at a serial port.

    Raises
    ------
    InputError
        If none answers, or several do.
    MissingExtraError
        If pyserial is not installed.
    """
    answering = []
    for name in port_names():
        try:
            with Device(f"serial://{name}"):
                answering.append(f"serial://{name}")
        except (InputError, OSError) as error:
            _LOG.info("%s", error)
    if len(answering) != 1:
        problem = f"several devices answer: {', '.join(answering)}" if answering else "no device answers"
        remedy = "name one of them" if answering else "connect it, check `echoplan doctor`, or name serial:///dev/..."
        raise InputError("serial ports", problem, remedy=remedy)
    return answering[0]
