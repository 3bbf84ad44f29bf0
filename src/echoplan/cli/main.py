"""The command line: one line a subcommand, and the one place where errors become messages."""

import sys

import typer

from echoplan.cli import compare, demo, evaluate, info, simulate
from echoplan.cli import map as map_command
from echoplan.errors import EchoplanError

__all__ = ["app", "main"]

app = typer.Typer(
    name="echoplan",
    help="Floor plans from echoes: maps of walls, corners and cylinders from cheap ultrasonic sensors.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)
app.command("demo")(demo.run)
app.command("simulate")(simulate.run)
app.command("map")(map_command.run)
app.command("evaluate")(evaluate.run)
app.command("compare")(compare.run)
app.command("info")(info.run)


def main() -> None:
    """Run the command line; errors of ours become one line on standard error and exit status 2."""
    try:
        app()
    except EchoplanError as error:
        sys.stderr.write(f"echoplan: {error}\n")
        sys.exit(2)
    except BrokenPipeError:
        # Whoever read our output has had enough: that is no error of theirs or ours.
        sys.stderr.close()
        sys.exit(0)
