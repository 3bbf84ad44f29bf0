"""Deviations: how great the errors really are whose deviation was guessed."""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray

__all__ = ["map_scale_factor"]


def map_scale_factor(squares: ArrayLike, count: float, spread: float) -> FloatArray:
    r"""Tell how many times greater a deviation is than was guessed, from errors seen.

    .. math:: n \ln f + \frac{S}{2 f^2} + \frac{\ln^2 f}{2 t^2} \to \min

    With omega of Wright, the solution of ``omega + ln omega = z`` (Corless and Jeffrey 2002), that is

    .. math:: \ln f = \tfrac12 \omega(2 n t^2 + \ln(2 t^2 S)) - n t^2

    Parameters
    ----------
    squares : array_like, shape (k,)
        Sums S of the expected squares of n errors, in units of the guess.
    count : float
        How many they are, n.
    spread : float
        Standard deviation t of the logarithm of what is guessed.

    Returns
    -------
    ndarray, shape (k,)
        The factors.
    """
    from scipy.special import wrightomega  # noqa: PLC0415 - SciPy is slow to import

    pull = count * spread**2
    # Without any error the least is left that a number may be.
    expected = np.maximum(squares, np.finfo(np.float64).tiny)
    omega = wrightomega(2.0 * pull + np.log(2.0 * spread**2 * expected))
    factors: FloatArray = np.exp(0.5 * omega.real - pull)
    return factors
