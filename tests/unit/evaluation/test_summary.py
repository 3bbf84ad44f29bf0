import numpy as np
import pytest

from echoplan.evaluation import BootstrapSettings, ErrorSummary, Evaluation, evaluate, pool
from echoplan.model import FeatureClass
from helpers import maps

FIRST = maps.drawn(
    maps.wall((1, 0.01), (3, 0.01)),
    maps.wall((5, 0.2), (5, 1.2)),
    maps.cylinder((3.5, 0.63), 0.08),
    maps.corner((5, 0.02)),
    poses=maps.ROOM.poses + np.array([0.03, 0.04, 0.1]),
)
SECOND = maps.drawn(
    maps.wall((1, 0.05), (3, 0.05)),
    maps.wall((1, 1), (2, 2)),
    maps.cylinder((3.5, 0.67), 0.11),
    poses=maps.ROOM.poses + np.array([0.0, 0.11, -0.3]),
)


def pooled(*evaluations: Evaluation) -> ErrorSummary:
    return pool(evaluations, rng=np.random.default_rng(0), settings=BootstrapSettings(resamples=200))


def test_counts_and_deviations_of_all_maps_come_together() -> None:
    summary = pooled(evaluate(FIRST, maps.ROOM), evaluate(SECOND, maps.ROOM))
    assert summary.recordings == 2
    walls = summary.classes[FeatureClass.WALL]
    assert (walls.tally.wanted, walls.tally.found, walls.tally.right, walls.tally.spurious) == (10, 3, 3, 1)
    assert walls.recall.value == pytest.approx(0.3)
    assert walls.precision.value == pytest.approx(0.75)
    assert walls.distance.count == 3
    assert walls.distance.mean.value == pytest.approx(0.02)
    assert walls.distance.maximum == pytest.approx(0.05)
    assert walls.consistency.nees == pytest.approx([1.0, 0.0, 25.0])
    assert summary.wall_angle.count == 3


def test_radii_are_pooled_without_their_sign() -> None:
    summary = pooled(evaluate(FIRST, maps.ROOM), evaluate(SECOND, maps.ROOM))
    assert summary.classes[FeatureClass.CYLINDER].distance.mean.value == pytest.approx(0.05)
    assert summary.cylinder_radius.mean.value == pytest.approx(0.015)


def test_poses_and_outlines_are_pooled_one_number_a_map() -> None:
    summary = pooled(evaluate(FIRST, maps.ROOM), evaluate(SECOND, maps.ROOM))
    assert summary.position.count == 2
    assert summary.position.mean.value == pytest.approx(0.08)
    assert summary.heading.mean.value == pytest.approx(0.2)
    assert summary.map_error.count == summary.hausdorff.count == 2
    assert summary.map_error.maximum < summary.hausdorff.mean.value


def test_lengths_and_wall_ends_are_pooled_over_all_walls() -> None:
    first, second = evaluate(FIRST, maps.ROOM).floor_plan, evaluate(SECOND, maps.ROOM).floor_plan
    plan = pooled(evaluate(FIRST, maps.ROOM), evaluate(SECOND, maps.ROOM)).floor_plan
    assert plan.lengths == first.lengths + second.lengths
    assert plan.lengths.precision == pytest.approx(5.0 / (5.0 + np.sqrt(2)), abs=0.02)
    assert len(plan.wall_ends.errors) == 6


def test_confusions_add_up() -> None:
    first, second = evaluate(FIRST, maps.ROOM), evaluate(SECOND, maps.ROOM)
    assert np.array_equal(pooled(first, second).confusion, first.confusion + second.confusion)


def test_maps_without_poses_or_outlines_are_left_out_of_those() -> None:
    summary = pooled(evaluate(FIRST, maps.ROOM), evaluate(maps.drawn(), maps.ROOM))
    assert summary.recordings == 2
    assert summary.position.count == summary.map_error.count == 1
    assert np.isnan(summary.position.mean.low)


def test_without_maps_pooled_errors_are_unknown() -> None:
    nothing = pooled()
    assert nothing.recordings == 0
    assert nothing.confusion.tolist() == [[0] * 4] * 4
    assert np.isnan(nothing.classes[FeatureClass.CORNER].recall.value)
    assert nothing.classes[FeatureClass.CYLINDER].consistency.parameters == 3
