"""Worlds are read from what people write."""

from pathlib import Path

import pytest

from echoplan.errors import InputError
from echoplan.io import read_world, write_world
from echoplan.model import World

ROOM = """\
[[wall]]
points = [[0, 0], [4, 0.5], [0, 3]]
closed = true

[[wall]]
points = [[1.0, 1.0], [2.0, 1.0]]
material = "cloth"

[[cylinder]]
center = [3.0, 1.0]
radius = 0.1
"""


def read(tmp_path: Path, text: str) -> World:
    path = tmp_path / "attic.toml"
    path.write_text(text, encoding="utf-8")
    return read_world(path)


def test_a_world_has_walls_and_cylinders(tmp_path: Path) -> None:
    world = read(tmp_path, ROOM)
    assert [wall.points_xy.tolist() for wall in world.polylines] == [
        [[0.0, 0.0], [4.0, 0.5], [0.0, 3.0]],
        [[1.0, 1.0], [2.0, 1.0]],
    ]
    assert [(wall.closed, wall.material) for wall in world.polylines] == [(True, "hard"), (False, "cloth")]
    assert [(*pillar.center_xy.tolist(), pillar.radius) for pillar in world.pillars] == [(3.0, 1.0, 0.1)]


def test_a_world_without_a_name_is_called_after_its_file(tmp_path: Path) -> None:
    assert read(tmp_path, ROOM).name == "attic"
    assert read(tmp_path, 'name = "loft"\n' + ROOM).name == "loft"


def test_an_empty_world_is_a_world(tmp_path: Path) -> None:
    world = read(tmp_path, "")
    write_world(tmp_path / "empty.toml", world)
    assert (tmp_path / "empty.toml").read_text() == 'name = "attic"\nwall = []\ncylinder = []\n'
    assert read_world(tmp_path / "empty.toml").segments_xy.shape == (0, 2, 2)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("center", "centre", r"line 10, cylinder\[0\]\.centre: the key 'centre' is unknown; did you mean 'center'\?"),
        ("[[cylinder]]", "[[cylindre]]", r"line 9, cylindre: the key 'cylindre' is unknown; did you mean 'cylinder'"),
        ("radius = 0.1", "radius = 0.0", r"line 9, cylinder\[0\]: radius must be greater than 0, not 0"),
        (
            "[4, 0.5]",
            "[4, 0.5, 1]",
            r"line 2, wall\[0\]\.points\[1\]: must have at most 2 items, not 3; points: List of",
        ),
        ("[4, 0.5]", "[0, 0]", r"line 1, wall\[0\]: points must differ from their neighbours"),
        (", [0, 3]", "", r"line 1, wall\[0\]: points must be at least 3, not 2"),
        (
            "closed = true",
            "closed = 1",
            r"line 3, wall\[0\]\.closed: must be a valid boolean, not 1; closed: Whether the last",
        ),
    ],
)
def test_an_invalid_world_is_refused(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in ROOM
    with pytest.raises(InputError, match=message):
        read(tmp_path, ROOM.replace(old, new))


@pytest.mark.parametrize("far", ["1e308", "-3e7", "20000.0"])
def test_a_world_that_is_wider_than_any_building_is_refused(tmp_path: Path, far: str) -> None:
    (tmp_path / "w.toml").write_text(f"[[wall]]\npoints = [[0.0, 0.0], [{far}, 0.0], [4.0, 3.0]]\n")
    with pytest.raises(InputError, match=r"w\.toml.*: (must be (less|greater) than|the world is 20000 m wide)"):
        read_world(tmp_path / "w.toml")
