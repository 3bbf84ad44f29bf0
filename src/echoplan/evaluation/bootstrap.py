"""Statistics of pooled errors, each with a bootstrap confidence interval.

Errors of one recording share its poses, its air and its room, so they are not independent: recordings are drawn with
replacement, not errors (the cluster bootstrap; Davison and Hinkley 1997, Section 3.8).  Of one recording alone its
errors are drawn, which understates the interval.  Intervals are percentiles of the draws (Efron and Tibshirani 1993,
Chapter 13).
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import nan
from typing import TypeAlias

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.settings import Settings

__all__ = ["BootstrapSettings", "Distribution", "Interval", "describe", "describe_share"]

# Takes n values and how often each occurs in each of d draws, and returns k statistics of each draw, shape (d, k).
_Statistics: TypeAlias = Callable[[FloatArray, IntArray], FloatArray]


class BootstrapSettings(Settings):
    """How confidence intervals are estimated."""

    resamples: int = Field(default=1000, ge=1, description="Number of bootstrap samples.")
    confidence: float = Field(
        default=0.95, gt=0, lt=1, description="Share of the bootstrap samples inside the interval."
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Interval:
    """A statistic with its confidence interval.

    Parameters
    ----------
    value : float, optional
        The statistic of all that was measured; nan if nothing was.
    low, high : float, optional
        Bounds of the interval; nan if fewer than two were measured.
    """

    value: float = nan
    low: float = nan
    high: float = nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Distribution:
    """What there is to say of a set of errors, in their unit.

    Parameters
    ----------
    count : int, optional
        How many there are.
    mean, median, percentile95, rms : Interval, optional
        Mean, median, 95th percentile and root mean square.
    maximum : float, optional
        The greatest; a bootstrap cannot bound it.
    """

    count: int = 0
    mean: Interval = Interval()
    median: Interval = Interval()
    percentile95: Interval = Interval()
    rms: Interval = Interval()
    maximum: float = nan


def describe(
    samples: Iterable[Sequence[float]], *, rng: np.random.Generator, settings: BootstrapSettings | None = None
) -> Distribution:
    """Describe errors that were pooled over recordings.

    Parameters
    ----------
    samples : iterable of sequence of float
        The errors of each recording; some may have none.
    rng : numpy.random.Generator
        Source of the draws.
    settings : BootstrapSettings, optional
        How many draws, which interval.

    Returns
    -------
    Distribution
        Statistics in the unit of the errors.

    Examples
    --------
    >>> describe([[1.0, 3.0], [2.0]], rng=np.random.default_rng(0)).mean.value
    2.0
    """
    filled = [np.asarray(sample, dtype=np.float64) for sample in samples if len(sample)]
    if not filled:
        return Distribution()
    mean, median, percentile95, rms = _intervals(filled, _statistics, rng=rng, settings=settings)
    return Distribution(
        count=sum(map(len, filled)),
        mean=mean,
        median=median,
        percentile95=percentile95,
        rms=rms,
        maximum=max(float(sample.max()) for sample in filled),
    )


def describe_share(
    counts: Iterable[tuple[int, int]], *, rng: np.random.Generator, settings: BootstrapSettings | None = None
) -> Interval:
    """Pool a share, such as recall, over recordings.

    Parameters
    ----------
    counts : iterable of tuple of int
        Of each recording how many there are of how many.
    rng : numpy.random.Generator
        Source of the draws.
    settings : BootstrapSettings, optional
        How many draws, which interval.

    Returns
    -------
    Interval
        The share of all together, in [0, 1].

    Examples
    --------
    >>> describe_share([(1, 2), (2, 2)], rng=np.random.default_rng(0)).value
    0.75
    """
    filled = [np.repeat([1.0, 0.0], [part, whole - part]) for part, whole in counts if whole]
    return _intervals(filled, _means, rng=rng, settings=settings)[0] if filled else Interval()


def _intervals(
    filled: list[FloatArray], statistics: _Statistics, *, rng: np.random.Generator, settings: BootstrapSettings | None
) -> list[Interval]:
    """Draw recordings with replacement; of one recording alone, its values."""
    settings = settings or BootstrapSettings()
    values = np.concatenate(filled)
    units = np.repeat(np.arange(len(filled)), [len(sample) for sample in filled])
    if len(filled) == 1:
        units = np.arange(len(values))
    found = statistics(values, np.ones((1, len(values)), dtype=np.int64))[0]
    number = int(units[-1]) + 1
    if number == 1:
        return [Interval(value=float(value)) for value in found]
    draws = rng.multinomial(number, np.full(number, 1 / number), size=settings.resamples)
    tail = (1 - settings.confidence) / 2
    bounds = np.quantile(statistics(values, draws[:, units]), [tail, 1 - tail], axis=0)
    return [
        Interval(value=float(value), low=float(low), high=float(high))
        for value, low, high in zip(found, *bounds, strict=True)
    ]


def _means(values: FloatArray, counts: IntArray) -> FloatArray:
    """Means of n values that occur so many times in each of d draws, shape (d, 1)."""
    means: FloatArray = counts @ values / counts.sum(axis=1)
    return means[:, None]


def _statistics(values: FloatArray, counts: IntArray) -> FloatArray:
    """Mean, median, 95th percentile and root mean square of each draw, shape (d, 4)."""
    order = values.argsort()
    quantiles = [_quantiles(values[order], counts[:, order], share) for share in (0.5, 0.95)]
    return np.hstack([_means(values, counts), *quantiles, np.sqrt(_means(values**2, counts))])


def _quantiles(ordered: FloatArray, counts: IntArray, share: float) -> FloatArray:
    """Quantiles between order statistics (type 7 of Hyndman and Fan 1996, as NumPy's), shape (d, 1)."""
    ranks = counts.cumsum(axis=1)
    positions = share * (ranks[:, -1:] - 1)
    below = ordered[(ranks > np.floor(positions)).argmax(axis=1)]
    above = ordered[(ranks > np.ceil(positions)).argmax(axis=1)]
    between: FloatArray = below + (positions[:, 0] % 1) * (above - below)
    return between[:, None]
