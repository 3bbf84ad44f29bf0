"""``echoplan compare`` as a stranger runs it."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import pytest

from helpers.typed import echoplan, succeed

# Every test maps a room or more by the command line.


@pytest.fixture(scope="module")
def compared(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    folder = tmp_path_factory.mktemp("compare")
    command = [sys.executable, "-m", "echoplan", "compare", "sim:square,seed=3", "--methods", "mdp-fuzzy,rcd"]
    done = subprocess.run([*command, "--out", "out"], cwd=folder, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "out", done.stdout


def test_a_table_on_the_terminal_has_a_row_for_each_method(compared: tuple[Path, str]) -> None:
    rows = [line.split() for line in compared[1].splitlines() if line.startswith(("mdp-fuzzy", "rcd"))]
    assert [row[0] for row in rows] == 2 * ["mdp-fuzzy", "rcd"]
    assert rows[0][4:7] == ["100", "/", "100"]


def test_the_numbers_on_disk_are_those_of_the_maps(compared: tuple[Path, str]) -> None:
    rows = list(csv.DictReader((compared[0] / "comparison.csv").read_text(encoding="utf-8").splitlines()))
    document = json.loads((compared[0] / "comparison.json").read_text(encoding="utf-8"))
    assert [float(row["wall_recall"]) >= least for row, least in zip(rows, (1.0, 0.75), strict=True)] == [True, True]
    assert float(rows[0]["wall_offset_mm"]) < 5.0
    assert float(rows[0]["length_precision"]) > 0.9
    assert (rows[0]["walked_through"], rows[0]["opening_recall"]) == ("0.0", "")
    assert float(rows[0]["map_error_mm"]) < 10.0 < float(rows[1]["map_error_mm"])
    assert document["methods"][0]["trials"][0]["evaluation"]["walls"]["recall"] == 1.0


def test_the_page_contains_both_maps(compared: tuple[Path, str]) -> None:
    assert (compared[0] / "comparison.html").read_text(encoding="utf-8").count("<svg") == 2


def test_an_unknown_method_or_source_is_refused_in_one_line() -> None:
    method = echoplan("compare", "sim:square", "--methods", "mdp-fuzy")
    assert method.status == 2
    assert method.err.startswith("echoplan: unknown method 'mdp-fuzy'; did you mean 'mdp-fuzzy'?")
    source = echoplan("compare", "nowhere", "--methods", "rcd")
    assert (source.status, len(source.err.splitlines())) == (2, 1)


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("recording") / "rec"
    succeed("simulate", "square", "--seed", "2", "--out", folder)
    return folder


def test_without_truth_the_maps_and_their_costs_are_compared(recording: Path, tmp_path: Path) -> None:
    for name in ("pings.csv", "rig.toml"):
        (tmp_path / name).write_bytes((recording / name).read_bytes())
    said = succeed("compare", tmp_path, "--methods", "rcd", "--out", tmp_path / "out")
    assert said.splitlines()[1].split()[:3] == ["method", "maps", "ms"]
    page = (tmp_path / "out" / "comparison.html").read_text(encoding="utf-8")
    assert page.count("<svg") == 1
    assert "map error" not in page


def test_a_truth_may_be_named_by_its_file_or_its_folder(recording: Path, tmp_path: Path) -> None:
    for name in ("pings.csv", "rig.toml"):
        (tmp_path / name).write_bytes((recording / name).read_bytes())
    for truth in (recording, recording / "truth.json"):
        assert "map error (mm)" in succeed("compare", tmp_path, "--methods", "rcd", "--truth", truth)


def test_a_source_that_is_named_twice_is_compared_once(recording: Path) -> None:
    said = succeed("compare", recording, recording, "--methods", "rcd,rcd")
    assert [line.split()[:4] for line in said.splitlines()[2:3]] == [["rcd", "1", "of", "1"]]
