"""``echoplan convert``: one format into another; a text log of any hobby robot becomes a recording."""

import re
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.terminal import Progressing, put, report_files

if TYPE_CHECKING:
    from echoplan.io.text_logs import LogOptions, TextLog

__all__ = ["run"]

# What a recording, or something that is opened like one, is known by; all else is a text log.
_SOURCE_SUFFIXES = (".bag", ".mcap", ".db3")
_LOG_SUFFIXES = (".txt", ".csv", ".log", ".dat", ".tsv", ".asc")
# Skipped lines that are shown.
_SHOWN = 3


def run(
    sources: Annotated[
        list[str], typer.Argument(help="A text log, or one for each place; or a recording, a bag or sim:WORLD.")
    ],
    to: Annotated[Path, typer.Option(help="Folder for the recording.")],
    columns: Annotated[
        str,
        typer.Option(
            help="What the numbers of a line are: angle, range, x, y, heading, t, left, right, dleft, dright or -."
        ),
    ] = "",
    angle_unit: Annotated[str, typer.Option(help="Unit of angles: deg, rad, grad, or degrees per count.")] = "",
    range_unit: Annotated[str, typer.Option(help="Unit of distances: cm, mm, m, in, ft, or us (echo time).")] = "",
    position_unit: Annotated[str, typer.Option(help="Unit of places: cm, mm, m, in or ft.")] = "",
    heading_unit: Annotated[str, typer.Option(help="Unit of headings: deg, rad or grad.")] = "",
    center: Annotated[float | None, typer.Option(help="Angle that looks straight ahead, such as 90.")] = None,
    clockwise: Annotated[bool, typer.Option("--clockwise", help="Angles grow clockwise seen from above.")] = False,
    heading: Annotated[
        str, typer.Option(help="How headings grow: counter-clockwise or clockwise from x, or compass.")
    ] = "",
    no_echo: Annotated[list[float] | None, typer.Option(help="A reading that means no echo; repeatable.")] = None,
    place: Annotated[
        list[str] | None, typer.Option(help='"x y heading" of the robot, for all, each file or sweep.')
    ] = None,
    places: Annotated[Path | None, typer.Option(help="File of such places, one a line.")] = None,
    angles: Annotated[str, typer.Option(help='"first step" of the angles, for logs of plain distances.')] = "",
    tick: Annotated[str, typer.Option(help="Way of a wheel from count to count, such as 5mm.")] = "",
    wheel_base: Annotated[str, typer.Option(help="Distance between the wheels, such as 15cm.")] = "",
    period: Annotated[float, typer.Option(help="Seconds from ping to ping where the log has no times.")] = 0.06,
    decimal_comma: Annotated[bool, typer.Option("--decimal-comma", help="Numbers have a decimal comma.")] = False,
    rig: Annotated[str, typer.Option(help="A built-in rig or a rig.toml; else HC-SR04.")] = "",
    yes: Annotated[bool, typer.Option("--yes", help="Accept what was guessed.")] = False,
) -> None:
    """Convert a text log into a recording, and show first how it was understood.

    Example: echoplan convert log.txt --to rec/ --center 90
    """
    from echoplan.io.text_logs import (  # noqa: PLC0415 - --help must not wait for NumPy
        LogOptions,
        parse_angles,
        parse_heading,
        parse_length,
        read_places,
    )
    from echoplan.sources import find_rig  # noqa: PLC0415

    options = LogOptions(
        columns=columns,
        angle_unit=angle_unit,
        range_unit=range_unit,
        position_unit=position_unit,
        heading_unit=heading_unit,
        center=center,
        clockwise=clockwise,
        heading=parse_heading(heading),
        no_echo=tuple(no_echo) if no_echo else None,
        places=read_places(place or (), places),
        angles=parse_angles(angles),
        tick=parse_length(tick, option="--tick"),
        wheel_base=parse_length(wheel_base, option="--wheel-base"),
        period=period,
        decimal_comma=decimal_comma,
        rig=find_rig(rig) if rig else None,
    )
    convert = next(convert for accepts, convert in _CONVERSIONS if accepts(sources))
    convert(sources, to, options=options, yes=yes)


def _is_recording(sources: "Sequence[str]") -> bool:
    """Whether ``open_source`` opens what is to be converted."""
    if len(sources) > 1:
        return False
    path = Path(sources[0])
    is_folder = any((path / name).is_file() for name in ("pings.csv", "metadata.yaml"))
    return is_folder or sources[0].startswith("sim:") or path.suffix in _SOURCE_SUFFIXES


