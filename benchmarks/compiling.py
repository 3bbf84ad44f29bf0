"""CPU time that compiling takes: python benchmarks/compiling.py [RECORDING].

Maps a recording (sim:square by default) with an empty cache of compiled code, as the first map after an installation
does, and prints the functions that take longest to compile. The time of NumPy functions counts for the function that
uses them.
"""

import multiprocessing
import os
import sys
import time
from collections import defaultdict
from tempfile import TemporaryDirectory
from typing import Any

from numba.core import event

import echoplan

LONGEST = 25


class Listener(event.Listener):
    """Adds up the CPU time of each function of echoplan, without that of other functions of echoplan that it uses."""

    def __init__(self) -> None:
        self.seconds = defaultdict[str, float](float)
        self._compiling: list[str] = []
        self._last = 0.0

    def on_start(self, event: Any) -> None:
        """Begin to compile a function."""
        self._count()
        function = event.data["dispatcher"].py_func
        is_own = function.__module__.startswith("echoplan.")
        outer = self._compiling[-1] if self._compiling else "numba"
        self._compiling.append(f"{function.__module__}.{function.__name__}" if is_own else outer)

    def on_end(self, event: Any) -> None:  # noqa: ARG002 - numba passes the event
        """Go on with the function that uses it."""
        self._count()
        self._compiling.pop()

    def _count(self) -> None:
        """Add the time since the last event to the function that was compiled then."""
        now = time.process_time()
        if self._compiling:
            self.seconds[self._compiling[-1]] += now - self._last
        self._last = now


def main() -> None:
    """Map in a process that starts with an empty cache."""
    source = sys.argv[1] if len(sys.argv) > 1 else "sim:square"
    with TemporaryDirectory() as folder:
        os.environ["NUMBA_CACHE_DIR"] = folder
        process = multiprocessing.get_context("spawn").Process(target=measure, args=(source,))
        process.start()
        process.join()
    sys.exit(process.exitcode)


def measure(source: str) -> None:
    """Map a recording and print what was compiled."""
    listener = Listener()
    event.register("numba:compile", listener)  # type: ignore[no-untyped-call]
    begun = time.process_time()
    echoplan.map(source)
    everything = time.process_time() - begun
    for name, seconds in sorted(listener.seconds.items(), key=lambda each: -each[1])[:LONGEST]:
        print(f"{seconds:6.2f} s  {name}")
    print(f"{sum(listener.seconds.values()):6.1f} s  all {len(listener.seconds)} functions")
    print(f"{everything:6.1f} s  with the map itself")


if __name__ == "__main__":
    main()
