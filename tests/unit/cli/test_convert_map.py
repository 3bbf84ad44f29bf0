"""``echoplan convert`` of maps."""

from pathlib import Path

import pytest
from typer.testing import CliRunner

from echoplan.cli.app import app
from echoplan.errors import EchoplanError
from echoplan.io import read_grid, read_map, write_map
from helpers import maps


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder of results with a map of one room."""
    write_map(tmp_path / "kitchen" / "map.json", maps.drawn(*(maps.wall(*ends) for ends in maps.ROOM.walls_xy)))
    return tmp_path / "kitchen"


def converted(*words: str) -> str:
    """What the command prints; errors are raised."""
    result = CliRunner().invoke(app, ["convert", *words], catch_exceptions=False)
    return result.stdout


@pytest.mark.parametrize(
    ("name", "beginning"),
    [("a.pdf", b"%PDF-"), ("a.PNG", b"\x89PNG"), ("a.svg", b"<"), ("a.geojson", b"{"), ("a.mcap", b"\x89MCAP")],
)
def test_a_map_becomes_a_file_of_the_kind_that_its_suffix_names(folder: Path, name: str, beginning: bytes) -> None:
    target = folder.parent / "out" / name
    assert f"Written to {target.parent}: {name}" in converted(str(folder), "--to", str(target))
    assert target.read_bytes().startswith(beginning)


def test_a_map_becomes_a_grid_of_two_files_that_find_each_other(folder: Path) -> None:
    assert "plan.yaml, plan.pgm" in converted(str(folder / "map.json"), "--to", str(folder / "plan.yaml"))
    assert read_grid(folder / "plan.yaml").values.max() == 1.0
    assert len(read_map(folder / "map.json").walls) == len(maps.ROOM.walls_xy)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--to", "plan.xyz"], r"has the suffix '.xyz'; end it with one of .dxf"),
        (["--to", "plan.pdf", "--center", "90"], "it is no text log"),
        (["--to", "plan.pdf", "--topic", "/sonar"], "it is no ROS bag"),
    ],
)
def test_what_makes_no_sense_for_a_map_is_refused(folder: Path, words: list[str], message: str) -> None:
    with pytest.raises(EchoplanError, match=message):
        converted(str(folder), *words)
    assert [path.name for path in folder.iterdir()] == ["map.json"]
