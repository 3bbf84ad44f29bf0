from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from echoplan.arrays import FloatArray
from echoplan.evaluation import BootstrapSettings, Evaluation, MatchingSettings, evaluate, match_map, pool
from echoplan.evaluation.bootstrap import describe
from echoplan.evaluation.consistency import nees
from echoplan.geometry import compose, transform_points
from echoplan.model import FeatureClass, FeatureMap, Truth, Wall
from helpers import maps

errors = st.floats(0, 10)
few = settings(max_examples=25)
spoilt_maps = st.integers(0, 10**6).map(lambda seed: maps.spoilt(maps.ROOM, np.random.default_rng(seed)))
# Whole metres and quarter turns keep the vertices, which are rounded to 0.1 mm, where they are.
moves = st.builds(
    lambda x, y, turns: np.array([x, y, turns * np.pi / 2]), st.integers(-9, 9), st.integers(-9, 9), st.integers(-2, 2)
)


def flipped(wall: Wall) -> Wall:
    """The same wall from its other end and by its other normal."""
    sign = np.diag([1.0, -1.0])
    return replace(
        wall,
        normal_angle=wall.normal_angle + np.pi,
        offset=-wall.offset,
        endpoints_xy=wall.endpoints_xy[::-1],
        covariance=sign @ wall.covariance @ sign,
    )


def moved_map(pose: FloatArray, found: FeatureMap) -> FeatureMap:
    return maps.drawn(
        *(maps.wall(*transform_points(pose, wall.endpoints_xy)) for wall in found.walls),
        *(replace(corner, position_xy=transform_points(pose, corner.position_xy)) for corner in found.corners),
        *(replace(each, center_xy=transform_points(pose, each.center_xy)) for each in found.cylinders),
        poses=compose(pose, found.poses),
    )


def moved_truth(pose: FloatArray, truth: Truth) -> Truth:
    centers = transform_points(pose, truth.cylinders[:, :2])
    return replace(
        truth,
        walls_xy=transform_points(pose, truth.walls_xy),
        cylinders=np.column_stack([centers, truth.cylinders[:, 2]]),
        poses=compose(pose, truth.poses),
        given=compose(pose, truth.given),
    )


def counts(evaluation: Evaluation) -> list[Any]:
    """Whole numbers of an evaluation, but for those of vertices, which depend on the frame."""
    walls = [(match.truth, match.estimate) for match in evaluation.matches.walls.right]
    tallies = [matching.tally for matching in evaluation.matches.by_class.values()]
    return [walls, tallies, evaluation.confusion.tolist()]


def sizes(evaluation: Evaluation) -> list[float]:
    """Distances and angles of an evaluation, but for those of outlines, which depend on where samples fall."""
    assert evaluation.trajectory is not None
    return [
        *(match.distance for matching in evaluation.matches.by_class.values() for match in matching.right),
        *(match.angle for match in evaluation.matches.walls.right),
        evaluation.trajectory.absolute_error,
        evaluation.trajectory.heading_error,
    ]


@few
@given(spoilt_maps, moves)
def test_a_map_and_its_truth_can_be_moved_together(found: FeatureMap, pose: FloatArray) -> None:
    moved = evaluate(moved_map(pose, found), moved_truth(pose, maps.ROOM))
    evaluation = evaluate(found, maps.ROOM)
    assert counts(moved) == counts(evaluation)
    assert sizes(moved) == pytest.approx(sizes(evaluation), abs=1e-9)
    assert moved.map_error.mean == pytest.approx(evaluation.map_error.mean, abs=1e-3)
    assert moved.map_error.hausdorff == pytest.approx(evaluation.map_error.hausdorff, abs=1e-2)


