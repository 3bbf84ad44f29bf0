"""Maps are read from what programs write, ours and others."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InputError, InvalidValueError
from echoplan.io import read_map, read_truth, write_map
from echoplan.model import ClassProbabilities, CornerKind, FeatureMap, Quality, Verdict

WALL = {
    "start": [0.0, 0.0],
    "end": [4.0, 0.0],
    "normal_angle": -1.5708,
    "offset": 0.0,
    "covariance": [[1e-6, 0], [0, 1e-6]],
}
OPENING = {"start": [1.0, 0.0], "end": [1.9, 0.0], "width_sigma": 0.02, "walls": [0], "passed": True}
STRETCH = {"start": [3.0, 0.0], "end": [3.5, 0.0], "walls": [0]}
MAP = {
    "format": "echoplan-map/1",
    "method": "by hand",
    "walls": [WALL],
    "corners": [{"position": [4.0, 0.0], "kind": "convex", "covariance": [[1e-6, 0], [0, 1e-6]]}],
    "cylinders": [{"center": [3.2, 1.0], "radius": 0.1, "covariance": [[1e-6, 0, 0], [0, 1e-6, 0], [0, 0, 1e-6]]}],
    "poses": [{"sweep": 5, "x": 0.1, "y": 0.2, "yaw": 0.3}],
}


def read(tmp_path: Path, **changes: Any) -> FeatureMap:
    path = tmp_path / "map.json"
    path.write_text(json.dumps(MAP | changes))
    return read_map(path)


def test_what_another_program_leaves_out_is_taken_as_certain_and_undetected(tmp_path: Path) -> None:
    found = read(tmp_path)
    assert found.walls[0].endpoints_xy.tolist() == [[0.0, 0.0], [4.0, 0.0]]
    assert (found.walls[0].pings, found.walls[0].stations) == (0, 0)
    assert found.walls[0].class_probabilities == ClassProbabilities(wall=1.0)
    assert found.corners[0].class_probabilities == ClassProbabilities(corner=1.0)
    assert found.cylinders[0].class_probabilities == ClassProbabilities(cylinder=1.0)
    assert found.corners[0].kind is CornerKind.CONVEX
    assert (found.frame, found.parameters) == ("map", {})
    assert (found.sweeps.tolist(), found.poses.tolist()) == ([5], [[0.1, 0.2, 0.3]])


def test_what_another_program_adds_is_passed_over(tmp_path: Path) -> None:
    wall = WALL | {"id": "north", "colour": "red", "class_probabilities": {"wall": 0.75, "corner": 0.25, "door": 0.0}}
    found = read(tmp_path, walls=[wall], license="CC0")
    assert found.walls[0].class_probabilities == ClassProbabilities(wall=0.75, corner=0.25)


def test_features_are_numbered_as_they_stand(tmp_path: Path) -> None:
    write_map(tmp_path / "new.json", read(tmp_path, walls=[WALL, WALL | {"pings": 7, "stations": 2}]))
    written = json.loads((tmp_path / "new.json").read_text())
    assert [(wall["id"], wall["pings"], wall["stations"]) for wall in written["walls"]] == [(0, 0, 0), (1, 7, 2)]
    assert written["format"] == "echoplan-map/1"


def test_a_map_never_holds_nan(tmp_path: Path) -> None:
    with pytest.raises(InvalidValueError, match="there is no JSON for this value"):
        write_map(tmp_path / "map.json", FeatureMap(method="rcd", parameters={"limit": float("nan")}))
    assert not list(tmp_path.iterdir())


def test_a_pose_may_come_with_its_covariance(tmp_path: Path) -> None:
    covariance = [[1e-6, 0.0, 0.0], [0.0, 4e-6, 1e-7], [0.0, 1e-7, 1e-5]]
    found = read(tmp_path, poses=[MAP["poses"][0] | {"covariance": covariance}])  # type: ignore[operator]
    assert found.pose_covariances.tolist() == [covariance]
    write_map(tmp_path / "again.json", found)
    assert json.loads((tmp_path / "again.json").read_text())["poses"][0]["covariance"] == covariance


def test_poses_without_covariances_are_written_without(tmp_path: Path) -> None:
    write_map(tmp_path / "again.json", read(tmp_path))
    assert "covariance" not in json.loads((tmp_path / "again.json").read_text())["poses"][0]


def test_openings_and_unobserved_stretches_are_read_and_written_with_their_numbers(tmp_path: Path) -> None:
    found = read(tmp_path, openings=[OPENING], unobserved=[STRETCH, STRETCH])
    (opening,) = found.openings
    assert opening.endpoints_xy.tolist() == [[1.0, 0.0], [1.9, 0.0]]
    assert (opening.width_sigma, opening.walls, opening.passed) == (0.02, (0,), True)
    assert [each.walls for each in found.unobserved] == [(0,), (0,)]
    write_map(tmp_path / "again.json", found)
    written = json.loads((tmp_path / "again.json").read_text())
    assert written["openings"] == [{"id": 0} | OPENING]
    assert written["unobserved"] == [{"id": 0} | STRETCH, {"id": 1} | STRETCH]


def test_what_is_known_of_the_ends_of_a_wall_is_read_and_written(tmp_path: Path) -> None:
    found = read(tmp_path, walls=[WALL | {"endpoint_sigmas": [0.01, None], "inferred": [0.0, 0.4]}, WALL])
    np.testing.assert_array_equal(found.walls[0].endpoint_sigmas, [0.01, np.nan])
    np.testing.assert_array_equal(found.walls[1].endpoint_sigmas, [np.nan, np.nan])
    assert [each.inferred.tolist() for each in found.walls] == [[0.0, 0.4], [0.0, 0.0]]
    write_map(tmp_path / "again.json", found)
    ends, bare = json.loads((tmp_path / "again.json").read_text())["walls"]
    assert (ends["endpoint_sigmas"], ends["inferred"]) == ([0.01, None], [0.0, 0.4])
    assert {"endpoint_sigmas", "inferred"}.isdisjoint(bare)


def test_the_walls_beside_an_opening_and_whether_it_was_passed_may_be_left_out(tmp_path: Path) -> None:
    (opening,) = read(tmp_path, openings=[{"start": [1.0, 0.0], "end": [1.9, 0.0], "width_sigma": 0.0}]).openings
    assert (opening.walls, opening.passed) == ((), False)


def test_a_wall_at_fault_is_reported_before_the_openings_beside_it(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"walls\[0\]\.pings"):
        read(tmp_path, walls=[WALL | {"pings": -1}], openings=[OPENING | {"walls": [7]}])


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"format": "echoplan-map/2"}, r"map\.json, format: must be 'echoplan-map/1', not 'echoplan-map/2'"),
        (
            {"walls": [WALL | {"end": [1.0]}]},
            r"walls\[0\]\.end: must have at least 2 items, not 1; end: Second end",
        ),
        ({"walls": [WALL | {"end": [0.0, 0.0]}]}, r"walls\[0\]: the ends of a wall must differ"),
        ({"walls": [WALL | {"covariance": [[1, 2], [2, 1]]}]}, r"walls\[0\]: covariance must have no negative eigenv"),
        ({"walls": [WALL | {"class_probabilities": {"wall": 0.5}}]}, r"walls\[0\].*must sum to 1, not 0\.5"),
        ({"walls": [WALL | {"pings": -1}]}, r"walls\[0\]\.pings: must be greater than or equal to 0, not -1"),
        ({"corners": [{"position": [0.0, 0.0]}]}, r"corners\[0\]\.kind: the key 'kind' is missing"),
        (
            {"walls": [WALL | {"endpoint_sigmas": [0.01]}]},
            r"walls\[0\]\.endpoint_sigmas: must have at least 2 items, not 1; endpoint_sigmas: Standard dev",
        ),
        (
            {"walls": [WALL | {"inferred": [0.0, -0.5]}]},
            r"inferred\[1\]: must be greater than or equal to 0, not -0\.5",
        ),
        (
            {"openings": [OPENING, OPENING | {"walls": [0, 7]}]},
            r"map\.json, openings: entry 1 refers to wall 7, but the number of walls is 1; use their places",
        ),
        ({"unobserved": [STRETCH | {"walls": [1]}]}, r"map\.json, unobserved: entry 0 refers to wall 1, but"),
        ({"openings": [OPENING | {"walls": [-1]}]}, r"openings\[0\]\.walls\[0\]: must be greater than or equal to 0"),
        (
            {"openings": [OPENING | {"width_sigma": -0.01}]},
            r"openings\[0\]\.width_sigma: must be greater than or equal to 0, not -0\.01; width_sigma: Standard",
        ),
        ({"openings": [OPENING | {"end": [1.0, 0.0]}]}, r"openings\[0\]: the ends of an opening must differ"),
        ({"openings": [OPENING | {"passed": "yes"}]}, r"openings\[0\]\.passed: must be a valid boolean, not 'yes'"),
        (
            {"poses": [{"sweep": 0, "x": 0.0, "y": 0.0}]},
            r"poses\[0\]\.yaw: the key 'yaw' is missing; add it: yaw: Heading",
        ),
    ],
)
def test_an_invalid_map_is_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, **changes)


def test_the_quality_of_a_map_is_written_and_read(tmp_path: Path) -> None:
    quality = Quality(verdict=Verdict.FAILED, reasons=("Nothing fits.",), next_step="Record again.")
    write_map(tmp_path / "new.json", replace(read(tmp_path), quality=quality))
    assert json.loads((tmp_path / "new.json").read_text())["quality"] == {
        "verdict": "failed",
        "reasons": ["Nothing fits."],
        "next_step": "Record again.",
    }
    assert read_map(tmp_path / "new.json").quality == quality


def test_a_map_that_was_not_assessed_has_no_quality(tmp_path: Path) -> None:
    write_map(tmp_path / "new.json", read(tmp_path))
    assert read_map(tmp_path / "new.json").quality is None
    assert "quality" not in json.loads((tmp_path / "new.json").read_text())


def test_an_unknown_verdict_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"quality\.verdict: must be 'good', 'doubtful' or 'failed'"):
        read(tmp_path, quality={"verdict": "fine"})


@pytest.mark.parametrize("far", [1e200, 1e308, 1e6])
@pytest.mark.parametrize("read", [read_map, read_truth])
def test_a_wall_that_is_longer_than_any_building_is_refused(
    tmp_path: Path, far: float, read: Callable[..., object]
) -> None:
    wall = {"start": [0, 0], "end": [far, 0], "normal_angle": 0, "offset": 0, "covariance": [[1, 0], [0, 1]]}
    document = {"format": "echoplan-map/1", "walls": [wall]} if read is read_map else {"walls": [[0, 0, far, 0]]}
    (tmp_path / "map.json").write_text(json.dumps(document))
    with pytest.raises(InputError, match=r"map\.json.*: (must be less than|the (map|truth) is 1e\+06 m wide)"):
        read(tmp_path / "map.json")
