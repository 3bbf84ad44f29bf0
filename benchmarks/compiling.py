"""CPU time that compiling takes: python benchmarks/compiling.py [RECORDING].

Maps a recording (sim:square by default) with an empty cache of compiled code, as the first map after an installation
does, and prints the functions of which the compilation takes longest, each with the NumPy functions that it uses.
"""

import os
import subprocess
import sys
import time
from collections import defaultdict
from tempfile import TemporaryDirectory
from typing import Any

from numba.core import event

import echoplan

LONGEST = 25


class Listener(event.Listener):
    """Adds up the CPU time of each function of echoplan, without that of other such functions."""

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

    def on_end(self, event: Any) -> None:  # noqa: ARG002 - numba says what is compiled
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
    """Map in another process with an empty cache, or be that process."""
    if os.environ.get("NUMBA_CACHE_DIR") is None:
        with TemporaryDirectory() as folder:
            command = [sys.executable, *sys.argv]
            subprocess.run(command, env=os.environ | {"NUMBA_CACHE_DIR": folder}, check=True)
        return
    listener = Listener()
    event.register("numba:compile", listener)  # type: ignore[no-untyped-call]
    begun = time.process_time()
    echoplan.map(sys.argv[1] if len(sys.argv) > 1 else "sim:square")
    everything = time.process_time() - begun
    for name, seconds in sorted(listener.seconds.items(), key=lambda each: -each[1])[:LONGEST]:
        print(f"{seconds:6.2f} s  {name}")
    print(f"{sum(listener.seconds.values()):6.1f} s  all {len(listener.seconds)} functions")
    print(f"{everything:6.1f} s  with the map itself")


if __name__ == "__main__":
    main()