def _convert_recording(sources: "Sequence[str]", to: Path, *, options: "LogOptions", yes: bool) -> None:
    """Write what ``open_source`` opens as a recording; options of logs and confirmations have no meaning for it."""
    from echoplan.errors import InputError  # noqa: PLC0415
    from echoplan.io import write_recording  # noqa: PLC0415
    from echoplan.io.text_logs import LogOptions  # noqa: PLC0415
    from echoplan.sources import open_source  # noqa: PLC0415

    if options != LogOptions() or yes:
        problem = "it is no text log, and options that say how to read one have no meaning for it"
        raise InputError(sources[0], problem, remedy="leave them out")
    write_recording(to, Progressing(open_source(sources[0]), "converting"))
    report_files(to, ["pings.csv", "rig.toml"])


def _convert_log(sources: "Sequence[str]", to: Path, *, options: "LogOptions", yes: bool) -> None:
    """Show how text logs were understood, let guesses be confirmed, and write the recording."""
    from echoplan.io import check_folder, write_recording  # noqa: PLC0415
    from echoplan.io.text_logs import read_text_log  # noqa: PLC0415

    check_folder(to, ["pings.csv", "rig.toml"])
    log = read_text_log(_log_files(sources), options)
    _show(log)
    _confirm(log, sources[0], yes=yes)
    write_recording(to, log.recording)
    report_files(to, ["pings.csv", "rig.toml"])


def _log_files(sources: "Sequence[str]") -> list[Path]:
    """Return the files that were named, or those of a folder: its logs in the order of their numbers."""
    from echoplan.errors import InputError  # noqa: PLC0415

    path = Path(sources[0])
    if len(sources) > 1 or not path.is_dir():
        return [Path(source) for source in sources]
    logs = [each for each in path.iterdir() if each.suffix in _LOG_SUFFIXES]
    if not logs:
        remedy = f"name a recording's folder, or one with logs ({', '.join(_LOG_SUFFIXES)})"
        raise InputError(path, "there is neither pings.csv nor a text log in it", remedy=remedy)
    # loc_2 before loc_10: words and numbers alternate.
    return sorted(
        logs, key=lambda each: [int(word) if word.isdecimal() else word for word in re.split(r"(\d+)", each.name)]
    )


def _show(log: "TextLog") -> None:
    """Print what was understood, the lines that were skipped, and the first sweep."""
    from echoplan.cli.sketch import sketch_sweep  # noqa: PLC0415

    rows = [(fact.subject, fact.value, str(fact.origin)) for fact in log.facts]
    widths = [max(len(row[place]) for row in rows) for place in range(2)]
    put(f"How {log.recording.name} was understood")
    for subject, value, origin in rows:
        put(f"  {subject:<{widths[0]}}  {value:<{widths[1]}}  {origin}")
    readings = sum(len(sweep) for sweep in log.recording.sweeps)
    put(f"{readings} pings in {len(log.recording)} sweeps; {len(log.skipped)} of {log.lines} lines skipped")
    for line in log.skipped[:_SHOWN]:
        put(f"  {line.place}: {line.text!r}: {line.reason}")
    put()
    put(sketch_sweep(log.recording.sweeps[0], log.recording.rig))


def _confirm(log: "TextLog", source: str, *, yes: bool) -> None:
    """Ask on a terminal whether the guesses are right; elsewhere refuse them with the options that state them."""
    from echoplan.errors import InputError  # noqa: PLC0415

    if yes or not log.guesses:
        return
    guessed = ", ".join(f"{fact.subject}: {fact.value}" for fact in log.guesses)
    options = " ".join(fact.option for fact in log.guesses)
    if sys.stdin.isatty() and sys.stdout.isatty() and typer.confirm(f"Guessed: {guessed}. Is that right?"):
        return
    remedy = f"if that is right, add {options} (or --yes); nothing was written"
    raise InputError(source, f"guessed, not written in it: {guessed}", remedy=remedy)


# Which conversion does what: the first that accepts the sources.
_CONVERSIONS: tuple[tuple[Callable[["Sequence[str]"], bool], Callable[..., None]], ...] = (
    (_is_recording, _convert_recording),
    (bool, _convert_log),
)
