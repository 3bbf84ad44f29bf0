"""The examples of ``docs/formats.md`` are files that echoplan reads."""

import json
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from echoplan.config import read_config
from echoplan.errors import InputError
from echoplan.io import (
    read_grid,
    read_map,
    read_recording,
    read_rig,
    read_route,
    read_trajectory,
    read_truth,
    read_world,
    rig_names,
    world_names,
    write_map,
)
from echoplan.io.pgm import write_pgm
from echoplan.methods import find_method
from echoplan.model import CornerKind

DOCUMENT = Path(__file__).parents[2] / "docs" / "formats.md"
TEXT = DOCUMENT.read_text(encoding="utf-8")


@pytest.fixture
def examples(tmp_path: Path) -> Path:
    """Write the examples of the document into files of their names."""
    for name, content in re.findall(r"^```\w+ (\S+)\n(.*?)^```$", TEXT, flags=re.DOTALL | re.MULTILINE):
        (tmp_path / name).write_text(content, encoding="utf-8")
    return tmp_path


def test_the_recording_is_read(examples: Path) -> None:
    first, second = read_recording(examples)
    np.testing.assert_array_equal(first.ranges, [1.29, np.inf, 1.285, np.nan])
    assert second.stamps_ns.tolist() == [2_025_000_000]
    assert second.map_from_base.tolist() == [[0.75, 0.25, 1.6]]


def test_the_rig_is_read_and_names_every_key(examples: Path) -> None:
    rig = read_rig(examples / "rig.toml")
    assert (rig.servo is None, rig.firing is None, rig.transducer is None) == (False, False, False)
    assert [sensor.x for sensor in rig.sensors] == [0.05, -0.05]
    for table, content in tomllib.loads((examples / "rig.toml").read_text()).items():
        keys = content[0] if isinstance(content, list) else content if isinstance(content, dict) else {table: 0}
        assert all(f"`{key}`" in TEXT for key in keys)


def test_the_world_and_the_routes_are_read(examples: Path) -> None:
    assert read_world(examples / "world.toml").name == "attic"
    assert read_route(examples / "route.csv").stamps_ns is None
    assert read_route(examples / "way.csv").stamps_ns is not None


def test_the_truth_and_the_map_are_read(examples: Path) -> None:
    assert read_truth(examples / "truth.json").walls_detected_by.tolist() == [3, 1]
    found = read_map(examples / "map.json")
    assert (found.walls[0].pings, found.corners[0].kind, found.cylinders[0].radius) == (412, CornerKind.CONCAVE, 0.1)
    assert (found.openings[0].passed, found.walls[1].inferred.tolist()) == (True, [0.0, 0.4])


def test_every_key_of_a_map_is_explained(examples: Path) -> None:
    write_map(examples / "again.json", read_map(examples / "map.json"))
    document = json.loads((examples / "again.json").read_text())
    features = [document[kind][-1] for kind in ("walls", "corners", "cylinders", "openings", "unobserved")]
    keys = {key for table in (document, *features) for key in table}
    assert [key for key in sorted(keys) if f"`{key}`" not in TEXT] == []


def test_the_trajectory_and_the_grid_are_read(examples: Path) -> None:
    stamps_ns, poses = read_trajectory(examples / "trajectory.tum")
    assert (stamps_ns.tolist(), poses.round(4).tolist()) == ([25_000_000], [[0.5, 0.25, 1.5708]])
    write_pgm(examples / "map.pgm", np.array([[254, 0]], dtype=np.uint8))
    grid = read_grid(examples / "map.yaml")
    assert grid.values.tolist() == [[0.0, 1.0]]
    assert (grid.origin_xy.tolist(), grid.resolution) == ([-1.0, 2.0], 0.05)


def test_the_configurations_are_read(examples: Path) -> None:
    sections = {"method": find_method("mdp-fuzzy").settings_type}
    assert read_config(examples / "run.toml", sections)["method"].filter.min_members == 4


def test_the_documented_error_is_the_one_raised(examples: Path) -> None:
    lines = ["", "[[sensor]]", "id = 0", "half_aperture = 35"]
    (examples / "rig.toml").write_text("\n" * 10 + "\n".join(lines), encoding="utf-8")
    with pytest.raises(InputError) as caught:
        read_rig(examples / "rig.toml")
    assert str(caught.value).removeprefix(f"{examples}/") in TEXT


def test_everything_built_in_is_listed() -> None:
    assert [name for name in (*rig_names(), *world_names()) if f"`{name}`" not in TEXT] == []
