"""A live page from start to end: server, feed and mapper together."""

import asyncio
import signal
import socket
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory

from echoplan.batch.local import LocalProcesses
from echoplan.io import write_recording
from echoplan.live.access import LOOPBACK, Access
from echoplan.live.feed import Feed
from echoplan.live.live_map import LiveMap
from echoplan.live.mapping import MapUpdate
from echoplan.live.server import LiveServer
from echoplan.live.unsaved import RECORDING, keep_sweeps
from echoplan.signals import raised_signals

__all__ = ["run_live"]

# A feed that is closed ends within this time [s].
_PATIENCE = 2.0


def run_live(
    feed: Feed,
    *,
    host: str = LOOPBACK[0],
    port: int = 0,
    token: str = "",
    out: Path | None = None,
    ready: Callable[[str], None] = lambda address: None,  # noqa: ARG005 - nobody waits for it
    publish: Callable[[MapUpdate], None] | None = None,
) -> None:
    """Show a feed in a page until an interrupt.

    Parameters
    ----------
    feed : Feed
        Where sweeps come from; it is closed at the end.
    host : str, optional
        Address on which to listen.
    port : int, optional
        Port on which to listen; 0 for any free one.
    token : str, optional
        What the address must contain; needed where other machines can reach the server.
    out : Path, optional
        Folder for results. What was not saved when the server ends is written there as a recording; until then, new
        sweeps are appended to the recording ``unsaved`` in it.
    ready : callable, optional
        Is given the address of the page once it can be opened.
    publish : callable, optional
        Is given each new map, whether or not anybody looks at the page.

    Raises
    ------
    InputError
        If the server cannot listen there, or the folder has the sweeps of an earlier run.
    MissingExtraError
        If websockets is not installed.
    """
    mapper = LocalProcesses(1)
    with (
        raised_signals(),
        closing(feed),
        keep_sweeps(feed, out=out) as keep,
        TemporaryDirectory(prefix="echoplan-") as scratch,
    ):
        live_map = LiveMap(feed, executor=mapper, scratch=Path(scratch), out=out, keep=keep, publish=publish)
        try:
            asyncio.run(_run(live_map, host=host, port=port, token=token, ready=ready))
        finally:
            # A map that nobody will see is not waited for.
            mapper.shutdown(wait=False, cancel_futures=True)
            # Even after an error, what was recorded is kept.
            if out is not None and live_map.has_unsaved and len(live_map.survey):
                write_recording(out / RECORDING, live_map.survey.recording)


async def _run(live_map: LiveMap, *, host: str, port: int, token: str, ready: Callable[[str], None]) -> None:
    loop = asyncio.get_running_loop()
    with _interrupts(loop) as interrupted:
        server = LiveServer(live_map, access=Access(token=token))
        async with server.serve(host=host, port=port) as listening:
            mapping = asyncio.create_task(live_map.keep_mapping())
            thread = live_map.listen(loop)
            ready(_address(listening.sockets, token=token))
            stopped = asyncio.create_task(interrupted.wait())
            try:
                await asyncio.wait({stopped, mapping}, return_when=asyncio.FIRST_COMPLETED)
            finally:
                stopped.cancel()
                mapping.cancel()
                live_map.feed.close()
                with suppress(asyncio.CancelledError):
                    await mapping
            await asyncio.to_thread(thread.join, _PATIENCE)


@contextmanager
def _interrupts(loop: asyncio.AbstractEventLoop) -> Iterator[asyncio.Event]:
    """Turn interrupts into an event: an exception in the middle of a callback would lose what it was doing."""
    event = asyncio.Event()
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    # A job in the background is started with interrupts ignored, and goes on; Windows has no such handlers.
    watched = [number for number, handler in before.items() if handler != signal.SIG_IGN]
    with suppress(NotImplementedError):
        for number in watched:
            loop.add_signal_handler(number, event.set)
    try:
        yield event
    finally:
        with suppress(NotImplementedError):
            for number in watched:
                loop.remove_signal_handler(number)
        for number in watched:
            signal.signal(number, before[number])


def _address(sockets: "Iterator[socket.socket] | tuple[socket.socket, ...]", *, token: str) -> str:
    """Write the address of the page, as another machine may type it."""
    host, port = next(iter(sockets)).getsockname()[:2]
    if host in ("0.0.0.0", "::"):  # noqa: S104 - all addresses of this machine
        host = _own_address()
    written = f"[{host}]" if ":" in host else host
    return f"http://{written}:{port}/{f'?token={token}' if token else ''}"


def _own_address() -> str:
    """Find the address at which other machines reach this one; nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return LOOPBACK[0]
        address: str = probe.getsockname()[0]
        return address
