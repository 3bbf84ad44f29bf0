"""The commands, one file each, gathered under one name."""

from typing import Annotated

import typer

from echoplan.cli import (
    batch,
    calibrate,
    compare,
    convert,
    demo,
    device,
    doctor,
    evaluate,
    info,
    live,
    locate,
    record,
    simulate,
)
from echoplan.cli import map as map_command
from echoplan.cli.terminal import put
from echoplan.version import __version__

__all__ = ["app", "as_clause", "help_for"]

app = typer.Typer(
    name="echoplan",
    help="Floor plans from echoes: maps of walls, corners and cylinders from cheap ultrasonic sensors.",
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    rich_markup_mode="markdown",
)
app.command("demo")(demo.run)
app.command("simulate")(simulate.run)
app.command("map")(map_command.run)
app.command("locate")(locate.run)
app.command("live")(live.run)
app.command("evaluate")(evaluate.run)
app.command("compare")(compare.run)
app.command("batch")(batch.run)
app.command("info")(info.run)
app.command("convert")(convert.run)
app.command("record")(record.run)
app.command("calibrate")(calibrate.run)
app.command("device")(device.run)
app.command("doctor")(doctor.run)


@app.callback(invoke_without_command=True)
def _options(
    version: Annotated[bool, typer.Option("--version", "-V", help="Print the version and exit.")] = False,
) -> None:
    if version:
        put(f"echoplan {__version__}")
        raise typer.Exit


def as_clause(sentence: str) -> str:
    """Make a clause of one line of a sentence."""
    words = " ".join(sentence.split()).rstrip(".")
    return words[:1].lower() + words[1:]


def help_for(words: list[str]) -> str:
    """Name the command that helps with words that were typed wrongly."""
    commands = {command.name for command in app.registered_commands}
    named = [word for word in words[:1] if word in commands]
    return " ".join(["echoplan", *named, "--help"])
