"""``echoplan compare`` as a stranger runs it."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest


def compare(folder: Path, *words: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "echoplan", "compare", *words]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp("compare")
    done = compare(folder, "sim:square,seed=3", "--methods", "mdp-fuzzy,rcd", "--out", "out")
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "out", done.stdout


def test_a_table_on_the_terminal_has_a_row_for_each_method(compared: tuple[Path, str]) -> None:
    rows = [line.split() for line in compared[1].splitlines() if line.startswith(("mdp-fuzzy", "rcd"))]
    assert [row[0] for row in rows] == ["mdp-fuzzy", "rcd"]
    assert rows[0][4:7] == ["100", "/", "100"]


def test_the_numbers_on_disk_are_those_of_the_maps(compared: tuple[Path, str]) -> None:
    rows = list(csv.DictReader((compared[0] / "comparison.csv").read_text(encoding="utf-8").splitlines()))
    document = json.loads((compared[0] / "comparison.json").read_text(encoding="utf-8"))
    assert [float(row["wall_recall"]) for row in rows] == [1.0, 1.0]
    assert float(rows[0]["wall_offset_mm"]) < 5.0
    assert float(rows[0]["map_error_mm"]) < 10.0 < float(rows[1]["map_error_mm"])
    assert document["methods"][0]["trials"][0]["evaluation"]["walls"]["recall"] == 1.0


def test_the_page_holds_both_maps(compared: tuple[Path, str]) -> None:
    assert (compared[0] / "comparison.html").read_text(encoding="utf-8").count("<svg") == 2


def test_an_unknown_method_or_source_is_refused_in_one_line(tmp_path: Path) -> None:
    method = compare(tmp_path, "sim:square", "--methods", "mdp-fuzy")
    assert method.returncode == 2
    assert method.stderr.startswith("echoplan: unknown method 'mdp-fuzy'; did you mean 'mdp-fuzzy'?")
    source = compare(tmp_path, "nowhere", "--methods", "rcd")
    assert (source.returncode, len(source.stderr.splitlines())) == (2, 1)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording")
    command = [sys.executable, "-m", "echoplan", "simulate", "square", "--seed", "2", "--out", "rec"]
    subprocess.run(command, cwd=folder, capture_output=True, check=True)
    return folder / "rec"


def test_without_truth_maps_and_costs_are_told(recording: Path, tmp_path: Path) -> None:
    for name in ("pings.csv", "rig.toml"):
        (tmp_path / name).write_bytes((recording / name).read_bytes())
    done = compare(tmp_path, ".", "--methods", "rcd", "--out", "out")
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[1].split()[:3] == ["method", "maps", "ms"]
    page = (tmp_path / "out" / "comparison.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 1
    assert "map error" not in page


def test_a_truth_may_be_named_by_its_file_or_its_folder(recording: Path, tmp_path: Path) -> None:
    for name in ("pings.csv", "rig.toml"):
        (tmp_path / name).write_bytes((recording / name).read_bytes())
    for truth in (recording, recording / "truth.json"):
        done = compare(tmp_path, ".", "--methods", "rcd", "--truth", str(truth))
        assert "map error (mm)" in done.stdout, done.stderr


def test_a_source_that_is_named_twice_is_compared_once(recording: Path) -> None:
    done = compare(recording.parent, "rec", "rec", "--methods", "rcd,rcd")
    assert [line.split()[:4] for line in done.stdout.splitlines()[2:3]] == [["rcd", "1", "of", "1"]]
