"""The weights of neighbouring pings depend on how much of their errors they share."""

import numpy as np
import pytest
from scipy.signal import lfilter
from scipy.stats import multivariate_normal

from echoplan.arrays import FloatArray, IntArray
from echoplan.joint.optimisation.effective_sample_size import (
    effective_sample_ratio,
    gain_of_common_errors,
    intraclass_correlation,
    shared_rounding_sigma,
)
from helpers.expectations import listening

# Eight stations whose pings, a degree apart, detect one wall; a full count is four times the weight.
MEASUREMENTS = listening([(0.1 * k, 0.0) for k in range(8)], step=np.radians(1.0))
PINGS = len(MEASUREMENTS.readings)
OWNERS = np.zeros(PINGS, dtype=np.int64)
NOISE = 0.003
WHITE = NOISE * np.random.default_rng(3).standard_normal(PINGS)


def ratio_of(residuals: FloatArray) -> float:
    return effective_sample_ratio(MEASUREMENTS, OWNERS, residuals, noise=NOISE)


def autocorrelated(correlation: float) -> FloatArray:
    """Return errors of first-order autocorrelation, with the same power."""
    errors: FloatArray = lfilter([np.sqrt(1 - correlation**2)], [1.0, -correlation], WHITE)
    return errors


def test_pings_with_independent_errors_count_in_full() -> None:
    assert ratio_of(WHITE) == pytest.approx(4.0, rel=0.1)


def test_pings_with_common_errors_count_by_their_weights() -> None:
    assert ratio_of(np.repeat(WHITE[::8], 8)) == pytest.approx(1.0, abs=0.05)


def test_pings_with_autocorrelated_errors_count_in_between() -> None:
    # The autocorrelation of such errors at lag k is 0.5^k.
    assert ratio_of(autocorrelated(0.5)) == pytest.approx(4.0 / (1 + 2 * (0.5 + 0.25 + 0.125)), rel=0.1)


def test_outliers_do_not_hide_autocorrelation() -> None:
    wild = autocorrelated(0.5)
    wild[::50] = 0.5
    assert ratio_of(wild) == pytest.approx(ratio_of(autocorrelated(0.5)), rel=0.1)


def test_with_few_explained_pings_the_weights_are_kept() -> None:
    few = np.where(np.arange(PINGS) < 20, 0, -1)
    assert effective_sample_ratio(MEASUREMENTS, few, WHITE, noise=NOISE) == 1.0


def test_pings_far_apart_count_in_full() -> None:
    coarse = listening(step=np.radians(5.0))
    nothing = np.zeros(len(coarse.readings))
    assert effective_sample_ratio(coarse, np.zeros(len(nothing), dtype=np.int64), nothing, noise=NOISE) == 1.0


def correlation_of(errors_of_stations: FloatArray) -> float:
    """Return the intraclass correlation of readings with independent errors and errors per station."""
    residuals = WHITE + errors_of_stations[MEASUREMENTS.stations]
    return intraclass_correlation(MEASUREMENTS, OWNERS, residuals, noise=2 * NOISE)


def test_independent_errors_have_no_intraclass_correlation() -> None:
    assert correlation_of(np.zeros(8)) == pytest.approx(0.0, abs=0.01)


@pytest.mark.parametrize("share", [0.25, 1.0])
def test_the_intraclass_correlation_is_the_share_of_the_variance(share: float) -> None:
    errors = share * NOISE * np.array([1.0, -1.0, 1.0, -1.0, -1.0, 1.0, -1.0, 1.0])
    assert correlation_of(errors) == pytest.approx(share**2 / (1 + share**2), abs=0.02)


