"""The server of a live page: the page, the downloads and the websockets, all on one port."""

import asyncio
import errno
import logging
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from http import HTTPStatus
from importlib.resources import files
from typing import TYPE_CHECKING

from echoplan.errors import EchoplanError, InputError, MissingExtraError
from echoplan.live.access import SECURITY_HEADERS, Access
from echoplan.live.commands import SaveCommand, parse_command
from echoplan.live.live_map import LiveMap
from echoplan.live.messages import encoded

if TYPE_CHECKING:
    from websockets.asyncio.server import Server, ServerConnection
    from websockets.http11 import Request, Response

__all__ = ["LiveServer"]

# Time between two frames [s].
_PERIOD = 0.1
# The longest command is some hundred bytes long.
_LONGEST_COMMAND = 4096
# Bytes on their way to one viewer: about ten frames.
_SEND_BUFFER = 65_536
_KINDS = {
    ".dxf": "image/vnd.dxf",
    ".geojson": "application/geo+json",
    ".mcap": "application/octet-stream",
    ".pdf": "application/pdf",
    ".pgm": "image/x-portable-graymap",
    ".png": "image/png",
    ".svg": "image/svg+xml",
    ".yaml": "application/yaml",
    ".zip": "application/zip",
}


class LiveServer:
    """Shows a live map to any number of viewers and passes on what they ask for.

    Each viewer has a task that sends what is new on the board: one that is slow skips frames and holds up no other.

    Parameters
    ----------
    live_map : LiveMap
        What to show.
    access : Access
        Who may see it.
    """

    def __init__(self, live_map: LiveMap, *, access: Access) -> None:
        self._live_map = live_map
        self._access = access
        self._page = files("echoplan.live").joinpath("page.html").read_bytes()
        self._tick = asyncio.Condition()
        self._viewers: set[ServerConnection] = set()

    @asynccontextmanager
    async def serve(self, *, host: str, port: int) -> "AsyncIterator[Server]":
        """Listen while the block runs.

        Raises
        ------
        MissingExtraError
            If websockets is not installed.
        InputError
            If the port cannot be used.
        """
        try:
            from websockets.asyncio.server import serve  # noqa: PLC0415 - an optional package
        except ImportError:
            raise MissingExtraError("websockets", extra="view") from None

        logger = logging.getLogger("echoplan.live.websockets")
        # A browser that closes a connection while it opens is no error.
        logger.addFilter(lambda record: record.getMessage() != "opening handshake failed")
        try:
            server = await serve(
                self._attend,
                host,
                port,
                process_request=self._answer,
                compression=None,
                max_size=_LONGEST_COMMAND,
                logger=logger,
                close_timeout=1,
            )
        except OSError as error:
            raise _refused_port(error, host=host, port=port) from None
        async with server:
            frames = asyncio.create_task(self._keep_time())
            try:
                yield server
            finally:
                frames.cancel()
                # A viewer that reads nothing would never answer that it closes; pages reconnect by themselves.
                for viewer in self._viewers:
                    viewer.transport.abort()

    async def _keep_time(self) -> None:
        """Renew the frame ten times a second while anybody looks."""
        loop = asyncio.get_running_loop()
        due = loop.time()
        while True:
            if self._viewers:
                self._live_map.post_frame()
                async with self._tick:
                    self._tick.notify_all()
            due = max(due + _PERIOD, loop.time())
            await asyncio.sleep(due - loop.time())

    async def _attend(self, viewer: "ServerConnection") -> None:
        """Serve one viewer until it goes."""
        from websockets.exceptions import ConnectionClosed  # noqa: PLC0415 - see serve

        # What waits in the system's buffer is old: frames that a slow viewer cannot take should not get there.
        viewer.transport.get_extra_info("socket").setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
        self._viewers.add(viewer)
        sending = asyncio.create_task(self._show(viewer))
        try:
            async for text in viewer:
                await self._obey(text, viewer)
        except ConnectionClosed:
            pass
        finally:
            self._viewers.discard(viewer)
            sending.cancel()
            with suppress(asyncio.CancelledError, ConnectionClosed):
                await sending

    async def _show(self, viewer: "ServerConnection") -> None:
        """Send what is new, as fast as this viewer takes it."""
        seen: dict[str, int] = {}
        while True:
            for topic, (version, text) in [*self._live_map.board.items()]:
                if seen.get(topic) != version:
                    seen[topic] = version
                    await viewer.send(text)
            async with self._tick:
                await self._tick.wait()

    async def _obey(self, text: str | bytes, viewer: "ServerConnection") -> None:
        """Do what a viewer asks for, or answer in one line why not."""
        try:
            command = parse_command(text)
            if isinstance(command, SaveCommand):
                await self._live_map.save()
            else:
                self._live_map.obey(command)
        except EchoplanError as error:
            await viewer.send(encoded("refused", {"text": str(error)}))

    async def _answer(self, viewer: "ServerConnection", request: "Request") -> "Response | None":
        """Answer a request for the page or a download; None for a websocket."""
        path = request.path.partition("?")[0]
        status = self._refusal(request, is_socket=path == "/ws")
        if status is not None:
            return viewer.respond(status, f"{status.value} {status.phrase}\n")
        if path == "/ws":
            return None
        if path == "/":
            return self._response(self._page, kind="text/html; charset=utf-8")
        return await self._download(path) or viewer.respond(HTTPStatus.NOT_FOUND, "404 Not Found\n")

    async def _download(self, path: str) -> "Response | None":
        """Answer a request for a file that was saved; None if there is no such one."""
        found = self._live_map.file(path.removeprefix("/saved/")) if path.startswith("/saved/") else None
        if found is None:
            return None
        try:
            content = await asyncio.to_thread(found.read_bytes)
        except OSError:
            return None
        disposition = {"Content-Disposition": f'attachment; filename="{found.name}"'}
        return self._response(content, kind=_KINDS.get(found.suffix, "application/octet-stream"), **disposition)

    def _refusal(self, request: "Request", *, is_socket: bool) -> HTTPStatus | None:
        """Return the status with which a request is refused; None if it may pass."""
        hosts, origins = request.headers.get_all("Host"), request.headers.get_all("Origin")
        status = self._access.refusal(
            path=request.path,
            host=hosts[0] if len(hosts) == 1 else "",
            origin=origins[0] if len(origins) == 1 else None,
            is_socket=is_socket,
        )
        # Newer versions of websockets pass on requests of other methods.
        is_other = getattr(request, "method", "GET") != "GET"
        return HTTPStatus.METHOD_NOT_ALLOWED if status is None and is_other else status

    def _response(self, body: bytes, *, kind: str, **extra: str) -> "Response":
        from websockets.datastructures import Headers  # noqa: PLC0415 - see serve
        from websockets.http11 import Response  # noqa: PLC0415

        headers = Headers({"Content-Type": kind, "Content-Length": str(len(body)), **SECURITY_HEADERS, **extra})
        return Response(HTTPStatus.OK.value, HTTPStatus.OK.phrase, headers, body)


def _refused_port(error: OSError, *, host: str, port: int) -> InputError:
    """Say in one line why a server cannot listen."""
    if error.errno == errno.EADDRINUSE:
        remedy = f"name another, as in --port {port + 1}, or --port 0 for any free one"
        return InputError(f"--port {port}", "another program uses this port", remedy=remedy)
    if error.errno == errno.EACCES:
        return InputError(f"--port {port}", "the system keeps this port to itself", remedy="name one above 1023")
    remedy = "name an address of this machine, or 0.0.0.0 for all of them"
    return InputError(f"--host {host}", error.strerror or str(error), remedy=remedy)
