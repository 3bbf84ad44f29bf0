"""``echoplan map``: sweeps in, a map with its pictures and its settings out."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.configuration import settings_of
from echoplan.cli.results import RESULTS, Results, mapped, say_what_was_found, write_results
from echoplan.cli.source_options import (
    SOURCE_HELP,
    FieldOption,
    MountOption,
    OdomOption,
    TopicOption,
    bag_options,
    put_notes,
)
from echoplan.cli.terminal import Progressing, busy, put

if TYPE_CHECKING:
    from collections.abc import Sequence

    from pydantic import BaseModel

    from echoplan.model import FeatureMap, Source, Sweep
    from echoplan.viewer import Definitions

__all__ = ["run"]


def run(
    source: Annotated[str, typer.Argument(help=SOURCE_HELP)],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the map.")],
    method: Annotated[
        str | None,
        typer.Option(help="Mapping method: joint, or another one that echoplan compare lists.", show_default="joint"),
    ] = None,
    poses: Annotated[
        str | None, typer.Option(help="How joint treats recorded poses: trust, correct, or auto.", show_default="auto")
    ] = None,
    config: Annotated[Path | None, typer.Option(help="Settings of the method, in a [method] table.")] = None,
    strict: Annotated[bool, typer.Option("--strict", help="Exit with status 2 if the map failed.")] = False,
    why: Annotated[bool, typer.Option("--why", help="Print why each landmark is in the map or not (joint).")] = False,
    topic: TopicOption = None,
    odom: OdomOption = None,
    field: FieldOption = None,
    mount: MountOption = None,
) -> None:
    """Map a recording: map.json, map.svg, report.html and the settings of the run.

    Example: echoplan map rec/ --out map/
    """
    from echoplan.config import Run, method_of  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import check_folder  # noqa: PLC0415
    from echoplan.joint.trace import collect_events  # noqa: PLC0415
    from echoplan.methods import find_method, grid_of, observations_of  # noqa: PLC0415
    from echoplan.sources import conventions_of, find_truth, open_source  # noqa: PLC0415
    from echoplan.viewer import EchoListener, Plan, decisions_in_words  # noqa: PLC0415

    method = method or (method_of(config) if config else None) or "joint"
    chosen = find_method(method)
    settings = settings_of(config, "method", chosen.settings_type)
    settings = settings if poses is None else _with_poses(settings, poses, method)
    check_folder(out, RESULTS)
    opened = open_source(source, bag=bag_options(topic, odom, field, mount))
    put_notes(opened)
    recorded = tuple(Progressing(opened, "reading"))
    mapper, listener = chosen.build(opened.rig, settings), EchoListener(opened.rig)
    with collect_events() as events:
        found = mapped(mapper, recorded, listener.listen)
    plan = Plan(
        feature_map=_assessed(found, opened, recorded),
        truth=find_truth(source, opened),
        detections=observations_of(mapper),
        echoes_xy=listener.points_xy,
        conventions=conventions_of(opened),
    )
    say_what_was_found(plan)
    offset = (float(mapper.origin_xy[0]), float(mapper.origin_xy[1]))
    decisions = decisions_in_words([each.translated(offset) for each in events], plan.feature_map)
    if why:
        _say_why(decisions)
    results = Results(
        title=f"Map of {opened.name}",
        run=Run(source=source, method=method),
        settings={"method": settings},
        plan=plan,
        times=listener.times,
        sections=(decisions,) if decisions.items else (),
        grid=grid_of(mapper),
    )
    write_results(out, results)
    _warn_if_failed(plan.feature_map, strict=strict)


def _say_why(decisions: "Definitions") -> None:
    put()
    for name, text in decisions.items:
        put(f"{name}: {text}")
    if not decisions.items:
        put("This method records no decisions about landmarks; joint does.")


def _assessed(feature_map: "FeatureMap", source: "Source", sweeps: "Sequence[Sweep]") -> "FeatureMap":
    from echoplan.diagnosis import assess  # noqa: PLC0415
    from echoplan.sources import conventions_of  # noqa: PLC0415

    with busy("checking the map"):
        quality = assess(feature_map, source.rig, sweeps, conventions=conventions_of(source))
    return replace(feature_map, quality=quality)


def _warn_if_failed(feature_map: "FeatureMap", *, strict: bool) -> None:
    """Report a failed map on standard error; exit with status 2 if ``strict``."""
    quality = feature_map.quality
    if quality is not None and quality.verdict == "failed":
        sys.stderr.write(f"echoplan: the map failed: {quality.reasons[0]}\n")
        if strict:
            raise typer.Exit(2)


def _with_poses(settings: "BaseModel", poses: str, method: str) -> "BaseModel":
    from echoplan.errors import InputError, UnknownNameError  # noqa: PLC0415

    if "poses" not in type(settings).model_fields:
        raise InputError("--poses", f"the method {method} cannot correct poses", remedy="use --method joint")
    modes = ("auto", "correct", "trust")
    if poses not in modes:
        raise UnknownNameError("value of --poses", poses, known=modes)
    return type(settings)(**{**settings.model_dump(), "poses": poses})
