"""Settings are read under their former names, and each says what it is in a sentence of its own."""

import importlib
import pkgutil
import re
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest
from pydantic import BaseModel, Field, ValidationError

import echoplan
from echoplan.cli.configuration import settings_of
from echoplan.config import read_config
from echoplan.errors import InputError
from echoplan.joint.mapper import JointSettings
from echoplan.settings import Settings


class GateSettings(Settings):
    """Settings of a stage in a stage."""

    former_keys: ClassVar = {"turn": "angle"}

    angle: float = Field(default=0.1, gt=0.0, description="Largest angle [rad].")


class StageSettings(Settings):
    """Settings of a stage."""

    former_keys: ClassVar = {"copies": "duplicates", "most": "max_steps", "slack": "tolerance"}

    duplicates: GateSettings = Field(default_factory=GateSettings)
    max_steps: int = Field(default=3, ge=1, description="Largest number of steps.")
    # Was a setting once.
    tolerance: ClassVar[float] = 0.1


def models() -> list[type[BaseModel]]:
    """All models of echoplan, settings and forms of files."""
    for module in pkgutil.walk_packages(echoplan.__path__, "echoplan."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
    found, rest = [], [BaseModel]
    while rest:
        rest += (below := rest.pop().__subclasses__())
        found += [each for each in below if each.__module__.startswith("echoplan.")]
    return sorted(found, key=lambda each: (each.__module__, each.__qualname__))


DESCRIPTIONS = {
    f"{model.__module__}.{model.__qualname__}.{key}": field.description
    for model in models()
    for key, field in model.model_fields.items()
    if field.description is not None
}


def settings_models() -> list[type[Settings]]:
    return [model for model in models() if issubclass(model, Settings)]


def read(tmp_path: Path, text: str) -> StageSettings:
    path = tmp_path / "config.toml"
    path.write_text(text, encoding="utf-8")
    settings: StageSettings = read_config(path, {"stage": StageSettings})["stage"]
    return settings


def test_settings_are_immutable_and_refuse_unknown_keys() -> None:
    with pytest.raises(ValidationError, match="frozen"):
        StageSettings().max_steps = 4
    with pytest.raises(ValidationError, match="not permitted"):
        StageSettings(steps=4)  # type: ignore[call-arg]


def test_a_former_key_is_read_with_a_warning_at_the_line_that_uses_it() -> None:
    former: dict[str, Any] = {"most": 5}
    with pytest.warns(FutureWarning, match=r"^the key most is now called max_steps; ") as caught:
        settings = StageSettings(**former)
    assert settings == StageSettings(max_steps=5)
    assert [Path(each.filename).name for each in caught] == ["test_settings.py"]


@pytest.mark.parametrize("key", ["tolerance", "slack"])
def test_a_key_that_is_no_longer_a_setting_is_dropped_with_a_warning(key: str) -> None:
    with pytest.warns(FutureWarning, match=f"^no longer settings, and not used: {key}$"):
        settings = StageSettings.model_validate({key: 0.2, "max_steps": 5})
    assert settings == StageSettings(max_steps=5)
    assert settings.tolerance == 0.1


def test_former_keys_of_a_stage_in_a_stage_are_named_with_their_tables() -> None:
    with pytest.warns(FutureWarning) as caught:
        settings = StageSettings.model_validate({"copies": {"turn": 0.2}})
    assert settings == StageSettings(duplicates=GateSettings(angle=0.2))
    assert [str(each.message).partition(";")[0] for each in caught] == [
        "the key copies is now called duplicates",
        "the key copies.turn is now called duplicates.angle",
    ]


def test_current_keys_do_not_warn() -> None:
    with warnings.catch_warnings(action="error"):
        assert StageSettings(duplicates=GateSettings(angle=0.2)).duplicates.angle == 0.2


def test_a_file_with_a_former_key_is_read_with_a_warning_that_names_the_file(tmp_path: Path) -> None:
    with pytest.warns(FutureWarning, match=r"config\.toml: the key duplicates\.turn is now called duplicates\.angle"):
        settings = read(tmp_path, "[stage.duplicates]\nturn = 0.2\n")
    assert settings.duplicates.angle == 0.2


def test_a_former_key_beside_its_current_one_is_an_error_in_one_line(tmp_path: Path) -> None:
    problem = r"line 1, stage: most is now called max_steps, and both are given; delete most$"
    with pytest.raises(InputError, match=problem):
        read(tmp_path, "[stage]\nmost = 4\nmax_steps = 5\n")


def test_an_error_under_a_former_key_also_reports_the_new_name(tmp_path: Path) -> None:
    with (
        pytest.warns(FutureWarning, match="the key most is now called max_steps"),
        pytest.raises(InputError, match=r"stage\.max_steps: must be .*, not 0; max_steps: Largest number of steps\.$"),
    ):
        read(tmp_path, "[stage]\nmost = 0\n")


def test_a_command_prints_one_line_for_each_former_key(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "config.toml"
    path.write_text("[method]\nagreement = 0.5\n[method.squareness]\nmeasured = 0.01\nwithin = 0.2\n", encoding="utf-8")
    settings = settings_of(path, "method", JointSettings)
    assert (settings.min_inlier_ratio, settings.manhattan.prior_axis_aligned) == (0.5, 0.01)
    lines = capsys.readouterr().err.splitlines()
    assert [line.partition(";")[0] for line in lines] == [
        f"echoplan: {path}: the key agreement is now called min_inlier_ratio",
        f"echoplan: {path}: the key squareness is now called manhattan",
        f"echoplan: {path}: the key squareness.measured is now called manhattan.prior_axis_aligned",
        f"echoplan: {path}: no longer settings, and not used: squareness.within",
    ]


def test_former_keys_name_keys_that_exist_and_none_that_is_in_use() -> None:
    for model in settings_models():
        assert set(model.former_keys.values()) <= set(model.model_fields) | model.__class_vars__, model
        assert not set(model.former_keys) & set(model.model_fields), model


def test_joint_has_no_more_than_forty_settings() -> None:
    assert len(list(keys_of(JointSettings))) <= 40


def keys_of(model: type[BaseModel]) -> Iterator[str]:
    """Keys of settings and of the stages in them."""
    for key, field in model.model_fields.items():
        if isinstance(field.annotation, type) and issubclass(field.annotation, Settings):
            yield from keys_of(field.annotation)
        else:
            yield key


def test_every_setting_but_a_stage_has_a_description() -> None:
    bare = {
        f"{model.__name__}.{key}"
        for model in settings_models()
        for key, field in model.model_fields.items()
        if field.description is None
        and not (isinstance(field.annotation, type) and issubclass(field.annotation, Settings))
    }
    assert not bare


@pytest.mark.parametrize("key", DESCRIPTIONS)
def test_a_description_is_a_sentence_of_its_own(key: str) -> None:
    description = DESCRIPTIONS[key]
    assert re.fullmatch(r"[A-Z].*\.", description)
    assert not re.match(r"(Of|That|Likewise|Between|At)\b", description)
