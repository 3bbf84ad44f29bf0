import numpy as np
import pytest

from echoplan.classical.features.kalman import KalmanSettings, Track, merged, misfits, tracked, update
from echoplan.classical.points import Segment

SETTINGS = KalmanSettings()
COVARIANCE = np.array([[4e-4, 1e-4], [1e-4, 1e-4]])


def segment(angle: float, offset: float, *, low: float = 0.0, high: float = 1.0, scale: float = 1.0) -> Segment:
    return Segment(line=np.array([angle, offset]), covariance=scale * COVARIANCE, low=low, high=high)


def track(angle: float, offset: float, *, sweep: int, low: float = 0.0, high: float = 1.0) -> Track:
    return Track(segment=segment(angle, offset, low=low, high=high), sweeps=frozenset({sweep}))


def test_a_second_measurement_as_good_halves_the_covariance() -> None:
    both = update(segment(0.3, 2.0), segment(0.34, 2.02))
    assert both.line == pytest.approx([0.32, 2.01])
    assert both.covariance == pytest.approx(COVARIANCE / 2)


def test_a_surer_measurement_counts_for_more() -> None:
    both = update(segment(0.3, 2.0, scale=3.0), segment(0.34, 2.02))
    assert both.line == pytest.approx([0.33, 2.015])
    assert np.linalg.eigvalsh(COVARIANCE - both.covariance).min() > 0


def test_angles_are_averaged_across_the_turn() -> None:
    both = update(segment(np.pi - 0.02, 2.0), segment(-np.pi + 0.04, 2.0))
    assert both.line[0] == pytest.approx(-np.pi + 0.01)


def test_a_line_is_as_long_as_its_measurements_together() -> None:
    both = update(segment(0.3, 2.0, low=-1.0, high=0.5), segment(0.3, 2.0, low=0.2, high=1.5))
    assert (both.low, both.high) == pytest.approx((-1.0, 1.5))


def test_updates_in_any_order_agree() -> None:
    one, two, three = segment(0.3, 2.0), segment(0.32, 2.01, scale=2.0), segment(0.28, 1.98, scale=0.5)
    forward, backward = update(update(one, two), three), update(update(three, two), one)
    assert forward.line == pytest.approx(backward.line)
    assert forward.covariance == pytest.approx(backward.covariance)


def test_the_misfit_is_the_mahalanobis_distance() -> None:
    near, far = misfits([segment(0.3, 2.0), segment(0.3, 2.1)], segment(0.34, 2.0), SETTINGS)
    difference = np.array([0.04, 0.0])
    assert near == pytest.approx(difference @ np.linalg.solve(2 * COVARIANCE, difference))
    assert far > near
    assert misfits([], segment(0.3, 2.0), SETTINGS).tolist() == []


def test_what_lies_far_along_the_line_is_another_wall() -> None:
    assert misfits([segment(0.3, 2.0)], segment(0.3, 2.0, low=1.8, high=2.5), SETTINGS).tolist() == [np.inf]
    assert misfits([segment(0.3, 2.0)], segment(0.3, 2.0, low=1.6, high=2.5), SETTINGS) == pytest.approx([0.0])


def test_a_measurement_updates_its_line_or_opens_another() -> None:
    tracks = tracked([track(0.3, 2.0, sweep=0)], track(0.31, 2.005, sweep=1), SETTINGS)
    assert [each.sweeps for each in tracks] == [{0, 1}]
    tracks = tracked(tracks, track(0.31, 2.5, sweep=2), SETTINGS)
    assert [each.sweeps for each in tracks] == [{0, 1}, {2}]


def test_lines_that_grew_together_are_merged() -> None:
    apart = [track(0.3, 2.0, sweep=0), track(0.3, 2.0, sweep=1, low=3.0, high=4.0)]
    assert len(merged(apart, SETTINGS)) == 2
    bridged = merged([*apart, track(0.3, 2.0, sweep=2, low=0.8, high=3.1)], SETTINGS)
    assert [each.sweeps for each in bridged] == [{0, 1, 2}]
