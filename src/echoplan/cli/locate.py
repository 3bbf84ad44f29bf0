"""``echoplan locate``: the poses of a recording in a map that was made before."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

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
    from echoplan.arrays import FloatArray

__all__ = ["run"]


def run(
    source: Annotated[str, typer.Argument(help=SOURCE_HELP)],
    feature_map: Annotated[Path, typer.Option("--map", "-m", help="A map.json, or the folder that holds it.")],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the poses.")],
    start: Annotated[
        str,
        typer.Option(
            help="About where the recording begins: X,Y,YAW in the frame of the map, in m and rad.",
            show_default="anywhere",
        ),
    ] = "",
    export: Annotated[str, typer.Option(help="mcap: a bag for RViz and Foxglove.", show_default="none")] = "",
    topic: TopicOption = None,
    odom: OdomOption = None,
    field: FieldOption = None,
    mount: MountOption = None,
) -> None:
    """Locate a recording in a map: trajectory.tum, localisation.json and located.svg.

    The poses of the recording only have to be right from sweep to sweep, as those of odometry are.

    Example: echoplan locate rec/ --map map/ --out located/
    """
    from echoplan.errors import InputError  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import check_folder  # noqa: PLC0415
    from echoplan.mapping import LOCATED, locate_source, located_formats  # noqa: PLC0415
    from echoplan.sources import open_source  # noqa: PLC0415
    from echoplan.viewer import localisation_lines  # noqa: PLC0415

    first = _pose(start) if start else None
    beside = feature_map.parent if feature_map.is_file() else feature_map
    if out.resolve() in {beside.resolve(), Path(source).resolve()}:
        raise InputError("--out", f"{out} holds the map or the recording", remedy="name another folder")
    names = tuple(f"located{each.suffix}" for each in located_formats(export))
    check_folder(out, [*LOCATED, *names])
    opened = open_source(source, bag=bag_options(topic, odom, field, mount))
    put_notes(opened)
    result = locate_source(opened, feature_map, start=first, name=source, progress=TerminalProgress())
    for line in localisation_lines(result.localisation, result.quality):
        put(line)
    report_files(out, result.save(out, export=export))


def _pose(text: str) -> "FloatArray":
    """Read a pose as it is typed: three numbers, separated by commas."""
    import numpy as np  # noqa: PLC0415

    from echoplan.errors import InputError  # noqa: PLC0415

    try:
        pose = np.array([float(word) for word in text.split(",")])
    except ValueError:
        pose = np.zeros(0)
    if pose.shape != (3,) or not np.isfinite(pose).all():
        remedy = "write for example --start 1.2,0.5,1.57 [m, m, rad]"
        raise InputError("--start", f"{text!r} is not X,Y,YAW", remedy=remedy)
    return pose
