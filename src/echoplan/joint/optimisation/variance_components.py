"""Variance components: standard deviations estimated from squared errors and a log-normal prior."""

import numpy as np
from numpy.typing import ArrayLike

from echoplan.arrays import FloatArray

__all__ = ["map_scale_factor"]


def map_scale_factor(squares: ArrayLike, count: float, spread: float) -> FloatArray:
    r"""Return the factors by which standard deviations differ from their prior values (maximum a posteriori).

    .. math:: n \ln f + \frac{S}{2 f^2} + \frac{\ln^2 f}{2 t^2} \to \min

    With the Wright omega function, the solution of ``omega + ln omega = z`` (Corless and Jeffrey 2002), that is

    .. math:: \ln f = \tfrac12 \omega(2 n t^2 + \ln(2 t^2 S)) - n t^2

    ``squares``, shape (k,), are sums S of the expected squares of n errors (``count``) in units of the prior variance;
    t (``spread``) is the prior standard deviation of ln f.
    """
    from scipy.special import wrightomega  # noqa: PLC0415 - SciPy is slow to import

    pull = count * spread**2
    # A sum of zero would have no logarithm.
    expected = np.maximum(squares, np.finfo(np.float64).tiny)
    omega = wrightomega(2.0 * pull + np.log(2.0 * spread**2 * expected))
    factors: FloatArray = np.exp(0.5 * omega.real - pull)
    return factors
