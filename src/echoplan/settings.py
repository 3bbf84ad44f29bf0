"""Settings: the base of all models whose keys users type."""

import warnings
from collections.abc import Mapping
from typing import Any, ClassVar

from pydantic import BaseModel, ConfigDict, model_validator

__all__ = ["Settings"]


class Settings(BaseModel):
    """Settings of a stage: immutable, and without keys that it does not know.

    Keys of ``former_keys`` are read under their new names, with a ``FutureWarning`` for each.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    former_keys: ClassVar[Mapping[str, str]] = {}

    @model_validator(mode="before")
    @classmethod
    def _read_former_keys(cls, data: Any) -> Any:
        if not isinstance(data, Mapping):
            return data
        current, renamed = _with_current_keys(cls, data)
        for old, new in renamed.items():
            problem = f"the key {old} is now called {new}; the old name will go in a later version"
            # Level 3 is the line that makes the settings: a method of pydantic calls this one.
            warnings.warn(problem, FutureWarning, stacklevel=3)
        return current


def _with_current_keys(settings: type[Settings], data: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return settings, with those of the stages in them, under current keys, and the dotted keys that were renamed."""
    renamed = _former_keys_in(settings, data)
    current = {renamed.get(key, key): value for key, value in data.items()}
    typed = {renamed.get(key, key): key for key in data}
    for key, field in settings.model_fields.items():
        stage = field.annotation
        if isinstance(stage, type) and issubclass(stage, Settings) and isinstance(current.get(key), Mapping):
            current[key], nested = _with_current_keys(stage, current[key])
            renamed |= {f"{typed[key]}.{old}": f"{key}.{new}" for old, new in nested.items()}
    return current, renamed


def _former_keys_in(settings: type[Settings], data: Mapping[str, Any]) -> dict[str, str]:
    """Return the current keys by the former ones that are in data; refuse data that have both."""
    renamed = {old: new for old, new in settings.former_keys.items() if old in data}
    for old, new in renamed.items():
        if new in data:
            raise ValueError(f"{old} is now called {new}, and both are given; delete {old}")
    return renamed
