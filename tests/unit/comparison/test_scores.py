"""What methods reached, pooled over recordings."""

import math

import pytest

from echoplan.comparison import score_methods
from echoplan.model import FeatureClass, FeatureMap
from helpers.outcomes import failed, mapped, some, subject


def test_walls_are_pooled_over_all_recordings_with_a_map() -> None:
    good, poor = score_methods(some(), ["good", "poor"])
    assert good.summary is not None
    assert poor.summary is not None
    assert good.summary.classes[FeatureClass.WALL].recall.value == 1.0
    assert poor.summary.classes[FeatureClass.WALL].recall.value == pytest.approx(3 / 5)
    assert (good.summary.recordings, poor.summary.recordings) == (2, 1)


def test_a_failed_trial_gives_no_map_and_costs_nothing() -> None:
    _, poor = score_methods(some(), ["good", "poor"])
    assert (poor.maps, len(poor.outcomes)) == (1, 2)
    assert poor.seconds_per_thousand_pings == pytest.approx(2.0)


def test_time_is_that_of_all_maps_over_all_their_pings() -> None:
    first, second = subject("a"), subject("b")
    found = FeatureMap(method="m")
    outcomes = [mapped("m", found, of=first, seconds=0.36), mapped("m", found, of=second, seconds=1.08)]
    assert score_methods(outcomes, ["m"])[0].seconds_per_thousand_pings == pytest.approx(2.0)


def test_a_method_that_always_fails_has_neither_scores_nor_costs() -> None:
    (score,) = score_methods([failed("m", "no", of=subject())], ["m"])
    assert score.summary is None
    assert score.maps == 0
    assert math.isnan(score.seconds_per_thousand_pings)
    assert math.isnan(score.peak_memory)


def test_methods_come_in_the_order_wanted() -> None:
    assert [score.method for score in score_methods(some(), ["poor", "good"])] == ["poor", "good"]


def test_without_truth_there_is_no_summary() -> None:
    assert all(score.summary is None for score in score_methods(some(truth=None), ["good", "poor"]))
