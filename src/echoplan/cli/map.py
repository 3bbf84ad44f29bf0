"""``echoplan map``: sweeps in, a map with its pictures and its settings out."""

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.results import RESULTS, Results, say_what_was_found, write_results
from echoplan.cli.terminal import Progressing, busy, put

if TYPE_CHECKING:
    from collections.abc import Iterable

    from pydantic import BaseModel

    from echoplan.methods import Mapper
    from echoplan.model import FeatureMap, Sweep
    from echoplan.viewer import Plan

__all__ = ["run"]


def run(
    source: Annotated[str, typer.Argument(help="A recording's folder, or sim:WORLD.")],
    out: Annotated[Path, typer.Option(help="Folder for the map.")],
    method: Annotated[
        str | None,
        typer.Option(help="How to map: joint, or one of those that echoplan compare knows.", show_default="joint"),
    ] = None,
    poses: Annotated[str | None, typer.Option(help="Of joint: trust, correct, or auto.", show_default="auto")] = None,
    config: Annotated[Path | None, typer.Option(help="Settings of the method, in a [method] table.")] = None,
) -> None:
    """Map a recording: map.json, map.svg, report.html and the settings of the run.

    Example: echoplan map rec/ --out map/
    """
    from echoplan.config import Run, method_of, read_config  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import check_folder  # noqa: PLC0415
    from echoplan.methods import find_method, grid_of, observations_of  # noqa: PLC0415
    from echoplan.sources import find_truth, open_source  # noqa: PLC0415
    from echoplan.viewer import EchoListener, Plan  # noqa: PLC0415

    method = method or (method_of(config) if config else None) or "joint"
    chosen = find_method(method)
    sections = {"method": chosen.settings_type}
    settings = read_config(config, sections)["method"] if config else chosen.settings_type()
    settings = settings if poses is None else _with_poses(settings, poses, method)
    check_folder(out, RESULTS)
    opened = open_source(source)
    mapper, listener = chosen.build(opened.rig, settings), EchoListener(opened.rig)
    plan = Plan(
        feature_map=_map_of(mapper, listener.listen(Progressing(opened, "mapping"))),
        truth=find_truth(source, opened),
        heard=observations_of(mapper),
        echoes_xy=listener.points_xy,
    )
    _say(plan, source)
    results = Results(
        title=f"Map of {opened.name}",
        run=Run(source=source, method=method),
        settings={"method": settings},
        plan=plan,
        times=listener.times,
        grid=grid_of(mapper),
    )
    write_results(out, results)


def _say(plan: "Plan", source: str) -> None:
    say_what_was_found(plan)
    if plan.feature_map.is_empty:
        put(f"Nothing stood out; see what came of the pings: echoplan info {shlex.quote(source)}")


def _map_of(mapper: "Mapper", sweeps: "Iterable[Sweep]") -> "FeatureMap":
    for sweep in sweeps:
        mapper.add(sweep)
    with busy("putting the map together"):
        return mapper.result()


def _with_poses(settings: "BaseModel", poses: str, method: str) -> "BaseModel":
    from echoplan.errors import InputError, UnknownNameError  # noqa: PLC0415

    if "poses" not in type(settings).model_fields:
        raise InputError("--poses", f"the method {method} does as it does about poses", remedy="use --method joint")
    modes = ("auto", "correct", "trust")
    if poses not in modes:
        raise UnknownNameError("value of --poses", poses, known=modes)
    return type(settings)(**{**settings.model_dump(), "poses": poses})
