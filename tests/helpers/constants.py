"""Settings with changed constants."""

from typing import Any, TypeVar

from echoplan.settings import Settings

__all__ = ["settings_with"]

SettingsT = TypeVar("SettingsT", bound=Settings)


def settings_with(model: type[SettingsT], **values: Any) -> SettingsT:
    """Make settings with given values, of which some may be constants of the class."""
    constants = {key: value for key, value in values.items() if key in model.__class_vars__}
    other: type[SettingsT] = type(model.__name__, (model,), constants)
    return other.model_validate({key: value for key, value in values.items() if key not in constants})
