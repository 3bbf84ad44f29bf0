"""Signals end the program at once: an exception that is raised while compiled code runs would crash it."""

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Thread
from types import FrameType

__all__ = ["at_signal", "end_with_parent", "ended_by_signals", "noted_signals", "raised_signals"]

# A signal ends a program with 128 and its number, as shells have it.
_SIGNALLED = 128
_NUMBERS = (signal.SIGINT, signal.SIGTERM)

# Called if a signal ends the program now.
_actions: list[Callable[[], object]] = []


@contextmanager
def ended_by_signals() -> Iterator[None]:
    """Let interrupts and requests to terminate end the process at once.

    They raise no exception: compiled code crashes if what it calls raises one, destructors drop it, and a thread may
    wait for ever for a lock that it left behind.
    """
    with _handled(_end):
        yield


@contextmanager
def raised_signals() -> Iterator[None]:
    """Let signals raise ``SystemExit``: where devices or processes must be stopped, and no compiled code runs."""

    def stop(number: int, _: FrameType | None) -> None:
        """Raise the status with which a signal ends a program."""
        raise SystemExit(_SIGNALLED + number)

    with _handled(stop):
        yield


@contextmanager
def noted_signals() -> Iterator[list[int]]:
    """Keep signals from doing anything; yield the list of those that came."""
    came: list[int] = []
    with _handled(lambda number, _: came.append(number)):
        yield came


@contextmanager
def at_signal(action: Callable[[], object]) -> Iterator[None]:
    """Call an action if a signal ends the process before the block is left.

    Parameters
    ----------
    action : callable
        The action; it may be called at any moment.
    """
    _actions.append(action)
    try:
        yield
    finally:
        _actions.remove(action)


def end_with_parent() -> None:
    """Let a worker process end when its parent ends, and silently when a terminal interrupts both."""
    from multiprocessing import parent_process  # noqa: PLC0415 - most commands have no use for it

    def wait() -> None:
        """Wait for the end of the parent; the worker itself would wait for calls for ever."""
        parent = parent_process()
        if parent is not None:
            parent.join()
            os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_DFL)
    Thread(target=wait, daemon=True).start()


@contextmanager
def _handled(handler: Callable[[int, FrameType | None], object]) -> Iterator[None]:
    before = {number: signal.getsignal(number) for number in _NUMBERS}
    # A job in the background is started with interrupts ignored, and goes on.
    watched = [number for number in _NUMBERS if before[number] != signal.SIG_IGN]
    for number in watched:
        signal.signal(number, handler)
    try:
        yield
    finally:
        for number in watched:
            signal.signal(number, before[number])


def _end(number: int, _: FrameType | None) -> None:
    while _actions:
        with suppress(Exception):
            _actions.pop()()
    os._exit(_SIGNALLED + number)
