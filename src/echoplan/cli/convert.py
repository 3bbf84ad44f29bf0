"""``echoplan convert``: a text log, a bag or a simulation becomes a recording, and a map a drawing or a grid."""

import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.source_options import FieldOption, MountOption, OdomOption, TopicOption, bag_options, put_notes
from echoplan.cli.terminal import Progressing, put, report_files

if TYPE_CHECKING:
    from echoplan.io.ros import BagOptions
    from echoplan.io.text_logs import LogOptions, TextLog

__all__ = ["run"]

_LOG_SUFFIXES = (".txt", ".csv", ".log", ".dat", ".tsv", ".asc")
# Under what ``--help`` lists the options of text logs.
_LOGS = "Text logs"
# Skipped lines that are shown, and how much of each.
_SHOWN, _LONGEST = 3, 60


def run(
    sources: Annotated[
        list[str],
        typer.Argument(
            help="A text log, or one for each place; a recording, a bag or sim:WORLD; or a map.json.",
            metavar="SOURCE...",
        ),
    ],
    to: Annotated[
        Path,
        typer.Option(
            help="Folder for a recording; for a map a file: .pdf, .png, .svg, .dxf, .geojson, .yaml (Nav2) or .mcap."
        ),
    ],
    columns: Annotated[
        str,
        typer.Option(
            help="What the numbers of a line are: angle, range, x, y, heading, t, left, right, dleft, dright or -.",
            rich_help_panel=_LOGS,
        ),
    ] = "",
    angle_unit: Annotated[
        str, typer.Option(help="Unit of angles: deg, rad, grad, or degrees per count.", rich_help_panel=_LOGS)
    ] = "",
    range_unit: Annotated[
        str, typer.Option(help="Unit of distances: cm, mm, m, in, ft, or us (echo time).", rich_help_panel=_LOGS)
    ] = "",
    position_unit: Annotated[
        str, typer.Option(help="Unit of places: cm, mm, m, in or ft.", rich_help_panel=_LOGS)
    ] = "",
    heading_unit: Annotated[str, typer.Option(help="Unit of headings: deg, rad or grad.", rich_help_panel=_LOGS)] = "",
    center: Annotated[
        float | None, typer.Option(help="Angle that looks straight ahead, such as 90.", rich_help_panel=_LOGS)
    ] = None,
    clockwise: Annotated[
        bool, typer.Option("--clockwise", help="Angles grow clockwise seen from above.", rich_help_panel=_LOGS)
    ] = False,
    heading: Annotated[
        str,
        typer.Option(
            help="How headings grow: counter-clockwise or clockwise from x, or compass.", rich_help_panel=_LOGS
        ),
    ] = "",
    no_echo: Annotated[
        list[float] | None, typer.Option(help="A reading that means no echo; repeatable.", rich_help_panel=_LOGS)
    ] = None,
    place: Annotated[
        list[str] | None,
        typer.Option(help='"x y heading" of the robot, for all, each file or sweep.', rich_help_panel=_LOGS),
    ] = None,
    places: Annotated[Path | None, typer.Option(help="File of such places, one a line.", rich_help_panel=_LOGS)] = None,
    angles: Annotated[
        str, typer.Option(help='"first step" of the angles, for logs of plain distances.', rich_help_panel=_LOGS)
    ] = "",
    tick: Annotated[
        str, typer.Option(help="Way of a wheel from count to count, such as 5mm.", rich_help_panel=_LOGS)
    ] = "",
    wheel_base: Annotated[
        str, typer.Option(help="Distance between the wheels, such as 15cm.", rich_help_panel=_LOGS)
    ] = "",
    period: Annotated[
        float, typer.Option(help="Seconds from ping to ping where the log has no times.", rich_help_panel=_LOGS)
    ] = 0.06,
    decimal_comma: Annotated[
        bool, typer.Option("--decimal-comma", help="Numbers have a decimal comma.", rich_help_panel=_LOGS)
    ] = False,
    rig: Annotated[str, typer.Option(help="A built-in rig or a rig.toml; else HC-SR04.", rich_help_panel=_LOGS)] = "",
    yes: Annotated[bool, typer.Option("--yes", help="Accept what was guessed.", rich_help_panel=_LOGS)] = False,
    topic: TopicOption = None,
    odom: OdomOption = None,
    field: FieldOption = None,
    mount: MountOption = None,
) -> None:
    """Convert a text log or a bag into a recording, or a map into what other software reads.

    How a text log was understood is shown before anything is written.

    Examples: echoplan convert log.txt --to rec/ --center 90, echoplan convert map/ --to plan.pdf
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
    convert(_Request(sources=sources, to=to, log=options, yes=yes, bag=bag_options(topic, odom, field, mount)))


@dataclass(frozen=True, slots=True, kw_only=True)
class _Request:
    """What is to be converted, into what, and how to read it."""

    sources: "Sequence[str]"
    to: Path
    log: "LogOptions"
    yes: bool
    bag: "BagOptions | None"

    def check(self, *, is_log: bool, is_bag: bool) -> None:
        """Refuse options that have no meaning for what is to be converted."""
        from echoplan.errors import InputError  # noqa: PLC0415
        from echoplan.io.text_logs import LogOptions  # noqa: PLC0415

        if not is_log and (self.log != LogOptions() or self.yes):
            problem = "it is no text log, and options that say how to read one have no meaning for it"
            raise InputError(self.sources[0], problem, remedy="leave them out")
        if not is_bag and self.bag is not None:
            remedy = "leave out --topic, --odom, --field and --mount"
            raise InputError(self.sources[0], "it is no ROS bag", remedy=remedy)


def _is_map(sources: "Sequence[str]") -> bool:
    """Whether a map is to be converted: a JSON file, or a folder of results."""
    path = Path(sources[0])
    return len(sources) == 1 and (path.suffix == ".json" or (path / "map.json").is_file())


def _convert_map(request: _Request) -> None:
    """Write a map in the format that the suffix of the target names."""
    from echoplan.io import read_grid, read_map, read_trajectory  # noqa: PLC0415
    from echoplan.io.files import inside  # noqa: PLC0415
    from echoplan.mapping import Exportable, export_map  # noqa: PLC0415
    from echoplan.viewer import Plan  # noqa: PLC0415

    request.check(is_log=False, is_bag=False)
    path = inside(Path(request.sources[0]), "map.json")
    plan = Plan(feature_map=read_map(path))
    # Of a folder of results, the other files belong to the map.
    trajectory, grid = path.with_name("trajectory.tum"), path.with_name("map.yaml")
    if path.name != "map.json":
        content = Exportable(plan=plan, name=path.stem)
    else:
        content = Exportable(
            plan=plan,
            name=path.resolve().parent.name,
            stamps_ns=read_trajectory(trajectory)[0] if trajectory.is_file() else None,
            grid=read_grid(grid) if grid.is_file() else None,
        )
    if content.stamps_ns is None and request.to.suffix.lower() == ".mcap":
        put("Note: the times of the poses are unknown; they are written a second apart, from 0 on.")
    written = export_map(request.to, content)
    report_files(request.to.parent, written)


def _is_recording(sources: "Sequence[str]") -> bool:
    """Whether ``open_source`` opens what is to be converted."""
    from echoplan.io.ros import is_bag  # noqa: PLC0415

    if len(sources) > 1:
        return False
    path = Path(sources[0])
    return sources[0].startswith("sim:") or (path / "pings.csv").is_file() or is_bag(path)


def _convert_recording(request: _Request) -> None:
    """Write what ``open_source`` opens as a recording."""
    from echoplan.io import write_recording  # noqa: PLC0415
    from echoplan.sources import open_source  # noqa: PLC0415

    request.check(is_log=False, is_bag=True)
    opened = open_source(request.sources[0], bag=request.bag)
    put_notes(opened)
    write_recording(request.to, Progressing(opened, "converting"))
    report_files(request.to, ["pings.csv", "rig.toml"])


def _convert_log(request: _Request) -> None:
    """Show how text logs were understood, let guesses be confirmed, and write the recording."""
    from echoplan.io import check_folder, write_recording  # noqa: PLC0415
    from echoplan.io.text_logs import read_text_log  # noqa: PLC0415

    request.check(is_log=True, is_bag=False)
    check_folder(request.to, ["pings.csv", "rig.toml"])
    log = read_text_log(_log_files(request.sources), request.log)
    _show(log)
    _confirm(log, request.sources[0], yes=request.yes)
    write_recording(request.to, log.recording)
    report_files(request.to, ["pings.csv", "rig.toml"])


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
        text = line.text if len(line.text) <= _LONGEST else f"{line.text[:_LONGEST]}..."
        put(f"  {line.place}: {text!r}: {line.reason}")
    put()
    put(sketch_sweep(log.recording.sweeps[0], log.recording.rig))


def _confirm(log: "TextLog", source: str, *, yes: bool) -> None:
    """Ask on a terminal whether the guesses are right; elsewhere refuse them with the options that state them."""
    from echoplan.errors import InputError  # noqa: PLC0415

    if yes or not log.guesses:
        return
    guessed = ", ".join(f"{fact.subject}: {fact.value}" for fact in log.guesses)
    options = " ".join(fact.option for fact in log.guesses if fact.option != "--yes")
    if sys.stdin.isatty() and sys.stdout.isatty() and typer.confirm(f"Guessed: {guessed}. Is that right?"):
        return
    remedy = f"if that is right, add {f'{options} (or --yes)' if options else '--yes'}; nothing was written"
    raise InputError(source, f"guessed, not written in it: {guessed}", remedy=remedy)


# Which conversion does what: the first that accepts the sources.
_CONVERSIONS: tuple[tuple[Callable[["Sequence[str]"], bool], Callable[[_Request], None]], ...] = (
    (_is_map, _convert_map),
    (_is_recording, _convert_recording),
    (bool, _convert_log),
)
