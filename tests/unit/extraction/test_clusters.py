import numpy as np
import pytest

from echoplan.errors import InvalidValueError
from echoplan.extraction import Cluster, ClusteringSettings, differential_clusters, hub_distances
from helpers import scenes


def test_hub_distance_is_range_plus_arm() -> None:
    pings = scenes.pings(np.array([0.0, 2.0]), np.array([1.0, 0.5]), hub=(3.0, 4.0), arm=0.07)
    assert np.allclose(hub_distances(pings), [1.07, 0.57])


def test_a_jump_in_distance_separates_two_reflectors() -> None:
    bearings = scenes.around(0.0, np.radians(20))
    ranges = np.where(bearings < 0, 1.0, 1.1)
    right, left = differential_clusters(scenes.pings(bearings, ranges))
    assert len(right.pings) == 20
    assert len(left.pings) == 21
    assert right.left == pytest.approx(1.15)
    assert left.right == pytest.approx(1.05)
    assert right.right == np.inf


def test_a_run_wraps_around_the_full_circle() -> None:
    bearings = np.mod(scenes.around(np.pi, np.radians(30)), 2 * np.pi)
    (cluster,) = differential_clusters(scenes.pings(np.roll(bearings, 17), np.full(61, 1.0)))
    assert cluster.extent == pytest.approx(np.radians(60))
    assert np.all(np.diff(cluster.bearings) > 0)


def test_a_run_bridges_dropouts_and_a_stray_echo() -> None:
    bearings = scenes.around(0.5, np.radians(25))
    ranges = np.full(len(bearings), 1.5)
    ranges[20] = 0.4
    detected = np.ones(len(bearings), dtype=bool)
    detected[[10, 11, 30]] = False
    clusters = differential_clusters(scenes.pings(bearings[detected], ranges[detected]))
    assert [len(cluster.pings) for cluster in clusters] == [len(bearings) - 4]
    assert clusters[0].extent == pytest.approx(np.radians(50))


def test_a_gap_of_many_steps_ends_a_run() -> None:
    bearings = np.concatenate([scenes.around(0.0, np.radians(10)), scenes.around(0.6, np.radians(10))])
    assert len(differential_clusters(scenes.pings(bearings, np.ones(len(bearings))))) == 2


def test_a_run_of_too_few_pings_is_no_cluster() -> None:
    assert differential_clusters(scenes.pings(np.array([0.0, 0.01]), np.ones(2))) == []
    few = ClusteringSettings(min_pings=2)
    assert len(differential_clusters(scenes.pings(np.array([0.0, 0.01]), np.ones(2)), few)) == 1


def test_no_pings_make_no_clusters() -> None:
    assert differential_clusters(scenes.pings(np.zeros(0), np.zeros(0))) == []


def test_what_lies_beyond_a_gap_is_no_neighbour() -> None:
    bearings = np.concatenate([scenes.around(0.0, np.radians(10)), scenes.around(0.6, np.radians(10))])
    first, second = differential_clusters(scenes.pings(bearings, np.where(bearings < 0.3, 1.0, 0.5)))
    assert (first.left, second.right) == (np.inf, np.inf)


def test_a_slope_is_one_reflector_as_long_as_no_step_of_it_is_a_jump() -> None:
    bearings = scenes.around(0.0, np.radians(20))
    gentle, steep = (1.0 + slope * np.arange(len(bearings), dtype=np.float64) for slope in (0.019, 0.021))
    settings = ClusteringSettings(jump=0.02, reach=1)
    assert len(differential_clusters(scenes.pings(bearings, gentle), settings)) == 1
    assert differential_clusters(scenes.pings(bearings, steep), settings) == []


def test_without_reach_a_stray_echo_splits_a_run() -> None:
    bearings = scenes.around(0.5, np.radians(25))
    ranges = np.full(len(bearings), 1.5)
    ranges[20] = 0.4
    split = differential_clusters(scenes.pings(bearings, ranges), ClusteringSettings(reach=1))
    assert sorted(len(cluster.pings) for cluster in split) == [20, 30]


def test_a_cluster_has_as_many_bearings_as_pings_and_a_hub() -> None:
    bearings = scenes.around(0.0, 0.2)
    pings = scenes.pings(bearings, np.ones(len(bearings)), hub=(2.0, -1.0))
    (cluster,) = differential_clusters(pings)
    assert cluster.hub_xy == pytest.approx([2.0, -1.0])
    assert cluster.distances == pytest.approx(np.full(len(bearings), 1.0 + scenes.ARM))
    with pytest.raises(InvalidValueError, match="bearings"):
        Cluster(pings=pings, bearings=bearings[1:], right=np.inf, left=np.inf)
