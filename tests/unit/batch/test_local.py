"""Worker processes on this machine."""

import os
import signal
import time
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import active_children

import pytest

from echoplan.batch import LocalProcesses

# Each process imports echoplan.
pytestmark = pytest.mark.slow


def test_a_process_that_is_killed_takes_only_its_own_call_along() -> None:
    with LocalProcesses(2) as executor:
        killed = executor.submit(signal.raise_signal, signal.SIGKILL)
        others = [executor.submit(os.getpid) for _ in range(3)]
        assert isinstance(killed.exception(), BrokenProcessPool)
        assert all(other.result() != os.getpid() for other in others)
        assert executor.submit(abs, -1).result() == 1


def test_an_interrupt_ends_the_calls_that_are_running() -> None:
    before = active_children()
    start = time.monotonic()
    executor = LocalProcesses(1)
    running = executor.submit(time.sleep, 600)
    while active_children() == before:
        time.sleep(0.01)
    executor.__exit__(KeyboardInterrupt, KeyboardInterrupt(), None)
    assert running.exception(timeout=60) is not None
    assert time.monotonic() - start < 60
    # The pool waits for its processes in a thread of its own, which may not be through yet.
    while active_children() != before and time.monotonic() - start < 60:
        time.sleep(0.01)
    assert active_children() == before
