"""Laws of what is found among points: it moves with them, and counts, splits and learns without losing any."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from echoplan.arrays import FloatArray
from echoplan.classical.features.endpoints import split_at_farthest, split_at_steps
from echoplan.classical.features.kalman import KalmanSettings, Track, merged, misfits, tracked, update
from echoplan.classical.features.mixture import Mixture, MixtureSettings, learn
from echoplan.classical.points import (
    Cloud,
    Segment,
    SegmentSettings,
    features_of_points,
    find_segments,
    fit_orthogonal,
    fit_taubin,
    line_covariance,
)
from echoplan.geometry import directions, distances_to_segments, signed_distances, transform_points

SEEDS = st.integers(0, 10_000)
POSES = st.tuples(st.floats(-20, 20), st.floats(-20, 20), st.floats(-3, 3))
# A room without symmetry, and a column in it.
CORNERS = np.array([[0.0, 0.0], [3.0, 0.2], [2.6, 2.1], [0.2, 1.7]])
COLUMN = (1.2, 0.9, 0.15)


def room(seed: int) -> FloatArray:
    """Points on four walls and a column, a few millimetres off."""
    shares = np.linspace(0.03, 0.97, 45)[:, None]
    faces = [start + shares * (end - start) for start, end in zip(CORNERS, np.roll(CORNERS, -1, axis=0), strict=True)]
    points = np.concatenate([*faces, COLUMN[:2] + COLUMN[2] * directions(np.linspace(0.0, 5.5, 40))])
    noisy: FloatArray = points + np.random.default_rng(seed).normal(0, 0.003, size=points.shape)
    return noisy


def some_cloud(seed: int, *, count: int = 30) -> Cloud:
    """Points near a line somewhere, with weights."""
    rng = np.random.default_rng(seed)
    angle, offset = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, 5.0)
    along = rng.uniform(-1, 1, size=(count, 1)) * directions(angle + np.pi / 2)
    points = (offset + rng.normal(0, 0.02, size=(count, 1))) * directions(angle) + along
    return Cloud(points_xy=points, weights=rng.uniform(0.1, 3.0, size=count))


def some_segment(seed: int) -> Segment:
    """A segment with an uncertainty."""
    rng = np.random.default_rng(seed)
    root = rng.normal(0, 0.02, size=(2, 2))
    low, high = np.sort(rng.uniform(-2, 2, size=2))
    return Segment(
        line=np.array([rng.uniform(-0.1, 0.1), rng.uniform(1.9, 2.1)]),
        covariance=root @ root.T + 1e-5 * np.eye(2),
        low=float(low),
        high=float(high) + 0.1,
    )


@settings(max_examples=20)
@given(SEEDS, POSES)
def test_a_map_moves_with_its_points(seed: int, pose: tuple[float, float, float]) -> None:
    points = room(seed)
    found = features_of_points(transform_points(pose, points), np.ones(len(points)))
    assert (len(found.walls), len(found.corners), len(found.cylinders)) == (4, 4, 1)
    corners = np.array([corner.position_xy for corner in found.corners])
    there = transform_points(pose, CORNERS)
    assert np.hypot(*(corners[:, None] - there).transpose(2, 0, 1)).min(axis=1).max() < 0.02
    (column,) = found.cylinders
    assert column.center_xy == pytest.approx(transform_points(pose, np.array(COLUMN[:2])), abs=0.01)
    assert column.radius == pytest.approx(COLUMN[2], abs=0.01)


@settings(max_examples=20)
@given(SEEDS, st.floats(0.5, 20.0))
def test_heavier_points_show_the_same_walls(seed: int, weight: float) -> None:
    points = room(seed)
    light, heavy = (features_of_points(points, np.full(len(points), each)) for each in (1.0, weight))
    assert len(light.walls) == len(heavy.walls)
    for one, other in zip(light.walls, heavy.walls, strict=True):
        assert (one.normal_angle, one.offset) == pytest.approx((other.normal_angle, other.offset))


@given(SEEDS)
def test_no_other_line_is_nearer_than_the_orthogonal_regression(seed: int) -> None:
    cloud = some_cloud(seed)
    line = fit_orthogonal(cloud)

    def misfit(candidate: FloatArray) -> float:
        return float(cloud.weights @ signed_distances(candidate, cloud.points_xy) ** 2)

    beside = np.random.default_rng(seed).normal(0, 0.01, size=(30, 2))
    assert all(misfit(line) <= misfit(line + change) + 1e-12 for change in beside)


@given(SEEDS)
def test_the_covariance_of_a_line_is_positive_definite_and_falls_with_length(seed: int) -> None:
    cloud = some_cloud(seed)
    line = fit_orthogonal(cloud)
    covariance = line_covariance(cloud, line, SegmentSettings())
    assert np.linalg.eigvalsh(covariance).min() > 0
    middle = cloud.centroid_xy
    normal, tangent = directions(line[0]), directions(line[0] + np.pi / 2)
    away = cloud.points_xy - middle
    stretched = middle + np.outer(away @ normal, normal) + 2 * np.outer(away @ tangent, tangent)
    longer = line_covariance(Cloud(points_xy=stretched, weights=cloud.weights), line, SegmentSettings())
    assert longer[0, 0] < covariance[0, 0]


@settings(max_examples=20)
@given(SEEDS)
def test_points_are_shared_out_among_segments_and_the_rest(seed: int) -> None:
    rng = np.random.default_rng(seed)
    points = np.concatenate([room(seed), rng.uniform(-1, 4, size=(60, 2))])
    cloud, rules = Cloud(points_xy=points, weights=np.ones(len(points))), SegmentSettings()
    segments = find_segments(cloud, rules)
    members = np.concatenate([segment.members for segment in segments.found])
    assert len(np.unique(members)) == len(members)
    assert not np.isin(segments.rest, members).any()
    for segment in segments.found:
        assert np.abs(signed_distances(segment.line, points[segment.members])).max() <= rules.band + 1e-6
        assert len(segment.members) >= rules.min_weight


@given(SEEDS, st.floats(0.05, 0.5), st.floats(0.0, 6.2), st.floats(1.5, 5.0))
def test_points_on_a_rim_give_back_their_circle(seed: int, radius: float, start: float, arc: float) -> None:
    center = np.random.default_rng(seed).uniform(-10, 10, size=2)
    points = center + radius * directions(start + np.linspace(0.0, arc, 20))
    fitted = fit_taubin(Cloud(points_xy=points, weights=np.ones(20)))
    assert fitted is not None
    assert fitted == pytest.approx([*center, radius], abs=1e-6)


@given(SEEDS, st.floats(0.01, 0.3))
def test_pieces_cover_their_chain_and_keep_to_the_tolerance(seed: int, tolerance: float) -> None:
    points = np.cumsum(np.random.default_rng(seed).normal(0, 0.1, size=(40, 2)), axis=0)
    pieces = split_at_farthest(points, tolerance=tolerance)
    assert pieces[0][0] == 0
    assert pieces[-1][-1] == 39
    assert all(one[-1] == other[0] for one, other in pairwise(pieces))
    for piece in pieces:
        chord = points[piece[[0, -1]]][None]
        assert distances_to_segments(points[piece], chord).max() <= tolerance


@given(SEEDS, st.floats(0.02, 0.4))
def test_a_chain_is_parted_at_every_long_step_and_nowhere_else(seed: int, max_step: float) -> None:
    points = np.cumsum(np.random.default_rng(seed).normal(0, 0.1, size=(40, 2)), axis=0)
    pieces = split_at_steps(points, max_step=max_step)
    assert np.concatenate(pieces).tolist() == list(range(40))
    steps = np.hypot(*np.diff(points, axis=0).T)
    assert len(pieces) == 1 + np.count_nonzero(steps > max_step)


@given(SEEDS, SEEDS)
def test_an_update_is_surer_than_either_and_does_not_mind_the_order(seed: int, other: int) -> None:
    one, two = some_segment(seed), some_segment(other)
    both, same = update(one, two), update(two, one)
    np.testing.assert_allclose(both.line, same.line, atol=1e-8)
    np.testing.assert_allclose(both.covariance, same.covariance, atol=1e-10)
    for each in (one, two):
        assert np.linalg.eigvalsh(each.covariance - both.covariance).min() > -1e-12


@given(SEEDS)
def test_merged_lines_fit_no_other(seed: int) -> None:
    rules, tracks = KalmanSettings(), list[Track]()
    for number in range(12):
        measured = Track(segment=some_segment(100 * seed + number), sweeps=frozenset({number}))
        tracks = tracked(tracks, measured, rules)
    final = merged(tracks, rules)
    assert frozenset().union(*(track.sweeps for track in final)) == frozenset(range(12))
    for number, track in enumerate(final):
        assert (misfits([each.segment for each in final[:number]], track.segment, rules) > rules.gate).all()


@given(SEEDS)
def test_a_mixture_forgets_no_point(seed: int) -> None:
    points = np.random.default_rng(seed).uniform(-1, 1, size=(80, 2))
    rules = MixtureSettings(min_age=1000)
    mixture = Mixture.empty()
    for point in points:
        mixture = learn(mixture, point, rules)
    assert mixture.masses.sum() == pytest.approx(80)
    assert mixture.masses @ mixture.means_xy / 80 == pytest.approx(points.mean(axis=0), abs=0.05)
    assert (np.linalg.eigvalsh(mixture.covariances) > -1e-12).all()
    assert (mixture.ages <= 80).all()
    spread, weights = mixture.spread(spacing=0.05)
    assert weights.sum() == pytest.approx(80)
    assert weights @ spread == pytest.approx(mixture.masses @ mixture.means_xy)
