import numpy as np
import pytest

import maps
from echoplan.evaluation import EvaluationSettings, MatchingSettings, OutlineSettings, evaluate
from echoplan.model import FeatureClass, Truth

TRUE_MAP = maps.drawn(
    *(maps.wall(*ends) for ends in maps.ROOM.walls_xy),
    *(maps.corner(xy) for xy in maps.ROOM.walls_xy[:, 0]),
    *(maps.cylinder(circle[:2], circle[2]) for circle in maps.ROOM.cylinders),
    poses=maps.ROOM.poses,
)


def test_the_true_map_is_right_in_everything() -> None:
    evaluation = evaluate(TRUE_MAP, maps.ROOM)
    assert evaluation.method == "by hand"
    for name, matching in evaluation.matches.by_class.items():
        assert matching.tally.recall == matching.tally.precision == 1.0
        assert [match.distance for match in matching.right] == pytest.approx([0] * matching.tally.right, abs=1e-9)
        assert evaluation.consistency[name].share_inside == 1.0
    assert evaluation.confusion.tolist() == [[6, 0, 0, 0], [0, 6, 0, 0], [0, 0, 2, 0], [0, 0, 0, 0]]
    assert evaluation.map_error.hausdorff == pytest.approx(0.0, abs=1e-9)
    assert evaluation.trajectory is not None
    assert evaluation.trajectory.absolute_error == 0.0


def test_settings_reach_the_stage_that_they_belong_to() -> None:
    found = maps.drawn(maps.wall((1, 0.05), (3, 0.05)), maps.corner((3.0, -0.05)))
    strict = EvaluationSettings(matching=MatchingSettings(wall_distance=0.04), outlines=OutlineSettings(spacing=3.0))
    assert evaluate(found, maps.ROOM).matches.walls.tally.right == 1
    evaluation = evaluate(found, maps.ROOM, strict)
    assert evaluation.matches.walls.spurious == (0,)
    assert evaluation.confusion[3].tolist() == [1, 1, 0, 0]
    # One sample in the middle of the wall of 2 m.
    assert evaluation.map_error.map_to_truth.maximum == pytest.approx(0.05)


@pytest.mark.parametrize("truth", [maps.ROOM, maps.NOWHERE])
def test_an_empty_map_is_evaluated_like_any_other(truth: Truth) -> None:
    evaluation = evaluate(maps.drawn(), truth)
    assert all(np.isnan(matching.tally.precision) for matching in evaluation.matches.by_class.values())
    assert np.isnan(evaluation.map_error.mean)
    assert evaluation.trajectory is None


def test_a_map_of_nowhere_is_spurious_all_over() -> None:
    evaluation = evaluate(TRUE_MAP, maps.NOWHERE)
    assert evaluation.matches.walls.tally.precision == 0.0
    assert np.isnan(evaluation.matches.walls.tally.recall)
    assert np.isnan(evaluation.consistency[FeatureClass.WALL].mean)
    assert evaluation.confusion.sum(axis=1).tolist() == [0, 0, 0, 14]
