import numpy as np
import pytest

from echoplan.preprocessing import KmeansSettings, echo_points, kmeans_filter
from helpers import scenes


def room_with_strays(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Two walls detected over 60 degrees each, with some readings replaced by stray echoes."""
    bearings = np.concatenate([scenes.around(0.0, np.radians(30)), scenes.around(2.0, np.radians(30))])
    ranges = np.concatenate(
        [
            scenes.wall_ranges(bearings[:61], normal=0.0, distance=1.0),
            scenes.wall_ranges(bearings[61:], normal=2.0, distance=2.0),
        ]
    )
    rng = np.random.default_rng(7)
    strays = rng.choice(len(bearings), size=count, replace=False)
    ranges[strays] = rng.uniform(0.1, 2.8, size=count)
    return bearings, ranges, strays


def test_echo_points_lie_on_the_beam_axes() -> None:
    pings = scenes.pings(np.array([0.0, np.pi / 2]), np.array([1.0, 2.0]))
    assert np.allclose(echo_points(pings), [[1.05, 0.0], [0.0, 2.05]])


def test_most_stray_echoes_go_and_nearly_all_others_stay() -> None:
    bearings, ranges, strays = room_with_strays(8)
    kept = kmeans_filter(scenes.pings(bearings, ranges))
    kept_strays = np.isin(kept.bearings, bearings[strays]).sum()
    assert kept_strays <= 2
    assert len(kept) - kept_strays >= 0.95 * (len(bearings) - len(strays))


def test_a_clean_sweep_loses_next_to_nothing() -> None:
    bearings, ranges, _ = room_with_strays(0)
    assert len(kmeans_filter(scenes.pings(bearings, ranges))) >= 0.95 * len(bearings)


def test_the_filter_is_deterministic_and_keeps_the_order() -> None:
    bearings, ranges, _ = room_with_strays(8)
    first, second = (kmeans_filter(scenes.pings(bearings, ranges)) for _ in range(2))
    assert np.array_equal(first.bearings, second.bearings)
    assert np.all(np.diff([np.flatnonzero(bearings == b)[0] for b in first.bearings]) > 0)


@pytest.mark.parametrize("count", [0, 1, 9])
def test_too_few_pings_for_two_clusters_pass_untouched(count: int) -> None:
    bearings = np.arange(count) * scenes.STEP
    assert len(kmeans_filter(scenes.pings(bearings, np.ones(count)))) == count


def test_a_cluster_of_too_few_pings_is_stray() -> None:
    bearings, ranges, _ = room_with_strays(0)
    assert len(kmeans_filter(scenes.pings(bearings, ranges), KmeansSettings(min_members=1000))) == 0
