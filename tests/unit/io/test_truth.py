"""The truth of a recording is read from what programs write."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from echoplan.errors import InputError
from echoplan.io import builtin_world, read_truth, write_truth, write_world
from echoplan.model import EVERYWHERE, Truth

TRUTH = {
    "walls": [[0.0, 0.0, 4.0, 0.5], [4.0, 0.5, 4.0, 3.0]],
    "walls_heard": [3, 0],
    "cylinders": [[3.0, 1.0, 0.1]],
    "cylinders_heard": [2],
    "poses": [[0.5, 0.6, 0.1]],
    "given": [[0.51, 0.6, 0.12]],
    "temperature": 31.0,
    "author": "another program",
}


def read(tmp_path: Path, **changes: Any) -> Truth:
    path = tmp_path / "truth.json"
    path.write_text(json.dumps({key: value for key, value in (TRUTH | changes).items() if value is not None}))
    return read_truth(path)


def test_all_is_read_and_what_is_unknown_passed_over(tmp_path: Path) -> None:
    truth = read(tmp_path)
    assert truth.walls_xy.tolist() == [[[0.0, 0.0], [4.0, 0.5]], [[4.0, 0.5], [4.0, 3.0]]]
    assert (truth.walls_detected_by.tolist(), truth.cylinders_detected_by.tolist()) == ([3, 0], [2])
    assert truth.cylinders.tolist() == TRUTH["cylinders"]
    assert (truth.poses.tolist(), truth.given.tolist()) == (TRUTH["poses"], TRUTH["given"])
    assert truth.temperature == 31.0


def test_poses_that_are_not_given_are_the_true_ones(tmp_path: Path) -> None:
    assert read(tmp_path, given=None).given.tolist() == TRUTH["poses"]


def test_everything_but_the_walls_is_optional(tmp_path: Path) -> None:
    truth = read(tmp_path, cylinders=None, cylinders_heard=None, poses=None, given=None, temperature=None)
    assert (truth.cylinders.shape, truth.poses.shape, truth.temperature) == ((0, 3), (0, 3), None)


def test_without_counts_of_stations_everything_is_detected_everywhere(tmp_path: Path) -> None:
    truth = read(tmp_path, walls_heard=None, cylinders_heard=None)
    assert (truth.walls_detected_by.tolist(), truth.cylinders_detected_by.tolist()) == ([EVERYWHERE] * 2, [EVERYWHERE])


def test_a_world_is_a_truth_of_all_its_faces(tmp_path: Path) -> None:
    world = builtin_world("square")
    write_world(tmp_path / "world.toml", world)
    truth = read_truth(tmp_path / "world.toml")
    assert truth.walls_xy.tolist() == world.segments_xy.tolist()
    assert truth.walls_detected_by.tolist() == [EVERYWHERE] * 4
    assert truth.cylinders.tolist() == world.discs.tolist()
    assert not len(truth.poses)


def test_a_temperature_that_is_not_known_is_not_written(tmp_path: Path) -> None:
    write_truth(
        tmp_path / "truth.json", Truth(walls_xy=np.zeros((0, 2, 2)), walls_detected_by=np.zeros(0, dtype=np.int64))
    )
    assert "temperature" not in json.loads((tmp_path / "truth.json").read_text())


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"walls": [[0.0, 0.0, 1.0]]}, r"truth\.json, walls\[0\]: must have at least 4 items, not 3; walls: List"),
        ({"walls_heard": [1]}, r"walls_heard must have shape \(2\), not \(1,\)"),
        ({"walls_heard": [1, -1]}, r"walls_heard\[1\]: must be greater than or equal to 0, not -1"),
        ({"walls_heard": [1, 10**30]}, r"walls_heard\[1\]: must be less than or equal to"),
        ({"poses": [[0.0, 0.0, float("nan")]]}, r"poses\[0\]\[2\]: must be a finite number, not nan"),
        ({"given": [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]}, r"given must have shape \(1, 3\), not \(2, 3\)"),
        ({"walls": None}, r"the key 'walls' is missing; add it: walls: List of faces"),
    ],
)
def test_an_invalid_truth_is_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, **changes)
