"""Range walk: how much too long a range is read, as a function of the signal excess.

The curve is replaceable: the physical one follows from the burst and the resonators, another may be a table, or be
fitted to a recording.  All are kept as values on an even grid of the excess, which compiled functions can read.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from echoplan.acoustics.detection import crossing_delay, peak_delay
from echoplan.arrays import FloatArray, checked_floats, store
from echoplan.errors import InvalidValueError
from echoplan.model import Transducer

__all__ = ["EXCESS_STEP", "WalkCurve", "fitted_walk", "physical_walk"]

# The grid of the excess [dB]: echoes 70 dB above the threshold are at a transducer's face.
EXCESS_STEP = 0.05
_NODES = 1401
# Of a distribution, where a mean is taken over it; the exponential of more is infinite.
_QUANTILES, _LARGEST = 64, 700.0


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class WalkCurve:
    """Shape of the range walk, 1 at the threshold and falling towards 0 for the loudest echoes.

    Parameters
    ----------
    values : ndarray, shape (1401,)
        Delay as a share of the delay at the threshold, at excesses of 0, 0.05, ... 70 dB; not increasing.

    Raises
    ------
    InvalidValueError
        If the curve rises anywhere: a louder echo is never detected later.
    """

    values: FloatArray

    def __post_init__(self) -> None:
        values = checked_floats(self.values, name="values", shape=(_NODES,))
        if (np.diff(values) > 1e-12).any():
            raise InvalidValueError("a walk curve must not rise with the excess")
        store(self, values=values)

    def __call__(self, excess: ArrayLike) -> FloatArray:
        """Read the curve.

        Parameters
        ----------
        excess : array_like
            Signal excess [dB]; below the threshold the curve stays what it is there.

        Returns
        -------
        ndarray
            Delay as a share of the delay at the threshold.
        """
        return np.interp(np.asarray(excess, dtype=np.float64), _grid(), self.values)

    def blurred(self, excess_scale: float) -> "WalkCurve":
        r"""Return the expected walk of detected echoes whose excess is not known exactly.

        A detected echo was above the threshold, however faint it should have been.

        .. math:: \bar w(M) = E[w(M + \delta) \mid M + \delta > 0], \quad \delta \sim \mathrm{logistic}(0, s)

        Parameters
        ----------
        excess_scale : float
            Scale s of the logistic distribution of the excess about what it should be [dB].

        Returns
        -------
        WalkCurve
            The mean.

        Examples
        --------
        >>> walk = WalkCurve.from_table([0, 1], [1, 0])
        >>> walk.blurred(0.3)([0.0, 0.5, 2.0]).round(2)
        array([0.61, 0.41, 0.01])
        """
        return _blurred(self, excess_scale)[0]

    def sigma_from_excess(self, excess: ArrayLike, excess_scale: float) -> FloatArray:
        """Return the standard deviation of the walk of such echoes.

        Parameters
        ----------
        excess : array_like
            What the signal excess should be [dB].
        excess_scale : float
            As for ``blurred`` [dB].

        Returns
        -------
        ndarray
            Standard deviation, as a share of the delay at the threshold.
        """
        deviations = _blurred(self, excess_scale)[1]
        # On an even grid without a search: adjustments ask for thousands of readings in no order.
        place = np.clip(np.asarray(excess, dtype=np.float64) / EXCESS_STEP, 0.0, _NODES - 1)
        node = np.minimum(place.astype(np.int64), _NODES - 2)
        sigmas: FloatArray = deviations[node] + (place - node) * (deviations[node + 1] - deviations[node])
        return sigmas

    @classmethod
    def from_table(cls, excess: ArrayLike, values: ArrayLike) -> "WalkCurve":
        """Make a curve of measured points.

        Parameters
        ----------
        excess : array_like, shape (n,)
            Signal excess [dB], increasing.
        values : array_like, shape (n,)
            Delay in any unit, not increasing.

        Returns
        -------
        WalkCurve
            Straight between the points, level beyond them, scaled to run from 1 to 0.

        Raises
        ------
        InvalidValueError
            If the points are not in order or all alike.

        Examples
        --------
        >>> WalkCurve.from_table([0, 10, 40], [30, 10, 0])([0, 5, 50]).round(3)
        array([1.   , 0.667, 0.   ])
        """
        nodes = checked_floats(excess, name="excess", shape=(None,))
        heights = checked_floats(values, name="values", shape=(len(nodes),))
        if (np.diff(nodes) <= 0).any() or heights[0] <= heights[-1]:
            raise InvalidValueError("a walk table must have increasing excesses and falling values")
        return cls(values=np.interp(_grid(), nodes, (heights - heights[-1]) / (heights[0] - heights[-1])))


def physical_walk(transducer: Transducer) -> WalkCurve:
    """Walk of a threshold on a burst that passed two resonators.

    Parameters
    ----------
    transducer : Transducer
        Burst and resonators.

    Returns
    -------
    WalkCurve
        ``crossing_delay`` over its value at the threshold.

    Examples
    --------
    >>> physical_walk(Transducer())([0.0, 6.0, 20.0]).round(2)
    array([1.  , 0.5 , 0.19])
    """
    return WalkCurve(values=np.minimum.accumulate(crossing_delay(_grid(), transducer) / peak_delay(transducer)))


def fitted_walk(
    excess: ArrayLike, residuals: ArrayLike, *, weights: ArrayLike, pieces: int = 24
) -> tuple[WalkCurve, float]:
    """Fit a falling curve to the residuals of a recording.

    Parameters
    ----------
    excess : array_like, shape (n,)
        Signal excess of each ping [dB].
    residuals : array_like, shape (n,)
        Reading less geometric range [m].
    weights : array_like, shape (n,)
        Weights of the pings.
    pieces : int, optional
        Between how many levels the curve is straight; each holds as many pings.

    Returns
    -------
    curve : WalkCurve
        The falling curve nearest to the weighted medians of the pieces (isotonic regression: Barlow et al. 1972).
    fall : float
        From its beginning to its end [m].

    Raises
    ------
    InvalidValueError
        If the residuals do not fall at all.
    """
    from scipy.optimize import isotonic_regression  # noqa: PLC0415 - SciPy is slow to import

    x, y, w = (np.asarray(each, dtype=np.float64) for each in (excess, residuals, weights))
    order = np.argsort(x)
    groups = np.array_split(order, pieces)
    nodes = np.array([np.average(x[group], weights=w[group]) for group in groups])
    levels = np.array([_weighted_median(y[group], w[group]) for group in groups])
    falling = isotonic_regression(levels, weights=[w[group].sum() for group in groups], increasing=False).x
    return WalkCurve.from_table(nodes, falling), float(falling[0] - falling[-1])


def _weighted_median(values: FloatArray, weights: FloatArray) -> float:
    order = np.argsort(values)
    shares = np.cumsum(weights[order]) / weights.sum()
    return float(values[order][np.searchsorted(shares, 0.5)])


# A recording is explained by one curve again and again.
@lru_cache(maxsize=8)
def _blurred(curve: WalkCurve, excess_scale: float) -> tuple[WalkCurve, FloatArray]:
    if excess_scale == 0.0:
        return curve, np.zeros(_NODES)
    shares = (np.arange(_QUANTILES) + 0.5) / _QUANTILES
    below = 1.0 / (1.0 + np.exp(np.minimum(_grid() / excess_scale, _LARGEST)))[:, None]
    # Quantiles of the excess, of the part of its distribution that is above the threshold.
    chances = below + (1.0 - below) * shares
    values = curve(_grid()[:, None] + excess_scale * np.log(chances / (1.0 - chances)))
    return WalkCurve(values=np.minimum.accumulate(values.mean(axis=1))), values.std(axis=1)


def _grid() -> FloatArray:
    grid: FloatArray = EXCESS_STEP * np.arange(_NODES, dtype=np.float64)
    return grid
