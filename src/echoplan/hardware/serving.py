"""The port of a simulated device: a pseudo terminal or a TCP server, and the loop that serves it in real time."""

import os
import select
import socket
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from echoplan.errors import InputError
from echoplan.hardware.faulty import VirtualDevice

__all__ = ["PtyEndpoint", "TcpEndpoint", "serve"]

# How long a read waits for bytes [s], and the step of the device's clock [us].
_LATENCY, _STEP = 0.001, 500
# A device that cannot keep up with real time is as much slower: it makes at most so much of its time in a turn [us].
_MOST_AT_ONCE = 20_000


class PtyEndpoint:
    """A pseudo terminal; bytes that nobody reads are lost, as on a serial line.

    Parameters
    ----------
    link : Path, optional
        A link to it, which stays the same when the port is opened again.
    """

    def __init__(self, *, link: Path | None = None) -> None:
        if not hasattr(os, "openpty"):
            raise InputError("--pty", "this system has no pseudo terminals", remedy="use --tcp 4000")
        self._files: list[int] = []
        self._links = [] if link is None else [link]
        self.open()

    @property
    def address(self) -> str:
        """What a host opens."""
        return f"serial://{self._links[0] if self._links else os.ttyname(self._files[1])}"

    @property
    def is_open(self) -> bool:
        """Whether the port is there."""
        return bool(self._files)

    @property
    def is_busy(self) -> bool:
        """Whether bytes are still to be sent."""
        return False

    def open(self) -> None:
        """Make the port."""
        import tty  # noqa: PLC0415 - not on every system

        # The host's end stays open here, too: else reading would fail while no host has it open.
        self._files[:] = os.openpty()
        tty.setraw(self._files[1])
        os.set_blocking(self._files[0], False)
        for link in self._links:
            link.unlink(missing_ok=True)
            link.symlink_to(os.ttyname(self._files[1]))

    def read(self) -> bytes:
        """Return what has arrived, after a millisecond at the latest."""
        readable, _, _ = select.select(self._files[:1], [], [], _LATENCY)
        return os.read(self._files[0], 4096) if readable else b""

    def write(self, data: bytes) -> None:
        """Send bytes."""
        with suppress(BlockingIOError):
            # Bytes sent while the port is closed are lost.
            for file in self._files[:1]:
                os.write(file, data)

    def close(self) -> None:
        """Let the port vanish."""
        for link in self._links:
            link.unlink(missing_ok=True)
        for file in self._files:
            os.close(file)
        self._files.clear()


class TcpEndpoint:
    """A TCP server on this computer for one host at a time; a new one replaces it.

    Parameters
    ----------
    number : int
        The port; 0: any that is free.
    """

    def __init__(self, number: int) -> None:
        self._numbers = [number]
        self._servers: list[socket.socket] = []
        self._hosts: list[socket.socket] = []
        self._outbox = bytearray()
        try:
            self.open()
        except (OSError, OverflowError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise InputError(f"--tcp {number}", reason, remedy="choose another port") from error

    @property
    def address(self) -> str:
        """What a host opens."""
        return f"tcp://localhost:{self._numbers[0]}"

    @property
    def is_open(self) -> bool:
        """Whether connections are taken."""
        return bool(self._servers)

    @property
    def is_busy(self) -> bool:
        """Whether bytes are still to be sent."""
        return bool(self._outbox)

    def open(self) -> None:
        """Take connections."""
        server = socket.create_server(("127.0.0.1", self._numbers[0]))
        server.settimeout(0.0)
        self._servers.append(server)
        self._numbers[0] = server.getsockname()[1]

    def read(self) -> bytes:
        """Return what has arrived, after a millisecond at the latest."""
        readable, _, _ = select.select([*self._servers, *self._hosts], [], [], _LATENCY)
        if self._servers[0] in readable:
            host, _ = self._servers[0].accept()
            self._drop()
            host.settimeout(0.0)
            host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._hosts.append(host)
            return b""
        if not readable:
            return b""
        try:
            data = self._hosts[0].recv(4096)
        except OSError:
            data = b""
        if not data:
            self._drop()
        return data

    def write(self, data: bytes) -> None:
        """Send bytes, and keep what does not go now."""
        if not self._hosts:
            return
        self._outbox += data
        try:
            sent = self._hosts[0].send(self._outbox)
        except BlockingIOError:
            return
        except OSError:
            self._drop()
            return
        del self._outbox[:sent]

    def close(self) -> None:
        """Drop the connection and take no other."""
        self._drop()
        for server in self._servers:
            server.close()
        self._servers.clear()

    def _drop(self) -> None:
        for host in self._hosts:
            host.close()
        self._hosts.clear()
        self._outbox.clear()


def serve(
    device: VirtualDevice,
    port: PtyEndpoint | TcpEndpoint,
    *,
    speed: float = 1.0,
    is_over: Callable[[], bool] = lambda: False,
) -> None:
    """Run a device in real time, or so many times faster, until it is over."""
    clock, credit, now = 0, 0.0, time.monotonic()
    while not is_over():
        if device.is_plugged != port.is_open:
            (port.open if device.is_plugged else port.close)()
        if port.is_open:
            device.receive(port.read())
        else:
            time.sleep(_LATENCY)
        before, now = now, time.monotonic()
        if port.is_busy:
            port.write(b"")
            continue
        credit += min(_MOST_AT_ONCE * max(speed, 1.0), 1e6 * speed * (now - before))
        output = bytearray()
        for _ in range(int(credit // _STEP)):
            clock += _STEP
            output += device.advance(clock)
        credit %= _STEP
        if output:
            port.write(bytes(output))
