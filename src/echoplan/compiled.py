"""Functions compiled to machine code, kept on the disk and renewed when they or what they use changes.

Functions that Python calls are ``compiled``, those that only compiled functions call are ``inlined``.

Importing this module imports numba, which takes its time: import what uses it where it is used.
"""

import gc
import hashlib
import logging
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from enum import Enum
from functools import cache
from itertools import chain
from pathlib import Path
from pickle import UnpicklingError
from types import CodeType, FunctionType, ModuleType
from typing import Any, Final, ParamSpec, TypeGuard, TypeVar

import numba
import numpy as np
from numba.core import event
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import NativeLowering
from numba.extending import register_jitable

__all__ = ["cache_folders", "compiled", "digest_of", "inlined"]

P = ParamSpec("P")
R = TypeVar("R")

# A division by zero gives what NumPy gives.
_ERROR_MODEL: Final = "numpy"
# The same for all functions: numba compiles a part anew for functions with other options. No C code calls any.
_OPTIONS: Final[dict[str, Any]] = {"error_model": _ERROR_MODEL, "no_cfunc_wrapper": True, "no_cpython_wrapper": True}
# What opening a file says, and pickle of one that was cut off or overwritten.
_UNREADABLE = (OSError, EOFError, UnpicklingError, AttributeError, ImportError, LookupError, TypeError, ValueError)


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function once and for all.

    numba keeps machine code beside the file of a function and renews it when that file changes.  It does not see
    that a function in another file, whose code was built into this one, has changed; so all that the code of a
    function uses is made part of the key.

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
    fast: Any = numba.njit(pipeline_class=_KernelCompiler, **_OPTIONS)(function)
    if function.__name__.isidentifier():
        # Without a folder that may be written to, numba says RuntimeError, and machine code is kept in memory only.
        with suppress(RuntimeError):
            # numba's own way in, njit(cache=True), cannot take another cache.
            fast._cache = _DependencyCache(function)  # noqa: SLF001
    kept: Callable[P, R] = fast
    return kept


def inlined(function: Callable[P, R]) -> Callable[P, R]:
    """Make a function part of the compiled functions that call it, without machine code of its own.

    That compiles faster. Called from Python, the function runs as Python code, which is slow.

    Examples
    --------
    >>> half = inlined(lambda x: 0.5 * x)
    >>> compiled(lambda x: half(x) + 1.0)(1.0)
    1.5
    """
    kept: Callable[P, R] = register_jitable(pipeline_class=_PartCompiler, **_OPTIONS)(function)
    return kept


class _CodeOfPart(JITCodeLibrary):
    """Code that is optimised and made machine code only in the functions that it becomes part of."""

    def _optimize_final_module(self) -> None:
        """Leave that to those functions."""

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()  # type: ignore[no-untyped-call]
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]
class _LoweringOfKernel(NativeLowering):
    _name = "echoplan_lowering_of_kernel"

    def run_pass(self, state: Any) -> bool:
        """Translate to code of LLVM, and let Python call it."""
        state.flags.no_cpython_wrapper = False
        return bool(super().run_pass(state))  # type: ignore[no-untyped-call]


@register_pass(mutates_CFG=True, analysis_only=False)  # type: ignore[no-untyped-call]
class _LoweringOfPart(NativeLowering):
    _name = "echoplan_lowering_of_part"

    def run_pass(self, state: Any) -> bool:
        """Translate to code of LLVM, and register it for the functions that use it."""
        state.flags.no_compile = True
        state.library = _CodeOfPart(state.targetctx.codegen(), state.func_id.func_qualname)  # type: ignore[no-untyped-call]
        super().run_pass(state)  # type: ignore[no-untyped-call]
        # numba finds the code by the built-in function that would run it. This one is never called.
        key = object().__sizeof__
        state.targetctx.insert_user_function(key, state.cr.fndesc, [state.library])
        state.cr = state.cr._replace(cfunc=key)
        return True


class _KernelCompiler(Compiler):
    lowering: type[NativeLowering] = _LoweringOfKernel

    def define_pipelines(self) -> list[Any]:
        """Replace the translation to code of LLVM."""
        (passes,) = super().define_pipelines()  # type: ignore[no-untyped-call]
        passes.passes = [(self.lowering if each is NativeLowering else each, text) for each, text in passes.passes]
        passes.finalize()
        return [passes]


class _PartCompiler(_KernelCompiler):
    lowering = _LoweringOfPart


