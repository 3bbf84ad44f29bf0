"""The two ways in which hot functions are compiled to machine code."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

__all__ = ["compiled", "compiled_and_kept"]

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that other compiled functions call.

    Parameters
    ----------
    function : callable
        A function of numbers, arrays and named tuples of them.

    Returns
    -------
    callable
        The same function, fast; without the checks of Python for division by zero.

    Examples
    --------
    >>> compiled(lambda x: 1.0 / x)(0.0)
    inf
    """
    fast: Callable[P, R] = numba.njit(error_model="numpy")(function)
    return fast


def compiled_and_kept(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function that is called from Python, once and for all: the code is kept beside its file.

    It is renewed when that file changes, and only then.  So whatever a kept function calls belongs into its own file.

    Parameters
    ----------
    function : callable
        A function of numbers, arrays and named tuples of them.

    Returns
    -------
    callable
        The same function, fast; without the checks of Python for division by zero.
    """
    fast: Callable[P, R] = numba.njit(cache=True, error_model="numpy")(function)
    return fast