@few
@given(spoilt_maps)
def test_a_wall_is_the_same_from_either_end_and_by_either_normal(found: FeatureMap) -> None:
    same = evaluate(replace(found, walls=tuple(map(flipped, found.walls))), maps.ROOM)
    evaluation = evaluate(found, maps.ROOM)
    assert counts(same) == counts(evaluation)
    assert sizes(same) == pytest.approx(sizes(evaluation), abs=1e-9)
    wall = FeatureClass.WALL
    assert same.consistency[wall].nees == pytest.approx(evaluation.consistency[wall].nees, rel=1e-6, abs=1e-9)


@few
@given(spoilt_maps)
def test_the_order_of_walls_and_corners_does_not_matter(found: FeatureMap) -> None:
    turned = evaluate(replace(found, walls=found.walls[::-1], corners=found.corners[::-1]), maps.ROOM)
    evaluation = evaluate(found, maps.ROOM)
    for name in (FeatureClass.WALL, FeatureClass.CORNER):
        first, second = (each.matches.by_class[name] for each in (evaluation, turned))
        assert first.tally == second.tally
        assert sorted(match.distance for match in first.right) == sorted(match.distance for match in second.right)
    assert np.array_equal(turned.confusion, evaluation.confusion)


@few
@given(spoilt_maps)
def test_a_false_feature_lowers_precision_but_not_recall(found: FeatureMap) -> None:
    ghosts = maps.drawn(maps.wall((90, 90), (91, 95)), maps.corner((90, 90)), maps.cylinder((90, 90), 0.1))
    haunted = replace(
        found,
        walls=found.walls + ghosts.walls,
        corners=ghosts.corners + found.corners,
        cylinders=ghosts.cylinders + found.cylinders,
    )
    before, after = (evaluate(each, maps.ROOM).matches.by_class for each in (found, haunted))
    for name in FeatureClass:
        assert after[name].tally == before[name].tally + evaluate(ghosts, maps.NOWHERE).matches.by_class[name].tally


@few
@given(spoilt_maps)
def test_every_estimate_has_one_place_in_the_confusion_and_nothing_found_is_missed(found: FeatureMap) -> None:
    evaluation = evaluate(found, maps.ROOM)
    tallies = [matching.tally for matching in evaluation.matches.by_class.values()]
    assert evaluation.confusion[:, :3].sum(axis=0).tolist() == [tally.estimates for tally in tallies]
    for row, tally in zip(evaluation.confusion, tallies, strict=False):
        assert row[3] <= tally.wanted - tally.found
    right = [tally.right + tally.duplicate for tally in tallies]
    assert np.diag(evaluation.confusion)[:3].tolist() == right


@few
@given(spoilt_maps)
def test_the_distance_between_outlines_is_the_same_from_either_side(found: FeatureMap) -> None:
    # A truth that is detected everywhere, against the map; and that map as the truth, against that truth as a map.
    everywhere = replace(maps.ROOM, walls_detected_by=np.full(6, 9), cylinders_detected_by=np.full(2, 9))
    true_map = maps.drawn(
        *(maps.wall(*ends) for ends in maps.ROOM.walls_xy),
        *(maps.cylinder(circle[:2], circle[2]) for circle in maps.ROOM.cylinders),
    )
    found_truth = Truth(
        walls_xy=np.array([wall.endpoints_xy for wall in found.walls]),
        walls_detected_by=np.full(len(found.walls), 9),
        cylinders=np.reshape([[*each.center_xy, each.radius] for each in found.cylinders], (-1, 3)),
        cylinders_detected_by=np.full(len(found.cylinders), 9),
    )
    there, back = evaluate(found, everywhere).map_error, evaluate(true_map, found_truth).map_error
    assert there.map_to_truth == back.truth_to_map
    assert there.truth_to_map == back.map_to_truth
    assert there.mean == back.mean


