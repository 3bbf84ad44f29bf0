"""The settings that a command takes from a file."""

import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from pydantic import BaseModel

__all__ = ["method_and_settings", "settings_of"]

SettingsT = TypeVar("SettingsT", bound="BaseModel")


def settings_of(config: Path | None, section: str, settings_type: type[SettingsT]) -> SettingsT:
    """Read the settings of a section, or take the defaults without a file; print a line for each renamed key."""
    from echoplan.config import read_config  # noqa: PLC0415 - --help must not wait for NumPy

    if config is None:
        return settings_type()
    renamed: list[warnings.WarningMessage] = []
    try:
        with warnings.catch_warnings(record=True, action="always", category=FutureWarning) as renamed:
            settings: SettingsT = read_config(config, {section: settings_type})[section]
    finally:
        for each in renamed:
            sys.stderr.write(f"echoplan: {each.message}\n")
    return settings


def method_and_settings(config: Path | None, method: str | None) -> "tuple[str, BaseModel]":
    """Return the name of the method, as named or else of the run in the file or else joint, and its settings."""
    from echoplan.config import method_of  # noqa: PLC0415
    from echoplan.methods import find_method  # noqa: PLC0415

    name = method or (method_of(config) if config else None) or "joint"
    return name, settings_of(config, "method", find_method(name).settings_type)
