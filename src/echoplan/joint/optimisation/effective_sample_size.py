"""Correlation of range errors: effective sample size, intraclass correlation and shared rounding error."""

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.preprocessing.measurements import Measurements

__all__ = ["effective_sample_ratio", "gain_of_common_errors", "intraclass_correlation", "shared_rounding_sigma"]

# Residuals beyond this many sigmas are outliers.
_WILD = 4.0
# Lower bound of the standard deviation of a reading [m].
_LEAST = 0.0005
# Minimum number of pairs for an autocorrelation.
_FEWEST = 50
# Harmonics of the rounding error: enough for 99 % of its variance.
_HARMONICS = np.arange(1, 61)


def effective_sample_ratio(
    measurements: Measurements, owners: IntArray, residuals: FloatArray, *, noise: float
) -> float:
    r"""Return the ratio of the effective sample size to the weight of the readings: 1 to 1 / weight.

    Weights treat pings 4 degrees apart as independent and are proportionally less for nearer ones. The residuals of a
    solution allow a better estimate: the variance of the mean of correlated errors is that of independent ones times
    the sum of their autocorrelation (Priestley 1981, Section 5.3.2).

    .. math:: \tau = 1 + 2 \sum_{k=1}^{1/w - 1} \rho_k, \qquad f = 1 / (w \tau)

    ``owners`` are the associated landmarks, -1 for none, ``residuals`` those of the readings [m], both of shape (n,);
    ``noise`` is the standard deviation of a reading [m].
    """
    weight = float(np.median(measurements.weights)) if len(measurements.weights) else 1.0
    lags = round(1.0 / weight)
    order = np.lexsort((measurements.bearings, measurements.sensors, measurements.stations))
    # Number of the landmark, station and sensor of each ping; -1 without a landmark.
    stations, sensors = len(measurements.centers), int(measurements.sensors.max(initial=0)) + 1
    numbers = (owners * stations + measurements.stations) * sensors + measurements.sensors
    left, whose = residuals[order], np.where(owners >= 0, numbers, -1)[order]
    inliers = (whose >= 0) & (np.abs(left) < _WILD * noise)
    correlations = [_correlation(left, whose, inliers, lag) for lag in range(1, lags)]
    spread = 1.0 + 2.0 * sum(correlations)
    return max(1.0, 1.0 / (weight * max(spread, 1.0)))


def intraclass_correlation(
    measurements: Measurements, owners: IntArray, residuals: FloatArray, *, noise: float
) -> float:
    r"""Return the share of the variance that residuals of one landmark from one station have in common.

    It is the ICC(1) of a one-way analysis of variance (Shrout and Fleiss 1979). A station whose pose is wrong by
    centimetres shifts all its readings of a wall; from exact poses the errors of readings are independent.

    .. math:: \mathrm{ICC} = \frac{B - W}{B + (k - 1) W}

    B and W are the mean squares between and within the groups of readings of one landmark from one station, k is the
    mean size of a group. The result is 0 if no group has two readings.
    """
    inliers, members = _members(measurements, owners, residuals, noise)
    sizes = np.bincount(members)
    if len(sizes) == len(members):
        return 0.0
    means = np.bincount(members, residuals[inliers]) / sizes
    between = float(sizes @ means**2) / len(sizes)
    within = float(np.sum((residuals[inliers] - means[members]) ** 2)) / (len(members) - len(sizes))
    size = len(members) / len(sizes)
    return (between - within) / max(between + (size - 1.0) * within, 1e-12)


