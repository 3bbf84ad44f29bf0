"""Independence: how much neighbouring pings repeat each other's errors, told by what is left of their readings."""

import numpy as np

from echoplan.arrays import BoolArray, FloatArray, IntArray
from echoplan.preprocessing.measurements import Measurements

__all__ = ["effective_sample_ratio", "gain_of_common_errors", "intraclass_correlation", "shared_rounding_sigma"]

# Residuals beyond so many deviations are no errors of readings.
_WILD = 4.0
# No reading is better than this [m].
_LEAST = 0.0005
# Fewer pairs of neighbours tell nothing.
_FEWEST = 50
# Harmonics of the error of rounding: enough for all but a hundredth of its square.
_HARMONICS = np.arange(1, 61)


def effective_sample_ratio(
    measurements: Measurements, owners: IntArray, residuals: FloatArray, *, noise: float
) -> float:
    r"""Tell how many times more readings count than their weights say.

    Weights take pings four degrees apart for independent, and nearer ones in proportion.  What is left of the
    readings after an adjustment tells better: the variance of a mean of correlated errors is that of independent ones
    times the sum of their autocorrelation (Priestley 1981, Section 5.3.2).

    .. math:: \tau = 1 + 2 \sum_{k=1}^{1/w - 1} \rho_k, \qquad f = 1 / (w \tau)

    Parameters
    ----------
    measurements : Measurements
        The pings.
    owners : ndarray of int, shape (n,)
        Which feature explains each; -1 for none.
    residuals : ndarray, shape (n,)
        What is left of their readings [m].
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    float
        At least 1, which stands for what the weights say, and at most one full count a ping.
    """
    weight = float(np.median(measurements.weights)) if len(measurements.weights) else 1.0
    lags = round(1.0 / weight)
    order = np.lexsort((measurements.bearings, measurements.sensors, measurements.stations))
    left, whose = residuals[order], _groups(measurements, owners)[order]
    inliers = (whose >= 0) & (np.abs(left) < _WILD * noise)
    correlations = [_correlation(left, whose, inliers, lag) for lag in range(1, lags)]
    spread = 1.0 + 2.0 * sum(correlations)
    return max(1.0, 1.0 / (weight * max(spread, 1.0)))


def intraclass_correlation(
    measurements: Measurements, owners: IntArray, residuals: FloatArray, *, noise: float
) -> float:
    r"""Tell how much of their errors the readings of one feature from one station have in common.

    It is that of a one-way analysis of variance, ICC(1) (Shrout and Fleiss 1979).  A station whose pose is off by
    centimetres reads all of a wall too near or too far; readings from exact poses err one by one.

    .. math:: \mathrm{ICC} = \frac{B - W}{B + (k - 1) W}

    Parameters
    ----------
    measurements : Measurements
        The pings.
    owners : ndarray of int, shape (n,)
        Which feature explains each; -1 for none.
    residuals : ndarray, shape (n,)
        What is left of their readings [m].
    noise : float
        Standard deviation of readings [m].

    Returns
    -------
    float
        B and W are the mean squares between and within the g groups of readings of one feature from one station, k
        their mean size; 0 where no group has two.
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
    r"""Tell by how much readings of one distance err together because they are rounded.

    The error of rounding is a saw-tooth of what is rounded.  Its mean over readings that scatter, here as Gaussians do,
    is each of its harmonics times their characteristic function there (Widrow and Kollar 2008): where readings scatter
    over several steps nothing of it is left.  Over all distances the mean has the variance

    .. math:: \sum_{k \ge 1} \frac{q^2}{2 \pi^2 k^2} \, e^{-4 \pi^2 k^2 \sigma^2 / q^2}

    Parameters
    ----------
    step : float
        Step q of the readings [m].
    scatter : float
        Standard deviation of what is rounded [m].

    Returns
    -------
    float
        Standard deviation of the common error [m].

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
    r"""Tell how much likelier readings are if those of one feature from one station may err together.

    Errors of a group of readings have a part of their own, of deviation s, and one in common, of deviation t: the model
    of a one-way analysis of variance with random effects (Searle, Casella and McCulloch 1992, Section 3.8).  With W,
    the sum of the weights of a group, their weighted mean m, and S and V, the weighted sums of squares about zero and
    about m, the logarithm of the ratio of its likelihood to that of independent errors of deviation n is

    .. math:: \sum_g W \ln\frac{n}{s} + \frac{S}{2 n^2} - \frac{V}{2 s^2} - \frac12 \ln(1 + W t^2 / s^2)
              - \frac{m^2}{2 (t^2 + s^2 / W)}

    No reading adds more to V than one that is four deviations off.

    Parameters
    ----------
    measurements : Measurements
        The pings.
    owners : ndarray of int, shape (n,)
        Which feature explains each; -1 for none.
    residuals : ndarray, shape (n,)
        What is left of their readings [m].
    noise : float
        Standard deviation n of readings [m].
    common : float
        Standard deviation t of what a group errs by together [m].

    Returns
    -------
    float
        The logarithm, with s as the readings have it; 0 where no group has two of them [nats].
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
    # A mean takes up a part of each error of the few that it is of.
    spread = np.abs(own[shared]) * np.sqrt(sizes[shared] / (sizes[shared] - 1.0))
    single = max(1.4826 * float(np.median(spread)), _LEAST)
    misfits = np.minimum((own / single) ** 2, _WILD**2)
    gained = weights @ (np.log(noise / single) + 0.5 * (left / noise) ** 2 - 0.5 * misfits)
    lost = np.log1p(counts * (common / single) ** 2) + means**2 / (common**2 + single**2 / counts)
    return float(gained - 0.5 * lost.sum())


def _members(
    measurements: Measurements, owners: IntArray, residuals: FloatArray, noise: float
) -> tuple[BoolArray, IntArray]:
    """Tell which readings are explained, and of which group of one feature and one station each of these is."""
    inliers = (owners >= 0) & (np.abs(residuals) < _WILD * noise)
    groups = owners[inliers] * len(measurements.centers) + measurements.stations[inliers]
    return inliers, np.unique(groups, return_inverse=True)[1]


def _groups(measurements: Measurements, owners: IntArray) -> IntArray:
    """Give a number to all pings that one sensor heard of one feature from one station; -1 for those of none."""
    stations, sensors = len(measurements.centers), int(measurements.sensors.max(initial=0)) + 1
    numbers = (owners * stations + measurements.stations) * sensors + measurements.sensors
    groups: IntArray = np.where(owners >= 0, numbers, -1)
    return groups


def _correlation(residuals: FloatArray, whose: IntArray, inliers: BoolArray, lag: int) -> float:
    pairs = inliers[:-lag] & inliers[lag:] & (whose[:-lag] == whose[lag:])
    if pairs.sum() < _FEWEST:
        # Where nothing is known neighbours are taken to say the same.
        return 1.0
    first, second = residuals[:-lag][pairs], residuals[lag:][pairs]
    power = float(np.sqrt((first @ first) * (second @ second)))
    return float(first @ second) / power if power > 0.0 else 1.0