def cache_folders() -> frozenset[Path]:
    """Return the folders that keep the machine code of the modules imported so far; none if none can be written to."""
    modules = [module for name, module in sys.modules.items() if name.startswith("echoplan.")]
    caches = (getattr(value, "_cache", None) for module in modules for value in vars(module).values())
    return frozenset(Path(each.cache_path) for each in caches if isinstance(each, _DependencyCache))


@cache
def _log_once() -> None:
    logging.getLogger("echoplan").info("Compiling, once after each installation: about half a minute.")


class _Compilation(event.Listener):
    """Logs when the first function is compiled, and pauses the garbage collector, which takes a sixth of the time."""

    def __init__(self) -> None:
        self._depth, self._was_enabled = 0, False

    def on_start(self, event: Any) -> None:  # noqa: ARG002 - numba says what is compiled
        """Log it once, and collect no garbage until the outermost function is compiled."""
        _log_once()
        if self._depth == 0:
            self._was_enabled = gc.isenabled()
            gc.disable()
        self._depth += 1

    def on_end(self, event: Any) -> None:  # noqa: ARG002 - numba says what was compiled
        """Go on collecting garbage after the outermost function."""
        self._depth -= 1
        if self._depth == 0 and self._was_enabled:
            gc.enable()


event.register("numba:compile", _Compilation())  # type: ignore[no-untyped-call]


class _DependencyCache(FunctionCache):
    """numba's cache of a function, with all that its code uses in the key; it may be damaged, or the disk full."""

    def __init__(self, function: Any) -> None:
        super().__init__(function)  # type: ignore[no-untyped-call]
        self._function = function

    def _index_key(self, sig: Any, codegen: Any) -> tuple[Any, ...]:
        key: tuple[Any, ...] = super()._index_key(sig, codegen)  # type: ignore[no-untyped-call]
        fields = tuple(_fields_of(each) for each in sig)
        return (*key, fields, digest_of(self._function))

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


def digest_of(function: FunctionType) -> str:
    """Return a digest of a function and all that becomes part of its machine code: functions, constants, classes."""
    parts, waiting = dict[FunctionType, str](), [function]
    while waiting:
        each = waiting.pop()
        if each not in parts:
            parts[each], used = _written(each)
            waiting += used
    return hashlib.sha256("".join([_ERROR_MODEL, *sorted(parts.values())]).encode()).hexdigest()


@cache
def _written(function: FunctionType) -> tuple[str, tuple[FunctionType, ...]]:
    """Write what of a function itself becomes part of machine code; return with it the functions that it uses."""
    codes = list(_codes(function.__code__))
    names = list(chain.from_iterable(code.co_names for code in codes))
    used = [*_named(names, function), *chain.from_iterable(code.co_consts for code in codes)]
    used += [*(function.__defaults__ or ()), *(cell.cell_contents for cell in function.__closure__ or ())]
    # Of a compiled function, what Python would run.
    values = [getattr(each, "py_func", each) for each in used]
    parts = [function.__qualname__, [code.co_code for code in codes], names, list(map(_constant, values))]
    return repr(parts), tuple(filter(_is_function, values))


def _is_function(value: Any) -> TypeGuard[FunctionType]:
    return isinstance(value, FunctionType)


def _codes(code: CodeType) -> Iterator[CodeType]:
    """Yield the code of a function, and that of the functions and comprehensions in it."""
    yield code
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _codes(each)


def _named(names: list[str], function: FunctionType) -> list[Any]:
    """Return what the global names in a function stand for, and those of modules of echoplan."""
    known = dict(function.__globals__)
    for value in [known.get(name) for name in names]:
        if isinstance(value, ModuleType) and value.__name__.startswith("echoplan."):
            known |= vars(value)
    return [known[name] for name in names if name in known]


def _constant(value: Any) -> str:
    """Write what of a value becomes part of machine code; functions and code are written by themselves."""
    if isinstance(value, FunctionType | CodeType | ModuleType):
        return ""
    if isinstance(value, type) and issubclass(value, Enum):
        return repr([(each.name, each.value) for each in value])
    if isinstance(value, type):
        return f"{value.__qualname__}{getattr(value, '_fields', '')}"
    return f"{value.dtype}{value.tolist()}" if isinstance(value, np.ndarray) else repr(value)


def _fields_of(argument: Any) -> Any:
    """Return the names of the fields of named tuples among the types of arguments: their order is not in the types."""
    parts = tuple(_fields_of(each) for each in getattr(argument, "types", ()))
    return (getattr(argument, "fields", ()), parts) if parts else ()
