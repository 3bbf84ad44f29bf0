"""What ``echoplan doctor`` finds, and what it says to do."""

import json
import sys
import tomllib
from pathlib import Path

import pytest

from echoplan.cli.doctor import EXTRAS
from echoplan.version import __version__
from helpers.typed import echoplan, succeed

ROOT = Path(__file__).parents[3]


def checks(text: str) -> dict[str, dict[str, str]]:
    return {check["name"]: check for check in json.loads(text)["checks"]}


def test_it_shows_versions_cache_ports_folder_and_output_line_by_line() -> None:
    lines = succeed("doctor").splitlines()
    named = ["echoplan", "Python", "platform", "numpy", "scipy", "numba"]
    extras = [f"extra {name}" for name in EXTRAS]
    starts = [*named, *extras, "compiled code", "serial port", "temporary folder", "output"]
    assert all(any(line.startswith(start) for line in lines) for start in starts)


def test_the_document_has_the_same_checks() -> None:
    found = checks(succeed("doctor", "--json"))
    assert found["echoplan"]["found"].startswith(__version__)
    assert " MB in " in found["compiled code"]["found"]
    assert found["numpy"]["remedy"] == ""


def test_the_extras_are_those_of_the_package() -> None:
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    packages = {extra: {text.partition(">")[0] for text in texts} for extra, texts in declared.items()}
    assert {extra: set(modules) for extra, modules in EXTRAS.items()} == packages


def test_a_missing_extra_is_named_with_the_command_that_installs_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("echoplan.cli.doctor.find_spec", lambda _: None)
    found = checks(succeed("doctor", "--json"))
    assert found["extra cluster"]["found"] == "dask, distributed, pyarrow not installed"
    assert found["extra cluster"]["remedy"] == "pip install dask distributed pyarrow"


def test_a_package_that_cannot_be_imported_is_one_line_and_status_2(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy", None)
    done = echoplan("doctor")
    assert done.status == 2
    assert done.err.startswith("echoplan: scipy: cannot be imported: ")
    assert done.err.count("\n") == 1
    assert "numpy" in done.out


def test_a_temporary_folder_that_cannot_be_written_to_is_no_reason_to_stop(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("echoplan.cli.doctor.gettempdir", lambda: "/nowhere")
    check = checks(succeed("doctor", "--json"))["temporary folder"]
    assert (check["found"], check["remedy"]) == (
        "No such file or directory",
        "set TMPDIR to a folder that you may write to",
    )


@pytest.mark.parametrize("option", ["--version", "-V"])
def test_the_version_is_printed(option: str) -> None:
    assert succeed(option) == f"echoplan {__version__}\n"


def test_out_has_a_short_name(tmp_path: Path) -> None:
    succeed("simulate", "square", "-o", tmp_path / "rec")
    assert (tmp_path / "rec" / "pings.csv").is_file()