@few
@given(spoilt_maps, st.integers(2, 4))
def test_a_map_pooled_with_itself_has_the_same_scores(found: FeatureMap, times: int) -> None:
    evaluation, bootstrap = evaluate(found, maps.ROOM), BootstrapSettings(resamples=20)
    alone = pool([evaluation], rng=np.random.default_rng(0), settings=bootstrap)
    again = pool([evaluation] * times, rng=np.random.default_rng(0), settings=bootstrap)
    for name in FeatureClass:
        first, second = alone.classes[name], again.classes[name]
        assert second.tally.wanted == times * first.tally.wanted
        assert second.recall.value == pytest.approx(first.recall.value)
        assert second.distance.mean.value == pytest.approx(first.distance.mean.value, nan_ok=True)
        # Recordings that do not differ leave nothing to be unsure of.
        assert second.recall.low == second.recall.high == pytest.approx(second.recall.value)


@given(st.lists(st.lists(errors, max_size=8), min_size=1, max_size=6))
def test_pooled_statistics_are_those_of_numpy(samples: list[list[float]]) -> None:
    pooled = np.concatenate([np.zeros(0), *samples])
    found = describe(samples, rng=np.random.default_rng(0), settings=BootstrapSettings(resamples=10))
    assert found.count == len(pooled)
    if len(pooled):
        assert found.mean.value == pytest.approx(pooled.mean())
        assert found.median.value == pytest.approx(np.median(pooled))
        assert found.percentile95.value == pytest.approx(np.percentile(pooled, 95))
        assert found.rms.value == pytest.approx(np.sqrt(np.mean(pooled**2)))
        assert found.maximum == pooled.max()


@given(st.lists(st.lists(errors, min_size=1, max_size=8), min_size=2, max_size=6), st.floats(0.01, 1000))
def test_statistics_and_intervals_change_with_the_unit(samples: list[list[float]], unit: float) -> None:
    bootstrap = BootstrapSettings(resamples=40)
    scaled = [[unit * error for error in sample] for sample in samples]
    plain = describe(samples, rng=np.random.default_rng(0), settings=bootstrap)
    other = describe(scaled, rng=np.random.default_rng(0), settings=bootstrap)
    for name in ("mean", "median", "percentile95", "rms"):
        first, second = getattr(plain, name), getattr(other, name)
        assert [second.value, second.low, second.high] == pytest.approx(
            [unit * first.value, unit * first.low, unit * first.high], abs=1e-9
        )


@given(st.lists(st.lists(errors, min_size=1, max_size=8), min_size=2, max_size=6))
def test_intervals_lie_between_the_least_and_the_greatest(samples: list[list[float]]) -> None:
    pooled = np.concatenate(samples)
    found = describe(samples, rng=np.random.default_rng(0), settings=BootstrapSettings(resamples=40))
    for interval in (found.mean, found.median, found.percentile95):
        assert pooled.min() - 1e-9 <= interval.low <= interval.high <= pooled.max() + 1e-9


@given(
    arrays(np.float64, 2, elements=st.floats(-1, 1)),
    arrays(np.float64, (2, 2), elements=st.floats(-1, 1)),
    arrays(np.float64, (2, 2), elements=st.floats(-1, 1)),
)
def test_nees_does_not_depend_on_the_coordinates(error: FloatArray, root: FloatArray, change: FloatArray) -> None:
    covariance = root @ root.T + 0.1 * np.eye(2)
    basis = change + 3 * np.eye(2)
    assert nees(basis @ error, basis @ covariance @ basis.T) == pytest.approx(nees(error, covariance), abs=1e-9)
    assert nees(2 * error, 4 * covariance) == pytest.approx(nees(error, covariance), abs=1e-9)


@few
@given(spoilt_maps, st.floats(0.05, 0.3), st.floats(0.05, 0.3))
def test_a_wider_gate_never_finds_less(found: FeatureMap, first: float, second: float) -> None:
    narrow, wide = sorted((first, second))
    tallies = [
        match_map(
            found, maps.ROOM, MatchingSettings(wall_distance=gate, cylinder_distance=gate, corner_distance=gate)
        ).by_class
        for gate in (narrow, wide)
    ]
    for name in FeatureClass:
        before, after = (each[name].tally for each in tallies)
        assert before.found <= after.found
        assert before.spurious >= after.spurious
        assert before.estimates == after.estimates
