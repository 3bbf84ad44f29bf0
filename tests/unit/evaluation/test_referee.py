"""The evaluation against an independent scorer, number by number, on maps spoilt in every way."""

import importlib.util
import json
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from echoplan.evaluation import (
    BootstrapSettings,
    ErrorSummary,
    Evaluation,
    EvaluationSettings,
    MatchingSettings,
    evaluate,
    pool,
)
from echoplan.model import FeatureClass, FeatureMap, Truth
from helpers import maps

SHARED = Path(__file__).parents[3] / ".." / "shared"
SCORER = SHARED / "tools" / "score.py"
TRUTHS = sorted([*SHARED.glob("data/rooms/*/truth.json"), *SHARED.glob("data/arena-*/truth.json")])
SEEDS = range(4)
# The scorer samples walls every 2 cm and counts both ends; lengths are compared with samples that are this dense [m].
SPACING = 0.001

pytestmark = pytest.mark.skipif(not SCORER.exists() or not TRUTHS, reason="the scorer and its rooms are not here")


@cache
def scorer() -> Any:
    spec = importlib.util.spec_from_file_location("score", SCORER)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def truth_of(document: dict[str, Any]) -> Truth:
    return Truth(
        walls_xy=np.reshape(document["walls"], (-1, 2, 2)),
        walls_detected_by=document["walls_heard"],
        cylinders=np.reshape(document["cylinders"], (-1, 3)),
        cylinders_detected_by=np.array(document["cylinders_heard"], dtype=np.int64),
        poses=np.array(document["poses"]),
        given=np.array(document["given"]),
    )


def map_document(feature_map: FeatureMap) -> dict[str, Any]:
    return {
        "walls": [{"start": wall.endpoints_xy[0], "end": wall.endpoints_xy[1]} for wall in feature_map.walls],
        "corners": [{"position": corner.position_xy} for corner in feature_map.corners],
        "cylinders": [{"center": each.center_xy, "radius": each.radius} for each in feature_map.cylinders],
        "poses": [{"x": x, "y": y, "yaw": yaw} for x, y, yaw in feature_map.poses],
    }


def scores_of(evaluation: Evaluation) -> dict[str, Any]:
    """An evaluation in the scorer's words."""
    matches = evaluation.matches
    walls, corners, cylinders = (matching.tally for matching in matches.by_class.values())
    assert evaluation.trajectory is not None
    return {
        "walls_want": walls.wanted,
        "walls_tp": walls.found,
        "walls_fp": walls.spurious,
        "walls_dup": walls.duplicate,
        "wall_dist": [match.distance for match in matches.walls.right],
        "wall_ang": [np.degrees(match.angle) for match in matches.walls.right],
        "cyl_want": cylinders.wanted,
        "cyl_tp": cylinders.found,
        "cyl_fp": cylinders.spurious + cylinders.duplicate,
        "cyl_pos": [match.distance for match in matches.cylinders.right],
        "cyl_rad": [abs(match.radius_error) for match in matches.cylinders.right],
        "cor_want": corners.wanted,
        "cor_tp": corners.found,
        "cor_fp": corners.spurious,
        "cor_pos": [match.distance for match in matches.corners.right],
        "ate": evaluation.trajectory.absolute_error,
        "yaw": np.degrees(evaluation.trajectory.heading_error),
        "walked_through": evaluation.floor_plan.lengths.walked_through,
    }


def scored_lengths(document: dict[str, Any], feature_map: FeatureMap, min_stations: int) -> tuple[float, float]:
    """Recall and precision of the wall length by the scorer, densely sampled."""
    true = np.array(document["walls"], dtype=float)
    drawn = scorer().walls_of(map_document(feature_map))
    wanted = true[np.array(document["walls_heard"]) >= min_stations]
    pairs = ((wanted, drawn), (drawn, true))
    recall, precision = (
        float(scorer().near(scorer().samples(walls, SPACING), others).mean()) if len(walls) else np.nan
        for walls, others in pairs
    )
    return recall, precision


def totals_of(summary: ErrorSummary) -> dict[str, float]:
    """A summary in the scorer's words."""
    walls, corners, cylinders = (summary.classes[name] for name in FeatureClass)
    return {
        "wall_recall": walls.recall.value,
        "wall_precision": walls.precision.value,
        "wall_mm_mean": 1000 * walls.distance.mean.value,
        "wall_mm_p95": 1000 * walls.distance.percentile95.value,
        "wall_mm_max": 1000 * walls.distance.maximum,
        "wall_deg_mean": np.degrees(summary.wall_angle.mean.value),
        "wall_deg_p95": np.degrees(summary.wall_angle.percentile95.value),
        "wall_deg_max": np.degrees(summary.wall_angle.maximum),
        "cyl_recall": cylinders.recall.value,
        "cyl_precision": cylinders.precision.value,
        "cyl_mm_mean": 1000 * cylinders.distance.mean.value,
        "cyl_radius_mm_mean": 1000 * summary.cylinder_radius.mean.value,
        "corner_recall": corners.recall.value,
        "corner_precision": corners.precision.value,
        "corner_mm_mean": 1000 * corners.distance.mean.value,
        "ate_mm": 1000 * summary.position.mean.value,
        "yaw_deg": np.degrees(summary.heading.mean.value),
        "walked_through": summary.floor_plan.lengths.walked_through,
    }


@pytest.mark.parametrize("min_stations", [1, 2, 4])
@pytest.mark.parametrize("path", TRUTHS, ids=lambda path: path.parent.name)
def test_every_number_of_a_map_is_that_of_the_scorer(path: Path, min_stations: int) -> None:
    settings = EvaluationSettings(matching=MatchingSettings(min_stations=min_stations))
    document = json.loads(path.read_text(encoding="utf-8"))
    truth = truth_of(document)
    for seed in SEEDS:
        feature_map = maps.spoilt(truth, np.random.default_rng(seed))
        expected = scorer().score_case(document, map_document(feature_map), min_stations)
        evaluation = evaluate(feature_map, truth, settings)
        found, lengths = scores_of(evaluation), evaluation.floor_plan.lengths
        assert found.keys() == expected.keys() - {"len_drawn", "len_right", "len_true", "len_found"}
        assert (lengths.recall, lengths.precision) == pytest.approx(
            scored_lengths(document, feature_map, min_stations), abs=0.003, nan_ok=True
        )
        expected = {name: expected[name] for name in found}
        for name, value in expected.items():
            assert found[name] == pytest.approx(value, rel=1e-9, abs=1e-12), name


def test_every_total_over_all_rooms_is_that_of_the_scorer() -> None:
    expected, evaluations = [], []
    for path in TRUTHS:
        document = json.loads(path.read_text(encoding="utf-8"))
        truth = truth_of(document)
        for seed in SEEDS:
            feature_map = maps.spoilt(truth, np.random.default_rng(seed))
            expected.append(scorer().score_case(document, map_document(feature_map)))
            evaluations.append(evaluate(feature_map, truth))
    summary = pool(evaluations, rng=np.random.default_rng(0), settings=BootstrapSettings(resamples=10))
    total, lengths = scorer().total(expected), summary.floor_plan.lengths
    shares = total.pop("length_recall"), total.pop("length_precision")
    assert (lengths.recall, lengths.precision) == pytest.approx(shares, abs=0.005)
    assert totals_of(summary) == pytest.approx(total, rel=1e-9)
    # The spoiling must reach every rule, or the agreement says little.
    for of_class in summary.classes.values():
        assert 0.1 < of_class.recall.value < 0.9
        assert 0.1 < of_class.precision.value < 0.9
