"""Ports: serial ports and TCP connections to devices, and the messages that come through them."""

import os
import re
import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from echoplan.errors import InputError, MissingExtraError
from echoplan.hardware.messages import Message
from echoplan.hardware.protocol import Decoder, encode

__all__ = ["Port", "Transport", "open_port", "port_names"]

_BAUD_RATE = 115_200
# A read returns this soon [s], even when nothing has arrived.
_LATENCY = 0.02
_ADDRESS = re.compile(r"serial://(?P<serial>.+)|tcp://(?P<tcp>[^:/]+:[0-9]{1,5})/?")


class Transport(Protocol):
    """Bytes to and from a device; a lost connection raises ``OSError``."""

    def read(self) -> bytes:
        """Return what has arrived, after a few milliseconds at the latest."""
        ...

    def write(self, data: bytes) -> None:
        """Send bytes."""
        ...

    def close(self) -> None:
        """Close the connection."""
        ...


class Port:
    """Messages to and from a device.

    Parameters
    ----------
    name : str
        The address, for messages.
    transport : Transport
        The bytes.
    clock : callable, optional
        Time of the host [s], from any origin.
    """

    def __init__(self, *, name: str, transport: Transport, clock: Callable[[], float] = time.monotonic) -> None:
        self.name = name
        self.clock = clock
        self._transport = transport
        self._decoder = Decoder()
        # When the last line arrived, whole or damaged.
        self._arrived = deque([clock()], maxlen=1)
        # Records that arrived while the answer to a command was awaited; a device sends them again if some are dropped.
        self.early = deque[Message](maxlen=256)

    @property
    def silence(self) -> float:
        """Time since the last line arrived, whole or damaged [s]."""
        return self.clock() - self._arrived[0]

    @property
    def damaged(self) -> int:
        """Number of damaged lines that were dropped."""
        return self._decoder.damaged

    def send(self, message: Message) -> None:
        """Send a message; ``OSError`` if the connection is lost."""
        self._transport.write(encode(message))

    def receive(self) -> Iterator[Message]:
        """Yield the messages that have arrived; ``OSError`` if the connection is lost."""
        lines = self._decoder.lines
        yield from self._decoder.feed(self._transport.read())
        if self._decoder.lines > lines:
            self._arrived.append(self.clock())

    def close(self) -> None:
        """Close the connection."""
        self._transport.close()


class _SerialTransport:
    """A serial port or a TCP connection by pyserial."""

    def __init__(self, url: str) -> None:
        import serial  # noqa: PLC0415 - pyserial is optional

        self._port = serial.serial_for_url(url, baudrate=_BAUD_RATE, timeout=_LATENCY, write_timeout=1.0)

    def read(self) -> bytes:
        """Return what has arrived, after 20 ms at the latest."""
        data: bytes = self._port.read(4096)
        return data

    def write(self, data: bytes) -> None:
        """Send bytes, and wait for at most one second until they are sent."""
        self._port.write(data)

    def close(self) -> None:
        """Close the port or the connection."""
        self._port.close()


def port_names() -> tuple[str, ...]:
    """Return the serial ports of this computer.

    Returns
    -------
    tuple of str
        Their names.

    Raises
    ------
    MissingExtraError
        If pyserial is not installed.
    """
    with _pyserial():
        from serial.tools.list_ports import comports  # noqa: PLC0415 - pyserial is optional
    return tuple(sorted(port.device for port in comports()))


def open_port(address: str) -> Port:
    """Open a port.

    Raises ``InputError`` if it cannot be opened, ``MissingExtraError`` if pyserial is not installed.
    """
    found = _ADDRESS.fullmatch(address)
    if found is None:
        remedy = "write serial:///dev/ttyUSB0 or tcp://echoplan.local:4000"
        raise InputError(address, "it is not the address of a device", remedy=remedy)
    with _pyserial():
        try:
            transport = _SerialTransport(found["serial"] or f"socket://{found['tcp']}")
        except (OSError, ValueError) as error:
            # pyserial states the error of the system as a number or in its text; a bad address is a ValueError.
            number = getattr(error, "errno", None)
            reasons = [os.strerror(number)] if number else re.findall(r"\[Errno -?\d+\] ([^:']+)", str(error))
            reason = reasons[-1] if reasons else str(error).partition(": ")[0]
            remedy = "check that the device is switched on and in the same network"
            if found["serial"]:
                remedy = f"check the cable; the serial ports are: {', '.join(port_names()) or 'none'}"
            raise InputError(address, f"it cannot be opened: {reason}", remedy=remedy) from error
    return Port(name=address, transport=transport)


@contextmanager
def _pyserial() -> Iterator[None]:
    try:
        yield
    except ModuleNotFoundError as error:
        raise MissingExtraError("pyserial", extra="device") from error
