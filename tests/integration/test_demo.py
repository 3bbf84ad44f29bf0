"""``echoplan demo`` as a stranger runs it."""

import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from echoplan.io import read_map, read_recording, read_truth

# Every test maps a room or more by the command line.

FIGURES = ("02-ranges", "05-fit", "07-memberships", "10-filter", "11-clusters", "12-classes", "13-map")


def run_demo(folder: Path, *options: str) -> tuple[Path, str]:
    command = [sys.executable, "-m", "echoplan", "demo", "--out", "out", "--seed", "3", *options]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
    assert done.stderr == ""
    return folder / "out", done.stdout


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    return run_demo(tmp_path_factory.mktemp("demo"))


@pytest.fixture(scope="module")
def paper(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    return run_demo(tmp_path_factory.mktemp("paper"), "--paper")


def test_the_flat_is_mapped_with_its_door_and_its_furniture(demo: tuple[Path, str]) -> None:
    found = read_map(demo[0] / "map.json")
    assert found.method == "joint"
    assert len(found.cylinders) == 2
    (door,) = found.openings
    assert door.passed
    assert abs(door.width - 0.85) < 0.15


def test_the_map_is_compared_with_the_true_flat_on_the_terminal(demo: tuple[Path, str]) -> None:
    after = demo[1].split("The map compared with the true flat", 1)[1].splitlines()
    rows = {line.split()[0]: line.split() for line in after[2:6]}
    assert list(rows) == ["walls", "corners", "cylinders", "openings"]
    true, found, false = (int(number) for number in rows["walls"][1:4])
    assert true == 13
    assert found >= 12
    assert false <= 1
    assert "The path crosses 0 drawn walls." in demo[1]


def test_the_map_of_the_flat_is_drawn(demo: tuple[Path, str]) -> None:
    (picture,) = (demo[0] / "pictures").iterdir()
    assert picture.name == "map.png"
    assert picture.read_bytes().startswith(b"\x89PNG\r\n")


def test_table_5_is_printed_beside_that_of_the_paper(paper: tuple[Path, str]) -> None:
    after = paper[1].split("Table 5", 1)[1].splitlines()
    head, *rows = [line.split() for line in after[1:12]]
    assert head[0] == "wall"
    assert [row[0] for row in rows] == [*"12345678", "mean", "worst"]
    assert [row[1] for row in rows[:8]] == ["12.8", "6.7", "1.0", "7.8", "0.5", "1.8", "3.8", "7.0"]
    # In the mean joint is off by less than the paper's method, and this by less than the conventional one.
    assert sorted(rows[8][2:5], key=float) == rows[8][2:5]


def test_everything_in_the_papers_room_is_on_the_map(paper: tuple[Path, str]) -> None:
    found = read_map(paper[0] / "map.json")
    assert found.method == "joint"
    assert (len(found.walls), len(found.cylinders)) == (8, 1)
    assert sum(corner.kind == "concave" for corner in found.corners) == 1


def test_the_figures_of_the_paper_and_the_map_are_drawn(paper: tuple[Path, str]) -> None:
    pictures = paper[0] / "pictures"
    assert sorted(path.name for path in pictures.iterdir()) == [*(f"figure-{name}.png" for name in FIGURES), "map.png"]
    assert all(path.read_bytes().startswith(b"\x89PNG\r\n") for path in pictures.iterdir())


def test_the_recording_can_be_mapped_again(demo: tuple[Path, str]) -> None:
    recording = read_recording(demo[0] / "recording")
    assert len(recording) == 25
    assert len(read_truth(demo[0] / "recording" / "truth.json").walls_xy) == 18


def test_the_drawing_and_the_report_are_there_and_named_on_the_terminal(demo: tuple[Path, str]) -> None:
    assert ET.parse(demo[0] / "map.svg").getroot().tag.endswith("svg")
    assert "<svg" in (demo[0] / "report.html").read_text(encoding="utf-8")
    assert demo[1].rstrip().endswith("in a browser.")
