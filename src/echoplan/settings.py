"""Settings: the base of all models whose keys users type."""

import warnings
from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, model_validator

__all__ = ["Settings"]


class Settings(BaseModel):
    """Settings of a stage: immutable, and without keys that it does not know.

    Keys of ``former_keys`` are read under their new names, with a ``FutureWarning`` for each.  What is declared as
    ``ClassVar`` is no setting: a key of this name, which was one before, is dropped; one warning lists them.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    former_keys: ClassVar[Mapping[str, str]] = {}

    @model_validator(mode="before")
    @classmethod
    def _read_former_keys(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        current, changed = _with_current_keys(cls, data)
        problems = [
            f"the key {old} is now called {new}; the old name will go in a later version"
            for old, new in changed.items()
            if new
        ]
        if fixed := [old for old, new in changed.items() if not new]:
            problems.append(f"no longer settings, and not used: {', '.join(fixed)}")
        for problem in problems:
            # Level 3 is the line that makes the settings: a method of pydantic calls this one.
            warnings.warn(problem, FutureWarning, stacklevel=3)
        return current


def _with_current_keys(settings: type[Settings], data: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return settings, with those of the stages in them, under current keys, and what became of other dotted keys.

    That is their new name, or empty if they are no longer settings.
    """
    changed = _former_keys_in(settings, data)
    typed = {new: key for key in data if (new := changed.get(key, key))}
    current = {new: data[key] for new, key in typed.items()}
    for key, stage in _stages(settings).items():
        if isinstance(current.get(key), Mapping):
            current[key], nested = _with_current_keys(stage, current[key])
            changed |= {f"{typed[key]}.{old}": new and f"{key}.{new}" for old, new in nested.items()}
    return current, changed


def _former_keys_in(settings: type[Settings], data: Mapping[str, Any]) -> dict[str, str]:
    """Return the current keys by the former ones that are in data, empty for those that are no longer settings.

    Data that have both names of a key are refused.
    """
    constants = settings.__class_vars__ - Settings.__class_vars__
    renamed = {old: new for old, new in settings.former_keys.items() if old in data}
    for old, new in renamed.items():
        if new in data:
            raise ValueError(f"{old} is now called {new}, and both are given; delete {old}")
    renamed |= {key: key for key in data if key in constants}
    return {old: "" if new in constants else new for old, new in renamed.items()}


def _stages(settings: type[Settings]) -> dict[str, type[Settings]]:
    """Return the settings of the stages in settings by their keys."""
    annotations = {key: field.annotation for key, field in settings.model_fields.items()}
    return {key: each for key, each in annotations.items() if isinstance(each, type) and issubclass(each, Settings)}
