"""Laws of clusters, compensation and located points."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from echoplan.extraction import (
    Cluster,
    arm_excess,
    differential_clusters,
    flat_excess,
    minimum_distance_point,
    region_of_constant_depth,
)
from echoplan.geometry import wrap
from helpers import scenes

angles = st.floats(-np.pi, np.pi)
seeds = st.integers(0, 10_000)
arms = st.floats(0.0, 0.2)
depths = st.floats(0.1, 4.0)
radii = st.floats(0.0, 2.0)


def sweep(seed: int, turn: float) -> tuple[np.ndarray, np.ndarray]:
    """Bearings and ranges of a circle of four reflectors with gaps, strays and noise, as if the robot had turned."""
    rng = np.random.default_rng(seed)
    bearings = np.radians(np.arange(360.0))
    ranges = np.array([1.0, 1.4, 0.7, 2.2])[np.arange(360) // 90] + rng.normal(0, 0.002, 360)
    ranges[rng.choice(360, 15, replace=False)] = rng.uniform(0.1, 2.8, 15)
    detected = rng.random(360) > 0.1
    return np.asarray(wrap(bearings[detected] + turn)), ranges[detected]


def wall(normal: float, half_width: float, arm: float, distance: float) -> Cluster:
    bearings = scenes.around(normal, half_width)
    ranges = scenes.wall_ranges(bearings, normal=normal, distance=distance, arm=arm) + 0.03 * (bearings - normal) ** 2
    return Cluster(pings=scenes.pings(bearings, ranges, arm=arm), bearings=bearings, right=np.inf, left=np.inf)


@given(seeds, angles)
def test_no_echo_is_in_two_clusters_and_neighbours_in_one_do_not_jump(seed: int, turn: float) -> None:
    bearings, ranges = sweep(seed, turn)
    clusters = differential_clusters(scenes.pings(bearings, ranges))
    members = np.concatenate([cluster.pings.ranges for cluster in clusters])
    assert len(members) == len(np.unique(members)) <= len(ranges)
    for cluster in clusters:
        assert (np.diff(cluster.bearings) >= 0).all()
        assert 0 <= cluster.extent < 2 * np.pi


@given(seeds, angles)
def test_clusters_do_not_depend_on_where_the_robot_looks(seed: int, turn: float) -> None:
    plain, turned = (
        {
            frozenset(cluster.pings.ranges.tolist())
            for cluster in differential_clusters(scenes.pings(*sweep(seed, each)))
        }
        for each in (0.0, turn)
    )
    assert plain == turned


@given(angles, arms, depths, radii)
def test_turning_either_way_an_arm_adds_as_much_and_never_less_than_nothing(
    angle: float, arm: float, depth: float, radius: float
) -> None:
    one, other = (arm_excess(each, arm=arm, depth=depth, radius=radius) for each in (angle, -angle))
    assert one == pytest.approx(other)
    assert one >= -1e-12


@given(angles, arms, depths, radii)
def test_no_object_adds_less_than_a_flat_nor_more_than_its_edge(
    angle: float, arm: float, depth: float, radius: float
) -> None:
    flat = flat_excess(angle, arm=arm)
    found = arm_excess(angle, arm=arm, depth=depth, radius=radius)
    corner = arm_excess(angle, arm=arm, depth=depth, radius=0.0)
    assert flat - 1e-12 <= found <= corner + 1e-12


@given(angles, st.floats(0.2, 0.6), arms, st.floats(0.5, 3.0))
def test_a_wall_is_located_wherever_it_stands_and_however_long_the_arm_is(
    normal: float, half_width: float, arm: float, distance: float
) -> None:
    point = minimum_distance_point(wall(normal, half_width, arm, distance))
    assert point is not None
    assert point.bearing == pytest.approx(normal, abs=1e-6)
    assert point.distance == pytest.approx(distance, abs=1e-6)


@given(angles, st.floats(0.2, 0.6), st.floats(0.5, 3.0))
def test_a_region_of_constant_depth_lies_within_its_cluster(normal: float, half_width: float, distance: float) -> None:
    cluster = wall(normal, half_width, scenes.ARM, distance)
    region = region_of_constant_depth(cluster)
    assert region is not None
    assert cluster.bearings[0] <= region.bearing_min <= region.bearing_max <= cluster.bearings[-1]
    assert cluster.distances.min() <= region.depth <= cluster.distances.max()
    assert region.pings <= len(cluster.pings)
