"""``echoplan map``: sweeps in, a map with its pictures and its settings out."""

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.configuration import method_and_settings
from echoplan.cli.results import say_what_was_found
from echoplan.cli.source_options import (
    SOURCE_HELP,
    FieldOption,
    MountOption,
    OdomOption,
    TopicOption,
    bag_options,
    put_notes,
)
from echoplan.cli.terminal import TerminalProgress, put, report_files

if TYPE_CHECKING:
    from pydantic import BaseModel

    from echoplan.model import FeatureMap
    from echoplan.viewer import Definitions

__all__ = ["run"]


def run(
    source: Annotated[list[str], typer.Argument(help=f"{SOURCE_HELP} Several of one place make one map.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the map.")],
    method: Annotated[
        str | None,
        typer.Option(help="Mapping method: joint, or another one that echoplan compare lists.", show_default="joint"),
    ] = None,
    poses: Annotated[
        str | None, typer.Option(help="How joint treats recorded poses: trust, correct, or auto.", show_default="auto")
    ] = None,
    export: Annotated[
        str,
        typer.Option(
            help="Further formats, separated by commas: nav2, dxf, geojson, pdf, png, mcap, or all.",
            show_default="none",
        ),
    ] = "",
    start: Annotated[
        Path | None,
        typer.Option(
            help="Folder of an earlier map of the place, from which this one goes on; what has changed is reported.",
            show_default="none",
        ),
    ] = None,
    config: Annotated[Path | None, typer.Option(help="Settings of the method, in a [method] table.")] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with status 2 if the map failed.")] = False,
    why: Annotated[bool, typer.Option("--why", help="Print why each landmark is in the map or not (joint).")] = False,
    topic: TopicOption = None,
    odom: OdomOption = None,
    field: FieldOption = None,
    mount: MountOption = None,
) -> None:
    """Map a recording, or several of one place: map.json, map.svg, report.html and the settings of the run.

    Example: echoplan map rec/ --out map/ (or, for one map of two: echoplan map monday/ tuesday/ --out map/)
    """
    from echoplan.io import check_folder  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.mapping import PRIOR, RESULTS, check_options, export_formats, map_source  # noqa: PLC0415
    from echoplan.sources import open_source  # noqa: PLC0415

    settings, method = _settings(config, method=method, poses=poses)
    exports = export_formats(export.split(",") if export else ())
    check_folder(out, [*RESULTS, PRIOR, *(name for each in exports for name in each.files)])
    # Opening a bag reads it.
    check_options(method, settings, recordings=len(source), start=start)
    opened = [open_source(each, bag=bag_options(topic, odom, field, mount)) for each in source]
    for each in opened:
        put_notes(each)
    result = map_source(
        opened, name=" ".join(source), method=method, settings=settings, start=start, progress=TerminalProgress()
    )
    say_what_was_found(result.plan)
    if why:
        _say_why(result.decisions)
    report_files(out, result.save(out, export=[each.name for each in exports]))
    _warn_if_failed(result.feature_map, strict=strict)


def _settings(config: Path | None, *, method: str | None, poses: str | None) -> "tuple[BaseModel, str]":
    """Return the settings and the name of the method: options first, then the file, then the defaults."""
    from echoplan.errors import InputError, UnknownNameError  # noqa: PLC0415

    method, settings = method_and_settings(config, method)
    if poses is None:
        return settings, method
    if "poses" not in type(settings).model_fields:
        raise InputError("--poses", f"the method {method} cannot correct poses", remedy="use --method joint")
    modes = ("auto", "correct", "trust")
    if poses not in modes:
        raise UnknownNameError("value of --poses", poses, known=modes)
    return type(settings)(**{**settings.model_dump(), "poses": poses}), method


def _say_why(decisions: "Definitions") -> None:
    put()
    for name, text in decisions.items:
        put(f"{name}: {text}")
    if not decisions.items:
        put("No decision about a landmark was recorded. Only joint records when it adds, changes or removes one.")


def _warn_if_failed(feature_map: "FeatureMap", *, strict: bool) -> None:
    """Report a failed map on standard error; exit with status 2 if ``strict``."""
    quality = feature_map.quality
    if quality is not None and quality.verdict == "failed":
        sys.stderr.write(f"echoplan: the map failed: {quality.reasons[0]}\n")
        if strict:
            raise typer.Exit(2)
