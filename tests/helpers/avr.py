"""A simulated Arduino Uno that runs the firmware, with ultrasonic sensors whose echoes a function answers."""

import importlib.util
import os
import pty
import shutil
import subprocess
import threading
import time
import tty
from collections import Counter, deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import pytest

BUILD = Path(__file__).parents[2] / "firmware" / "arduino" / "build"
MEGAHERTZ = 16
# Cycles from byte to byte on the serial port.
FRAME = 1360
# An HC-SR04 raises its echo pin this long after the trigger [us], and lowers it after the timeout if no echo comes.
RESPONSE_US, TIMEOUT_US = 460, 38_000
# The pins of config.h as the processor names them.
TRIGGERS = ("PD2", "PD3", "PD4", "PD5")
ECHOES = ("PC0", "PC1", "PC2", "PC3")
DISCONNECTED = -1.0

Flight = Callable[[int, float, float], float | None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Answer:
    """What a sensor answered to a trigger: the last pulse of the servo, the time since the start, the flight [us]."""

    sensor: int
    pulse_us: float
    clock_us: float
    flight_us: float | None


def skip_without_compiler() -> None:
    """Skip a test that builds the firmware where that is not possible."""
    if shutil.which("avr-g++") is None or not Path("/usr/share/arduino/hardware/arduino/avr").is_dir():
        pytest.skip("avr-g++ or Arduino's core is missing: apt-get install arduino-core-avr")


def skip_without_simulator() -> None:
    """Skip a test that runs the firmware where that is not possible."""
    skip_without_compiler()
    if importlib.util.find_spec("yasimavr") is None:
        pytest.skip("yasimavr is missing: apt-get install g++ libelf-dev, then install the group 'firmware'")


def build(folder: Path, *, name: str = "uno", **changes: object) -> Path:
    """Build the firmware with changed lines of config.h; return the program, beside which is what the build printed."""
    command = [str(BUILD), str(folder), *(f"{key}={value}" for key, value in changes.items())]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    (folder / f"{name}.txt").write_text(done.stdout)
    return (folder / "echohead.elf").rename(folder / f"{name}.elf")


class Uno:
    """A simulated Uno; time passes only in ``run``.

    ``flight(sensor, pulse_us, clock_us)`` answers a trigger, from the last pulse of the servo and the time since the
    start: a time of flight [us], None if no echo comes, or ``DISCONNECTED``.
    """

    def __init__(self, program: Path, *, flight: Flight) -> None:
        from yasimavr.device_library import load_device  # noqa: PLC0415 - only here, and where it is installed
        from yasimavr.lib import core  # noqa: PLC0415
        from yasimavr.lib.arch_avr import ArchAVR_Timer  # noqa: PLC0415
        from yasimavr.utils.uart import UART, UART_IO  # noqa: PLC0415

        self._core = core
        self._device = load_device("atmega328p")
        self._firmware = core.Firmware.read_elf(str(program))
        self._firmware.frequency = 1_000_000 * MEGAHERTZ
        self._firmware.vcc = self._firmware.aref = 5.0
        self._loop = core.SimLoop(self._device)
        self._loop.set_fast_mode(True)
        self._device.load_firmware(self._firmware)
        self._uart = UART_IO(self._device, 0)
        self._lock = threading.RLock()
        self._flight = flight
        self._times = Counter[str]()
        self._echoes = [_Echo(core, self.pin(name)) for name in ECHOES]
        self._to_arrive: deque[int] = deque()
        self._arrivals = _timer(core, self._deliver)
        self._hooks: list[Any] = []
        self._errors: deque[Exception] = deque()
        self.answers: deque[Answer] = deque()
        change = core.Pin.SignalId.DigitalChange
        for sensor, name in enumerate(TRIGGERS):
            self._watch(self.pin(name).signal(), change, partial(self._trigger, sensor))
        # The simulated timer does not reach the pin: its output A is D9.
        _, timer = self._device.ctlreq(core.IOCTL_TIMER("_", "1"), core.CTLREQ_GET_SIGNAL)
        self._watch(timer.data.value(core.Signal), ArchAVR_Timer.SignalId.CompOutput, self._measure_pulse)
        _, port = self._device.ctlreq(core.IOCTL_UART("0"), core.CTLREQ_GET_SIGNAL)
        self._watch(port.data.value(core.Signal), UART.SignalId.TX_Start, self._note_frame)

    @property
    def clock_us(self) -> float:
        """Time since the start [us]."""
        return float(self._loop.cycle()) / MEGAHERTZ

    @property
    def pulse_us(self) -> float:
        """Length of the last pulse of the servo [us]."""
        return (self._times["pulse end"] - self._times["pulse"]) / MEGAHERTZ

    def pin(self, name: str) -> Any:
        """Return a pin by the name that the processor has for it."""
        return self._device.find_pin(name)

    def set_pin(self, name: str, *, is_high: bool) -> None:
        """Connect a pin to the supply or to the ground."""
        with self._lock:
            self.pin(name).set_external_state("H" if is_high else "L")

    def set_voltage(self, name: str, volts: float) -> None:
        """Connect a pin to a voltage."""
        with self._lock:
            self.pin(name).set_external_state("A", volts / 5)

    def run(self, milliseconds: float) -> None:
        """Let time pass."""
        with self._lock:
            self._loop.run(max(round(1000 * MEGAHERTZ * milliseconds), 1))
        if self._errors:
            raise self._errors.popleft()

    def write(self, data: bytes) -> None:
        """Send bytes to the serial port; they arrive at its speed."""
        with self._lock:
            if not self._to_arrive:
                self._loop.cycle_manager().schedule(self._arrivals, self._loop.cycle() + 1)
            self._to_arrive.extend(data)

    def read(self) -> bytes:
        """Return the bytes that the serial port has sent."""
        with self._lock:
            data: bytes = self._uart.read(self._uart.available())
            return data

    def reset(self) -> None:
        """Press the reset button."""
        with self._lock:
            self._device.reset(self._core.Device.ResetFlag.Ext)

    def set_clock(self, microseconds: int) -> None:
        """Set the clock of the firmware."""
        (symbol,) = (each for each in self._firmware.symbols() if each.name.startswith("timer0_overflow_count"))
        with self._lock:
            probe = self._core.DeviceDebugProbe(self._device)
            # The timer overflows every 1024 us.
            probe.write_data(symbol.addr, (microseconds // 1024).to_bytes(4, "little"))
            probe.detach()

    def _watch(self, signal: Any, kind: Any, call: Callable[[int], None]) -> None:
        def raised(event: Any, _: int) -> None:
            # A reset sends an event without a state.
            if event.sigid == kind and event.data.type() == self._core.vardata_t.Type.Uinteger:
                try:
                    call(event.data.as_uint())
                except Exception as error:  # noqa: BLE001 - the simulator would end the program: ``run`` raises it
                    self._errors.append(error)

        self._hooks.append(self._core.CallableSignalHook(raised))
        signal.connect(self._hooks[-1])

    def _measure_pulse(self, level: int) -> None:
        if level:
            self._times["pulse start"] = self._loop.cycle()
        elif self._times["pulse start"]:
            self._times["pulse"] = self._times["pulse start"]
            self._times["pulse end"] = self._loop.cycle()

    def _note_frame(self, _: int) -> None:
        self._times["frame"] = self._loop.cycle()

    def _deliver(self, when: int) -> int:
        """Let the next byte arrive, and return when to call again.

        The simulated port has one register for both directions: a byte that arrives while the firmware writes the next
        one is lost. The firmware does so at the beginning of a frame.
        """
        sent = when - self._times["frame"]
        if sent < FRAME and not FRAME // 4 < sent < FRAME * 3 // 4:
            return when + FRAME // 4
        self._uart.write(self._to_arrive.popleft())
        return when + FRAME + FRAME // 100 if self._to_arrive else 0

    def _trigger(self, sensor: int, level: int) -> None:
        now, name, echo = self._loop.cycle(), f"trigger {sensor}", self._echoes[sensor]
        if level:
            self._times[name] = now
        elif self._times[name] and now - self._times[name] >= 9 * MEGAHERTZ and not echo.is_busy:
            flight = self._flight(sensor, self.pulse_us, self.clock_us)
            answer = Answer(sensor=sensor, pulse_us=self.pulse_us, clock_us=self.clock_us, flight_us=flight)
            self.answers.append(answer)
            if flight != DISCONNECTED:
                echo.answer(TIMEOUT_US if flight is None else flight)
                self._loop.cycle_manager().schedule(echo.timer, now + RESPONSE_US * MEGAHERTZ)


class _Echo:
    """An echo pin, which goes high for the time of flight."""

    def __init__(self, core: Any, pin: Any) -> None:
        self._pin = pin
        self._flights: deque[float] = deque()
        self.timer = _timer(core, self._change)
        pin.set_external_state("L")

    @property
    def is_busy(self) -> bool:
        return bool(self._flights)

    def answer(self, flight_us: float) -> None:
        """Take the flight for which the pin goes high when the timer runs out."""
        self._flights.append(flight_us)

    def _change(self, when: int) -> int:
        is_rising = not self._pin.digital_state()
        self._pin.set_external_state("H" if is_rising else "L")
        if is_rising:
            return when + round(self._flights[0] * MEGAHERTZ)
        self._flights.clear()
        return 0


def _timer(core: Any, call: Callable[[int], int]) -> Any:
    """Return a timer that calls a function, which returns when it is to be called again; 0: never."""

    class Timer(core.CycleTimer):  # type: ignore[misc]
        def next(self, when: int) -> int:
            return call(when)

    return Timer()


@contextmanager
def serial_port(uno: Uno) -> Iterator[str]:
    """Connect the serial port of an Uno to a pseudo terminal, and yield its name; its time passes as fast as it can."""
    master, slave = pty.openpty()
    tty.setraw(master)
    tty.setraw(slave)
    os.set_blocking(master, False)
    is_over = threading.Event()
    with ThreadPoolExecutor(1) as executor:
        pumping = executor.submit(_pump, uno, master, is_over=is_over)
        try:
            yield os.ttyname(slave)
        finally:
            is_over.set()
            pumping.result()
            os.close(master)
            os.close(slave)


def _pump(uno: Uno, master: int, *, is_over: threading.Event) -> None:
    pending = b""
    while not is_over.is_set():
        # A full terminal stops the time of the device rather than losing bytes.
        if not pending:
            uno.run(1)
            pending = uno.read()
        try:
            pending = pending[os.write(master, pending) :] if pending else b""
        except BlockingIOError:
            time.sleep(0.001)
        with suppress(BlockingIOError):
            uno.write(os.read(master, 256))
