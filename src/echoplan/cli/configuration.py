"""The settings that a command takes from a file."""

import sys
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

if TYPE_CHECKING:
    from pydantic import BaseModel

__all__ = ["settings_of"]

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
