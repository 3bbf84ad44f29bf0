"""Worker processes on this machine."""

from collections.abc import Callable
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import active_children, get_context
from queue import SimpleQueue
from time import sleep
from typing import ParamSpec, TypeVar

from threadpoolctl import threadpool_limits

from echoplan.signals import end_with_parent

__all__ = ["LocalProcesses", "prepare_process"]

# Between two looks at whether all processes have ended [s].
_MOMENT = 0.01

P = ParamSpec("P")
R = TypeVar("R")


class LocalProcesses(Executor):
    """Worker processes on this machine, each with one thread.

    A process that is killed takes only its own call along: that call raises ``BrokenProcessPool``, and the next one
    has a new process. In one pool of several processes all calls would fail.

    Parameters
    ----------
    count : int
        How many processes.
    """

    def __init__(self, count: int) -> None:
        self._others = active_children()
        self._count = count
        self._threads = ThreadPoolExecutor(max_workers=count)
        self._idle: SimpleQueue[ProcessPoolExecutor] = SimpleQueue()
        for _ in range(count):
            self._idle.put(_new_process())

    def submit(self, fn: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> Future[R]:
        """Call a function in the next process that is idle."""
        return self._threads.submit(self._call, fn, *args, **kwargs)

    def _call(self, function: Callable[P, R], /, *args: P.args, **kwargs: P.kwargs) -> R:
        process = self._idle.get()
        try:
            return process.submit(function, *args, **kwargs).result()
        except BrokenProcessPool:
            process.shutdown()
            process = _new_process()
            raise
        finally:
            self._idle.put(process)

    def __exit__(self, *error: object) -> None:
        """Wait for all calls; after an error or a signal, end them."""
        is_whole = error[0] is None
        self.shutdown(wait=is_whole, cancel_futures=not is_whole)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:  # noqa: FBT001, FBT002 - as Executor
        """End the processes; calls that are running are ended with them unless they are waited for."""
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        while self._idle.qsize() < self._count:
            for process in active_children():
                if process not in self._others:
                    process.terminate()
            sleep(_MOMENT)
        for _ in range(self._count):
            self._idle.get().shutdown()


def _new_process() -> ProcessPoolExecutor:
    """Prepare a process that starts with its first call, from nothing: a fork would copy locks of running threads."""
    return ProcessPoolExecutor(max_workers=1, mp_context=get_context("spawn"), initializer=prepare_process)


def prepare_process() -> None:
    """Prepare a worker process: it ends with its parent and at an interrupt, and has one thread."""
    end_with_parent()
    import echoplan.mapping  # noqa: F401, PLC0415 - loads the libraries whose threads are limited

    # One process a core: more threads would only wait for each other.
    threadpool_limits(limits=1)
