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
