"""What a page may ask of the server, as JSON: checked, or refused in one line."""

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from echoplan.errors import InputError
from echoplan.io.units import WIDEST

__all__ = ["Command", "PlaceCommand", "PlayCommand", "SaveCommand", "SweepCommand", "UndoCommand", "parse_command"]

_Metres = Annotated[float, Field(ge=-WIDEST, le=WIDEST)]
_Radians = Annotated[float, Field(ge=-100.0, le=100.0)]


class _Strict(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class PlaceCommand(_Strict):
    """Move a station, or without a number set where the next sweep is made."""

    type: Literal["place"]
    station: int | None = Field(default=None, ge=0)
    x: _Metres
    y: _Metres
    yaw: _Radians


class SweepCommand(_Strict):
    """Make one sweep."""

    type: Literal["sweep"]


class UndoCommand(_Strict):
    """Drop the last station."""

    type: Literal["undo"]


class PlayCommand(_Strict):
    """Go on, or pause."""

    type: Literal["play"]
    playing: bool


class SaveCommand(_Strict):
    """Write the recording, the map and its exports."""

    type: Literal["save"]


Command = PlaceCommand | SweepCommand | UndoCommand | PlayCommand | SaveCommand
_COMMANDS: TypeAdapter[Command] = TypeAdapter(Annotated[Command, Field(discriminator="type")])


def parse_command(text: str | bytes) -> Command:
    """Read a command.

    Raises
    ------
    InputError
        If it is no command.
    """
    try:
        return _COMMANDS.validate_json(text)
    except ValidationError as error:
        first = error.errors(include_url=False, include_input=False)[0]
        place = ".".join(str(each) for each in first["loc"])
        remedy = "reload the page"
        raise InputError("command", first["msg"].lower(), place=place, remedy=remedy) from None
