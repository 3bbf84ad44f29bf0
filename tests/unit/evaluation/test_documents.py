import json
from typing import Any

import numpy as np
import pytest

from echoplan.evaluation import BootstrapSettings, evaluate, evaluation_document, pool, summary_document
from echoplan.model import FeatureMap
from helpers import maps

FOUND = maps.drawn(
    maps.wall((1, 0.01), (3, 0.03)),
    maps.cylinder((3.53, 0.56), 0.08),
    maps.corner((5, 0.1)),
    poses=maps.ROOM.poses + np.array([0.03, 0.04, np.radians(2)]),
)


def document(feature_map: FeatureMap) -> Any:
    """As it comes back from a file: nothing in it may be beyond strict JSON."""
    return json.loads(json.dumps(evaluation_document(evaluate(feature_map, maps.ROOM)), allow_nan=False))


def summary(*found: FeatureMap) -> Any:
    evaluations = [evaluate(each, maps.ROOM) for each in found]
    pooled = pool(evaluations, rng=np.random.default_rng(0), settings=BootstrapSettings(resamples=50))
    return json.loads(json.dumps(summary_document(pooled), allow_nan=False))


def test_a_map_is_reported_in_millimetres_and_degrees() -> None:
    written = document(FOUND)
    assert written["method"] == "by hand"
    walls = written["walls"]
    assert {name: walls[name] for name in ("wanted", "found", "right", "duplicate", "spurious")} == {
        "wanted": 5,
        "found": 1,
        "right": 1,
        "duplicate": 0,
        "spurious": 0,
    }
    assert (walls["recall"], walls["precision"]) == (0.2, 1.0)
    assert walls["deviations"][0] == {
        "index": 1,
        "detected_by": 9,
        "estimate": 0,
        "distance_mm": pytest.approx(20.0),
        "angle_deg": pytest.approx(np.degrees(np.arctan(0.01))),
    }
    assert written["cylinders"]["deviations"][0]["distance_mm"] == pytest.approx(50.0)
    assert written["cylinders"]["deviations"][0]["radius_mm"] == pytest.approx(-20.0)
    assert written["corners"]["deviations"][4]["distance_mm"] == pytest.approx(100.0)
    assert written["confusion"]["wall"] == {"wall": 1, "corner": 0, "cylinder": 0, "missed": 4}
    assert written["map_error"]["map_to_truth_mm"] < written["map_error"]["truth_to_map_mm"]
    assert written["lengths"] == {
        "drawn_m": pytest.approx(2.0, abs=1e-3),
        "correct_m": pytest.approx(2.0, abs=1e-3),
        "wanted_m": pytest.approx(13.0),
        "covered_m": pytest.approx(2.09, abs=0.02),
        "recall": pytest.approx(2.09 / 13, abs=0.001),
        "precision": 1.0,
        "walked_through": 0,
    }
    assert (written["openings"]["wanted"], written["openings"]["recall"], written["openings"]["width"]["count"]) == (
        0,
        None,
        0,
    )
    assert written["wall_ends"] == {
        "count": 2,
        "mean_mm": pytest.approx(1500.0, rel=1e-3),
        "bias_mm": pytest.approx(-1500.0, rel=1e-3),
        "share_inside": None,
    }
    errors = {"ate_mm": pytest.approx(50.0), "heading_deg": pytest.approx(2.0)}
    assert {name: written["poses"][name] for name in ("count", *errors)} == {"count": 2, **errors}
    assert written["poses"]["positions"]["count"] == 0


def test_what_the_map_lacks_is_null_under_the_same_keys() -> None:
    written = document(FOUND)
    for name in ("walls", "corners", "cylinders"):
        first, *others = written[name]["deviations"]
        assert all(other.keys() == first.keys() for other in others)
    assert written["walls"]["deviations"][5] == {
        "index": 6,
        "detected_by": 1,
        "estimate": None,
        "distance_mm": None,
        "angle_deg": None,
    }


def test_an_empty_map_has_the_same_keys_and_nulls() -> None:
    written, full = document(maps.drawn()), document(FOUND)
    assert written.keys() == full.keys()
    assert written["walls"].keys() == full["walls"].keys()
    assert written["walls"]["precision"] is None
    assert set(written["map_error"].values()) == {None}
    assert written["poses"] is None


def test_a_summary_is_reported_with_intervals() -> None:
    written = summary(FOUND, maps.drawn(maps.wall((1, 0.04), (3, 0.04))))
    assert written["recordings"] == 2
    assert written["walls"]["recall"]["value"] == pytest.approx(0.2)
    assert written["walls"]["distance_mm"]["mean"] == {
        "value": pytest.approx(30.0),
        "low": pytest.approx(20.0),
        "high": pytest.approx(40.0),
    }
    assert written["walls"]["distance_mm"]["max"] == pytest.approx(40.0)
    assert written["walls"]["angle_deg"]["max"] == pytest.approx(np.degrees(np.arctan(0.01)))
    assert written["cylinders"]["radius_mm"]["mean"]["value"] == pytest.approx(20.0)
    assert written["lengths"]["drawn_m"] == pytest.approx(4.0, abs=1e-3)
    assert written["wall_ends"]["count"] == 4
    assert written["ate_mm"]["mean"]["value"] == pytest.approx(50.0)
    assert written["heading_deg"]["mean"]["value"] == pytest.approx(2.0)
    # Sigmas of 0.01 rad and 1 cm: one wall goes through the origin, turned by 0.01 rad; the other is 4 cm off.
    assert written["walls"]["consistency"]["mean_nees"] == pytest.approx((1 + 16) / 2, rel=1e-4)


def test_a_summary_of_nothing_has_the_same_keys() -> None:
    def keys(written: Any) -> Any:
        return {name: keys(value) for name, value in written.items()} if isinstance(written, dict) else None

    assert keys(summary()) == keys(summary(FOUND, FOUND))
