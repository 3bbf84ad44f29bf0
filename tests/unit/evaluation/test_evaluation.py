from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from echoplan.evaluation import EvaluationSettings, MatchingSettings, OutlineSettings, evaluate, evaluation_document
from echoplan.io import read_map, read_truth, write_map, write_truth
from echoplan.model import FeatureClass, Truth
from helpers import maps

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


def test_every_feature_in_an_empty_truth_is_spurious() -> None:
    evaluation = evaluate(TRUE_MAP, maps.NOWHERE)
    assert evaluation.matches.walls.tally.precision == 0.0
    assert np.isnan(evaluation.matches.walls.tally.recall)
    assert np.isnan(evaluation.consistency[FeatureClass.WALL].mean)
    assert evaluation.confusion.sum(axis=1).tolist() == [0, 0, 0, 14]


def test_a_map_that_was_written_and_read_is_judged_alike(tmp_path: Path) -> None:
    found = maps.spoilt(maps.ROOM, np.random.default_rng(5))
    write_map(tmp_path / "map.json", found)
    write_truth(tmp_path / "truth.json", maps.ROOM)
    read = evaluate(read_map(tmp_path / "map.json"), read_truth(tmp_path / "truth.json"))
    assert evaluation_document(read) == evaluation_document(evaluate(found, maps.ROOM))


def test_a_true_wall_of_no_length_is_ignored() -> None:
    point = np.array([[[2.5, 0.0], [2.5, 0.0]]])
    truth = replace(
        maps.ROOM,
        walls_xy=np.concatenate([maps.ROOM.walls_xy, point]),
        walls_detected_by=np.append(maps.ROOM.walls_detected_by, 0),
    )
    with_point, without = evaluate(TRUE_MAP, truth), evaluate(TRUE_MAP, maps.ROOM)
    assert with_point.matches.walls.tally == without.matches.walls.tally
    assert np.array_equal(with_point.confusion, without.confusion)


def test_an_evaluation_is_the_same_every_time() -> None:
    found = maps.spoilt(maps.ROOM, np.random.default_rng(6))
    first, second = evaluate(found, maps.ROOM), evaluate(found, maps.ROOM)
    assert evaluation_document(first) == evaluation_document(second)


def test_unknown_settings_are_refused_at_any_depth() -> None:
    with pytest.raises(ValidationError, match="spacign"):
        EvaluationSettings.model_validate({"outlines": {"spacign": 0.02}})
