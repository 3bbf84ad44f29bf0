"""Ports: serial ports and TCP connections to devices, and the messages that come through them."""

import re
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol

from echoplan.errors import InputError, MissingExtraError
from echoplan.hardware.protocol import Decoder, Message, encode

__all__ = ["Port", "Transport", "is_device", "open_port", "port_names"]

_BAUD_RATE = 115_200
# A read returns this soon [s], even when nothing has arrived.
_LATENCY = 0.02
_ADDRESS = re.compile(r"(?P<scheme>serial|tcp)://(?P<rest>.*)")


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

    @property
    def lines(self) -> int:
        """Number of lines that arrived, damaged ones included."""
        return self._decoder.lines

    @property
    def damaged(self) -> int:
        """Number of damaged lines that were dropped."""
        return self._decoder.damaged

    def send(self, message: Message) -> None:
        """Send a message; ``OSError`` if the connection is lost."""
        self._transport.write(encode(message))

    def receive(self) -> Iterator[Message]:
        """Yield the messages that have arrived; ``OSError`` if the connection is lost."""
        yield from self._decoder.feed(self._transport.read())

    def close(self) -> None:
        """Close the connection."""
        self._transport.close()


class _SerialTransport:
    """A serial port or a TCP connection by pyserial."""

    def __init__(self, url: str) -> None:
        import serial  # noqa: PLC0415 - pyserial is optional

        self._port = serial.serial_for_url(url, baudrate=_BAUD_RATE, timeout=_LATENCY, write_timeout=1.0)

    def read(self) -> bytes:
        data: bytes = self._port.read(4096)
        return data

    def write(self, data: bytes) -> None:
        self._port.write(data)

    def close(self) -> None:
        self._port.close()


def is_device(text: str) -> bool:
    """Whether a source is the address of a device: ``serial:///dev/ttyUSB0`` or ``tcp://echoplan.local:4000``."""
    return _ADDRESS.fullmatch(text) is not None


def port_names() -> tuple[str, ...]:
    """Return the serial ports of this computer.

    Raises ``MissingExtraError`` if pyserial is not installed.
    """
    with _pyserial():
        from serial.tools.list_ports import comports  # noqa: PLC0415 - pyserial is optional
    return tuple(sorted(port.device for port in comports()))


def open_port(address: str) -> Port:
    """Open a port.

    Raises ``InputError`` if it cannot be opened, ``MissingExtraError`` if pyserial is not installed.
    """
    found = _ADDRESS.fullmatch(address)
    if found is None or (found["scheme"] == "tcp" and not re.fullmatch(r"[^:/]+:\d{1,5}/?", found["rest"])):
        remedy = "write serial:///dev/ttyUSB0 or tcp://echoplan.local:4000"
        raise InputError(address, "it is not the address of a device", remedy=remedy)
    is_tcp = found["scheme"] == "tcp"
    with _pyserial():
        try:
            transport = _SerialTransport(f"socket://{found['rest'].rstrip('/')}" if is_tcp else found["rest"])
        except OSError as error:
            reason = (error.strerror or str(error)).rpartition(": ")[2]
            remedy = "check that the device is switched on" if is_tcp else _remedy_for_serial(found["rest"])
            raise InputError(address, f"it cannot be opened: {reason}", remedy=remedy) from error
    return Port(name=address, transport=transport)


def _remedy_for_serial(name: str) -> str:
    known = [each for each in port_names() if each != name]
    listed = f"the serial ports are {', '.join(known)}" if known else "no other serial port was found"
    return f"check the cable and `echoplan doctor`; {listed}"


@contextmanager
def _pyserial() -> Iterator[None]:
    try:
        yield
    except ModuleNotFoundError as error:
        raise MissingExtraError("pyserial", extra="device") from error
