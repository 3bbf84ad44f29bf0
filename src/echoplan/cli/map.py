"""``echoplan map``: sweeps in, a map with its pictures and its settings out."""

from pathlib import Path
from typing import Annotated

import typer

from echoplan.cli.terminal import Progressing, report_files

__all__ = ["run"]


def run(
    source: Annotated[str, typer.Argument(help="A recording's folder, or sim:WORLD.")],
    out: Annotated[Path, typer.Option(help="Folder for the map.")],
    method: Annotated[str, typer.Option(help="How to map: mdp-fuzzy or rcd.")] = "mdp-fuzzy",
    config: Annotated[Path | None, typer.Option(help="Settings of the method, in a [method] table.")] = None,
) -> None:
    """Map a recording: map.json, map.svg, report.html and the settings of the run.

    Example: echoplan map rec/ --out map/
    """
    from echoplan.config import Run, read_config, write_run  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import write_map  # noqa: PLC0415
    from echoplan.methods import find_method, map_sweeps  # noqa: PLC0415
    from echoplan.sources import open_source  # noqa: PLC0415

    chosen = find_method(method)
    sections = {"method": chosen.settings_type}
    settings = read_config(config, sections)["method"] if config else chosen.settings_type()
    opened = open_source(source)
    feature_map = map_sweeps(chosen.build(opened.rig, settings), Progressing(opened, "mapping"))
    write_map(out / "map.json", feature_map)
    write_run(out / "run.toml", Run(source=source, method=method), {"method": settings})
    report_files(out, ["map.json", "run.toml"])
