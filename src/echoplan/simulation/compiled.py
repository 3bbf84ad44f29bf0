"""The one way in which hot functions are compiled."""

from collections.abc import Callable
from typing import ParamSpec, TypeVar

import numba

__all__ = ["compiled"]

P = ParamSpec("P")
R = TypeVar("R")


def compiled(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function to machine code at its first call, and keep the code beside its file.

    The code that is kept is renewed when the file of the function called from Python changes, and only then:
    functions that call each other belong into one file.

    Parameters
    ----------
    function : callable
        A function of numbers, arrays and named tuples of them.

    Returns
    -------
    callable
        The same function, fast.

    Examples
    --------
    >>> compiled(lambda x: x + 1.0)(1.0)
    2.0
    """
    fast: Callable[P, R] = numba.njit(cache=True, error_model="numpy")(function)
    return fast