def shared_rounding_sigma(step: float, scatter: float) -> float:
    r"""Return the standard deviation of the rounding error that readings of one distance share [m].

    The rounding error is a sawtooth function of the rounded value. In the mean over readings with Gaussian scatter each
    of its harmonics is multiplied by the characteristic function of the scatter (Widrow and Kollar 2008), so nothing
    remains if readings scatter over several steps. Over all distances the mean has the variance

    .. math:: \sum_{k \ge 1} \frac{q^2}{2 \pi^2 k^2} \, e^{-4 \pi^2 k^2 \sigma^2 / q^2}

    with q, the ``step`` of the readings [m], and :math:`\sigma`, their ``scatter`` before rounding [m].

    Examples
    --------
    >>> [round(1000 * shared_rounding_sigma(0.01, scatter), 2) for scatter in (0.0, 0.002, 0.004)]
    [2.87, 1.02, 0.1]
    """
    if step == 0.0:
        return 0.0
    waves = step / (np.sqrt(2.0) * np.pi * _HARMONICS)
    return float(np.sqrt(np.sum((waves * np.exp(-2.0 * (np.pi * _HARMONICS * scatter / step) ** 2)) ** 2)))


def gain_of_common_errors(
    measurements: Measurements, owners: IntArray, residuals: FloatArray, *, noise: float, common: float
) -> float:
    r"""Return the log-likelihood ratio of errors with a part shared by landmark and station [nats].

    The error of a reading is the sum of an independent part of standard deviation s and of one of standard deviation t
    that its group shares: a one-way analysis of variance with random effects (Searle, Casella and McCulloch 1992,
    Section 3.8). With W, the sum of the weights of a group, their weighted mean m, and S and V, the weighted sums of
    squares about zero and about m, the log-likelihood ratio against independent errors of standard deviation n is

    .. math:: \sum_g W \ln\frac{n}{s} + \frac{S}{2 n^2} - \frac{V}{2 s^2} - \frac12 \ln(1 + W t^2 / s^2)
              - \frac{m^2}{2 (t^2 + s^2 / W)}

    ``noise`` is n and ``common`` is t [m]; s is estimated from the residuals. A reading contributes to V no more than
    one that is four sigmas off. The result is 0 if no group has two readings.
    """
    inliers, members = _members(measurements, owners, residuals, noise)
    sizes = np.bincount(members)[members]
    shared = sizes > 1
    if not shared.any():
        return 0.0
    left, weights = residuals[inliers], measurements.weights[inliers]
    counts = np.bincount(members, weights)
    means = np.bincount(members, weights * left) / counts
    own = left - means[members]
    # Deviations from the mean of n errors are too small by a factor of sqrt((n - 1) / n).
    spread = np.abs(own[shared]) * np.sqrt(sizes[shared] / (sizes[shared] - 1.0))
    single = max(1.4826 * float(np.median(spread)), _LEAST)
    misfits = np.minimum((own / single) ** 2, _WILD**2)
    gained = weights @ (np.log(noise / single) + 0.5 * (left / noise) ** 2 - 0.5 * misfits)
    lost = np.log1p(counts * (common / single) ** 2) + means**2 / (common**2 + single**2 / counts)
    return float(gained - 0.5 * lost.sum())


def _members(
    measurements: Measurements, owners: IntArray, residuals: FloatArray, noise: float
) -> tuple[BoolArray, IntArray]:
    """Return which readings are inliers of a landmark, and the group (landmark and station) of each of these."""
    inliers = (owners >= 0) & (np.abs(residuals) < _WILD * noise)
    groups = owners[inliers] * len(measurements.centers) + measurements.stations[inliers]
    return inliers, np.unique(groups, return_inverse=True)[1]


def _correlation(residuals: FloatArray, whose: IntArray, inliers: BoolArray, lag: int) -> float:
    pairs = inliers[:-lag] & inliers[lag:] & (whose[:-lag] == whose[lag:])
    if pairs.sum() < _FEWEST:
        # With too few pairs, neighbours are assumed to be fully correlated.
        return 1.0
    first, second = residuals[:-lag][pairs], residuals[lag:][pairs]
    power = float(np.sqrt((first @ first) * (second @ second)))
    return float(first @ second) / power if power > 0.0 else 1.0
