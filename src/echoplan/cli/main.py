"""The command line: one line a subcommand, and the one place where errors become messages."""

import sys
from typing import NoReturn

import typer
from typer.exceptions import TyperException

from echoplan.cli import compare, demo, evaluate, info, simulate
from echoplan.cli import map as map_command
from echoplan.errors import EchoplanError

__all__ = ["app", "main"]

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
app.command("evaluate")(evaluate.run)
app.command("compare")(compare.run)
app.command("info")(info.run)


def main() -> None:
    """Run the command line; bad words and errors of ours become one line on standard error and exit status 2."""
    words = sys.argv[1:]
    try:
        sys.exit(app(words or ["--help"], prog_name="echoplan", standalone_mode=False))
    except EchoplanError as error:
        _refuse(str(error))
    except TyperException as error:
        _refuse(f"{_as_clause(error.format_message())}; see {_help_for(words)}")


def _refuse(message: str) -> NoReturn:
    sys.stderr.write(f"echoplan: {message}\n")
    sys.exit(2)


def _as_clause(sentence: str) -> str:
    words = " ".join(sentence.split()).rstrip(".")
    return words[:1].lower() + words[1:]


def _help_for(words: list[str]) -> str:
    commands = {command.name for command in app.registered_commands}
    named = [word for word in words[:1] if word in commands]
    return " ".join(["echoplan", *named, "--help"])
