"""Functions compiled to machine code, kept on the disk and renewed when any of echoplan's code changes.

Importing this module imports numba, which takes its time: import what uses it where it is used.
"""

import logging
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from pickle import UnpicklingError
from typing import Any, ParamSpec, TypeVar

import numba
from numba.core import event
from numba.core.caching import FunctionCache

__all__ = ["cache_folders", "compiled"]

P = ParamSpec("P")
R = TypeVar("R")

# What opening a file says, and pickle of one that was cut off or overwritten.
_UNREADABLE = (OSError, EOFError, UnpicklingError, AttributeError, ImportError, LookupError, TypeError, ValueError)


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function once and for all.

    numba keeps machine code beside the file of a function and renews it when that file changes.  It does not see
    that a function in another file, whose code was built into this one, has changed; so the state of the whole
    package is made part of the key.

    Parameters
    ----------
    function : callable
        A function of numbers, arrays and named tuples of them.

    Returns
    -------
    callable
        The same function, fast; a division by zero gives ``inf`` or ``nan`` instead of an error.

    Notes
    -----
    In a loop over pings, hand numbers on to other compiled functions rather than named tuples of arrays: to count the
    references to each of their arrays takes longer than the arithmetic of a ping.

    Examples
    --------
    >>> compiled(lambda x: 1.0 / x)(0.0)
    inf
    """
    fast: Any = numba.njit(error_model="numpy")(function)
    if function.__name__.isidentifier():
        # Without a folder that may be written to, numba says RuntimeError, and machine code is kept in memory only.
        with suppress(RuntimeError):
            # numba's own way in, njit(cache=True), cannot take another cache.
            fast._cache = _PackageCache(function)  # type: ignore[no-untyped-call]  # noqa: SLF001
    kept: Callable[P, R] = fast
    return kept


def cache_folders() -> frozenset[Path]:
    """Return the folders that keep the machine code of the modules imported so far; none if none can be written to."""
    modules = [module for name, module in sys.modules.items() if name.startswith("echoplan.")]
    caches = (getattr(value, "_cache", None) for module in modules for value in vars(module).values())
    return frozenset(Path(each.cache_path) for each in caches if isinstance(each, _PackageCache))


@cache
def _log_once() -> None:
    logging.getLogger("echoplan").info("Compiling, once after each installation: one to two minutes.")


class _Notice(event.Listener):
    """Logs when the first function is compiled, since compiling takes one to two minutes."""

    def on_start(self, event: Any) -> None:  # noqa: ARG002 - numba says what is compiled
        """Log it once."""
        _log_once()

    def on_end(self, event: Any) -> None:
        """Leave the end unsaid."""


event.register("numba:compile", _Notice())  # type: ignore[no-untyped-call]


class _PackageCache(FunctionCache):
    """numba's cache of a function, with the state of the package in the key; it may be damaged, or the disk full."""

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        key: tuple[Any, ...] = super()._index_key(sig, codegen)  # type: ignore[no-untyped-call]
        return (*key, _state_of_package())

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Load machine code; nothing if what is kept cannot be read, and then that goes."""
        try:
            return super().load_overload(sig, target_context)  # type: ignore[no-untyped-call]
        except _UNREADABLE:
            with suppress(OSError):
                self.flush()  # type: ignore[no-untyped-call]
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep machine code if the disk takes it."""
        with suppress(*_UNREADABLE):
            super().save_overload(sig, data)  # type: ignore[no-untyped-call]


@cache
def _state_of_package() -> tuple[int, int]:
    files = [path.stat() for path in Path(__file__).parent.rglob("*.py")]
    return max(file.st_mtime_ns for file in files), sum(file.st_size for file in files)
