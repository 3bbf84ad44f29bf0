import numpy as np

from echoplan.preprocessing import is_valid, valid_pings, valid_ranges
from helpers import scenes


def test_only_readings_between_dead_distance_and_reach_are_ranges() -> None:
    ranges = np.array([np.inf, -np.inf, np.nan, 0.0, 0.029, 0.03, 1.0, 3.0, 3.001])
    pings = scenes.pings(np.arange(9) * scenes.STEP, ranges)
    assert is_valid(pings, scenes.rig()).tolist() == [False] * 5 + [True] * 3 + [False]


def test_a_reading_within_a_step_of_the_reach_means_that_nothing_was_detected_and_a_fault_is_invalid() -> None:
    ranges = np.array([np.inf, -np.inf, np.nan, 0.029, 0.03, 2.99, 2.995, 3.0, 3.5])
    found = valid_ranges(scenes.pings(np.arange(9) * scenes.STEP, ranges), scenes.rig())
    nan, inf = np.nan, np.inf
    np.testing.assert_array_equal(found, [inf, nan, nan, nan, 0.03, 2.99, inf, inf, inf])


def test_valid_pings_keep_their_order_and_their_place() -> None:
    pings = scenes.pings(np.array([0.3, 0.1, 0.2]), np.array([1.0, np.nan, 2.0]))
    kept = valid_pings(pings, scenes.rig())
    assert kept.ranges.tolist() == [1.0, 2.0]
    assert kept.bearings.tolist() == [0.3, 0.2]