def test_groups_of_one_reading_have_no_intraclass_correlation() -> None:
    alone = np.where(np.arange(PINGS) % (PINGS // 8) == 0, 0, -1)
    assert intraclass_correlation(MEASUREMENTS, alone, WHITE, noise=NOISE) == 0.0


# Pings far enough apart to count in full: eight stations detect one wall.
FULL = listening([(0.1 * k, 0.0) for k in range(8)], step=np.radians(5.0))
OF_STATION = FULL.stations
ALL = np.zeros(len(OF_STATION), dtype=np.int64)
SINGLE = 0.002 * np.random.default_rng(5).standard_normal(len(OF_STATION))


def gain_of(residuals: FloatArray, noise: float, owners: IntArray = ALL) -> float:
    return gain_of_common_errors(FULL, owners, residuals, noise=noise, common=0.012)


def test_the_gain_of_common_errors_equals_that_of_the_joint_density() -> None:
    together = np.linspace(-0.012, 0.012, 8)[OF_STATION] + SINGLE
    noise = float(np.std(together))
    own = together - (np.bincount(OF_STATION, together) / np.bincount(OF_STATION))[OF_STATION]
    # The mean of each 72 readings takes one degree of freedom.
    single = 1.4826 * float(np.median(np.abs(own))) * np.sqrt(72 / 71)
    expected = 0.0
    for station in range(8):
        group = together[station == OF_STATION]
        shared = single**2 * np.eye(len(group)) + 0.012**2
        zero = np.zeros(len(group))
        expected += multivariate_normal.logpdf(group, zero, shared)
        expected -= multivariate_normal.logpdf(group, zero, noise**2 * np.eye(len(group)))
    assert gain_of(together, noise) == pytest.approx(expected)
    assert expected > 500.0


def test_two_readings_of_half_a_weight_count_as_one() -> None:
    together = np.linspace(-0.012, 0.012, 8)[OF_STATION] + SINGLE
    many = listening([(0.1 * k, 0.0) for k in range(8)], step=np.radians(2.5))
    halved = many._replace(weights=np.full(len(many.readings), 0.5))
    twice = gain_of_common_errors(
        halved, np.zeros(len(many.readings), dtype=np.int64), np.repeat(together, 2), noise=0.008, common=0.012
    )
    assert twice == pytest.approx(gain_of(together, 0.008), rel=0.01)


def test_one_outlier_costs_at_most_four_sigmas() -> None:
    together = np.linspace(-0.012, 0.012, 8)[OF_STATION] + SINGLE
    wild = together.copy()
    wild[5] += 0.03
    assert -15.0 < gain_of(wild, 0.01) - gain_of(together, 0.01) < 10.0


def test_groups_of_one_reading_have_no_gain_of_common_errors() -> None:
    alone = np.where(np.append(True, np.diff(OF_STATION) > 0), 0, -1)
    assert gain_of(SINGLE, 0.002, owners=alone) == 0.0


def test_independent_errors_have_no_gain_of_common_errors() -> None:
    assert -30.0 < gain_of(SINGLE, 0.002) < 0.0


def test_unexplained_readings_have_no_gain_of_common_errors() -> None:
    assert gain_of(SINGLE, 0.002, owners=np.full(len(ALL), -1)) == 0.0


@pytest.mark.parametrize("scatter", [0.0005, 0.002, 0.003])
def test_the_common_rounding_error_decreases_with_the_noise(scatter: float) -> None:
    rng, step = np.random.default_rng(5), 0.01
    places = np.linspace(0.0, step, 101)[:-1, None]
    readings = places + scatter * rng.standard_normal((100, 20_000))
    means = (np.round(readings / step) * step - readings).mean(axis=1)
    assert shared_rounding_sigma(step, scatter) == pytest.approx(means.std(), rel=0.03)


def test_readings_without_noise_have_the_full_rounding_error() -> None:
    assert shared_rounding_sigma(0.01, 0.0) == pytest.approx(0.01 / np.sqrt(12.0), rel=0.01)
    assert shared_rounding_sigma(0.01, 0.1) == 0.0
    assert shared_rounding_sigma(0.0, 0.001) == 0.0
