"""Settings of all stages come from one file, and a run leaves such a file behind."""

import tomllib
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel, Field

from echoplan.config import Run, Sections, read_config, write_run
from echoplan.errors import InputError, OutputError
from echoplan.methods import METHODS, find_method
from echoplan.simulation import SimulationSettings
from echoplan.version import __version__


class FilterSettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of a stage in a stage."""

    limit: float = Field(default=2.0, gt=0.0, description="the greatest distance [m]")
    weights: tuple[float, ...] = Field(default=(1.0, 2.0), description="how much each counts")


class StageSettings(BaseModel, frozen=True, extra="forbid"):
    """Settings of a stage."""

    name: str = Field(default="plain", description="what to call it")
    width: float | None = Field(default=None, description="the width, if it is known")
    filter: FilterSettings = Field(default=FilterSettings(), description="the filter")


SECTIONS: Sections = {"stage": StageSettings, "other": FilterSettings}


def read(tmp_path: Path, text: str) -> dict[str, Any]:
    path = tmp_path / "config.toml"
    path.write_text(text, encoding="utf-8")
    return read_config(path, SECTIONS)


def test_what_is_not_in_the_file_has_its_default(tmp_path: Path) -> None:
    assert read(tmp_path, "") == {"stage": StageSettings(), "other": FilterSettings()}


def test_each_stage_gets_its_own_table_and_no_other(tmp_path: Path) -> None:
    settings = read(tmp_path, '[stage]\nname = "fine"\n[stage.filter]\nlimit = 3\n[other]\nweights = [0.5]\n')
    assert settings["stage"] == StageSettings(name="fine", filter=FilterSettings(limit=3.0))
    assert settings["other"] == FilterSettings(weights=(0.5,))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[stgae]\n", r"config\.toml, line 1, stgae: the key 'stgae' is unknown; did you mean 'stage'\?"),
        ("[stage]\nnmae = 'x'\n", r"line 2, stage\.nmae: the key 'nmae' is unknown; did you mean 'name'\?"),
        ("[stage.filter]\nlimt = 1\n", r"line 2, stage\.filter\.limt: the key 'limt' is unknown; did you mean 'limit'"),
        (
            "[other]\nlimit = 0\n",
            r"line 2, other\.limit: must be greater than 0, not 0; limit: the greatest distance",
        ),
        ("[other]\nlimit = 'far'\n", r"line 2, other\.limit: must be a valid number, not 'far'"),
        ("stage = 3\n", r"line 1, stage: must be a table, not 3"),
        ("[stage\n", r"config\.toml, line 1, column 7: the file is broken"),
    ],
)
def test_an_invalid_configuration_is_refused(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read(tmp_path, text)


def test_a_run_leaves_a_configuration_that_runs_it_again(tmp_path: Path) -> None:
    settings: dict[str, BaseModel] = {
        "stage": StageSettings(width=0.1 + 0.2, filter=FilterSettings(weights=())),
        "other": FilterSettings(limit=1e-9),
    }
    write_run(tmp_path / "run.toml", Run(source="sim:square,seed=7", method="rcd", seed=7), settings)
    assert read_config(tmp_path / "run.toml", SECTIONS) == settings
    assert tomllib.loads((tmp_path / "run.toml").read_text())["run"] == {
        "source": "sim:square,seed=7",
        "method": "rcd",
        "seed": 7,
        "version": __version__,
    }


def test_what_was_not_used_is_not_recorded(tmp_path: Path) -> None:
    write_run(tmp_path / "run.toml", Run(source="take/"), {})
    assert set(tomllib.loads((tmp_path / "run.toml").read_text())["run"]) == {"source", "version"}


@pytest.mark.parametrize(
    "settings",
    [SimulationSettings, *(method.settings_type for method in METHODS.values())],
    ids=["simulation", *METHODS],
)
def test_the_settings_of_every_stage_survive_the_record_of_a_run(tmp_path: Path, settings: type[BaseModel]) -> None:
    write_run(tmp_path / "run.toml", Run(source="take/"), {"stage": settings()})
    assert read_config(tmp_path / "run.toml", {"stage": settings}) == {"stage": settings()}


def test_a_run_that_cannot_be_recorded_is_refused(tmp_path: Path) -> None:
    (tmp_path / "run.toml").mkdir()
    with pytest.raises(OutputError, match="there is a folder of that name"):
        write_run(tmp_path / "run.toml", Run(source="take/"), {})


@pytest.mark.parametrize("method", ["rcd", "mdp-fuzzy"])
def test_a_reach_of_more_pings_than_a_turn_has_is_refused(tmp_path: Path, method: str) -> None:
    (tmp_path / "c.toml").write_text("[method.clustering]\nreach = 9999999999999999999999999\n")
    with pytest.raises(InputError):
        read_config(tmp_path / "c.toml", {"method": find_method(method).settings_type})
