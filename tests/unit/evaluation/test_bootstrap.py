import numpy as np
import pytest
from pydantic import ValidationError

from echoplan.evaluation import BootstrapSettings, Distribution, Interval
from echoplan.evaluation.bootstrap import describe, describe_share

SAMPLES = [[0.0, 1.0, 9.0], [2.0], [], [3.0, 5.0]]


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_statistics_are_those_of_all_errors_together() -> None:
    pooled = np.concatenate(SAMPLES)
    found = describe(SAMPLES, rng=rng())
    assert found.count == 6
    assert found.mean.value == pytest.approx(10 / 3)
    assert found.median.value == pytest.approx(2.5)
    assert found.percentile95.value == pytest.approx(np.percentile(pooled, 95))
    assert found.rms.value == pytest.approx(np.sqrt(20))
    assert found.maximum == 9.0


def test_intervals_are_those_of_drawing_whole_recordings_again_and_again() -> None:
    # The plain bootstrap, draw by draw, with NumPy's own statistics.
    settings = BootstrapSettings(resamples=3000, confidence=0.9)
    found = describe(SAMPLES, rng=rng(1), settings=settings)
    filled = [np.array(sample) for sample in SAMPLES if sample]
    draws = [np.concatenate([filled[index] for index in draw]) for draw in rng(2).integers(3, size=(3000, 3))]
    for name, statistic in (
        ("mean", np.mean),
        ("median", np.median),
        ("percentile95", lambda values: np.percentile(values, 95)),
        ("rms", lambda values: np.sqrt(np.mean(values**2))),
    ):
        low, high = np.quantile([statistic(draw) for draw in draws], [0.05, 0.95])
        interval = getattr(found, name)
        assert (interval.low, interval.high) == pytest.approx((low, high), abs=0.05), name


def test_errors_that_share_a_recording_say_less_than_as_many_independent_ones() -> None:
    errors = rng(3).normal(size=10)
    together = describe([np.repeat(error, 20).tolist() for error in errors], rng=rng())
    apart = describe([[error] for error in np.repeat(errors, 20)], rng=rng())
    assert together.mean.high - together.mean.low > 3 * (apart.mean.high - apart.mean.low)


def test_of_one_recording_its_errors_are_drawn() -> None:
    alone = describe([[1.0, 2.0, 3.0]], rng=rng())
    assert 1.0 <= alone.mean.low < 2.0 < alone.mean.high <= 3.0


def test_an_interval_covers_the_true_mean_about_as_often_as_it_says() -> None:
    draw = rng(4)
    found = [describe(draw.normal(5.0, 1.0, size=(40, 1)).tolist(), rng=draw).mean for _ in range(200)]
    covered = np.mean([interval.low <= 5.0 <= interval.high for interval in found])
    assert 0.89 <= covered <= 0.98


def test_one_error_has_no_interval_and_no_error_has_no_statistics() -> None:
    one = describe([[], [0.5]], rng=rng())
    assert (one.count, one.mean.value, one.maximum) == (1, 0.5, 0.5)
    assert np.isnan([one.mean.low, one.mean.high]).all()
    nothing = describe([[], []], rng=rng())
    assert nothing.count == 0
    assert np.isnan([nothing.mean.value, nothing.maximum]).all()


def test_the_same_generator_gives_the_same_intervals() -> None:
    errors = rng(5).normal(size=(30, 2)).tolist()
    first, second, other = (describe(errors, rng=rng(seed)) for seed in (6, 6, 7))
    assert first == second
    assert first != other
    assert first.mean.value == other.mean.value


def test_a_share_is_that_of_all_counts_together() -> None:
    share = describe_share([(1, 4), (5, 5), (0, 0)], rng=rng())
    assert share.value == pytest.approx(6 / 9)
    assert (share.low, share.high) == pytest.approx((0.25, 1.0))


def test_the_share_of_one_recording_is_bounded_by_drawing_its_objects() -> None:
    share = describe_share([(6, 8)], rng=rng())
    assert share.value == 0.75
    assert 0.25 <= share.low < 0.75 < share.high <= 1.0


def test_a_share_of_nothing_is_unknown() -> None:
    assert np.isnan(describe_share([(0, 0)], rng=rng()).value)
    assert np.isnan(describe_share([], rng=rng()).value)


def test_a_confidence_of_one_is_refused() -> None:
    with pytest.raises(ValidationError, match="less than 1"):
        BootstrapSettings(confidence=1.0)


def test_an_unmeasured_distribution_is_empty() -> None:
    assert Distribution().count == 0
    assert np.isnan(Interval().value)
