"""``echoplan evaluate``: a map against the truth."""

from pathlib import Path
from typing import Annotated

import typer

from echoplan.cli.terminal import put, show

__all__ = ["MinHeard", "MinStations", "replaces_min_heard", "run"]

MinStations = Annotated[
    int,
    typer.Option(
        min=1, help="Least number of stations that must be able to detect an object for it to count for recall."
    ),
]
MinHeard = Annotated[int | None, typer.Option(min=1, hidden=True, help="Former name of --min-stations.")]


def run(
    feature_map: Annotated[Path, typer.Argument(metavar="MAP", help="A map.json, or the folder that holds it.")],
    truth: Annotated[Path, typer.Argument(help="A truth.json, the folder that holds it, or a world.toml.")],
    min_stations: MinStations = 2,
    min_heard: MinHeard = None,
    reach: Annotated[float, typer.Option(help="Stations farther from an opening do not face it [m].", min=0.1)] = 4.0,
    as_json: Annotated[bool, typer.Option("--json", help="Print all numbers as JSON.")] = False,
) -> None:
    """Compare a map with the truth: Table 5 of the paper, recall and precision, classes, uncertainties, openings.

    Example: echoplan evaluate map/ rec/truth.json
    """
    from echoplan.evaluation import (  # noqa: PLC0415 - --help must not wait for NumPy
        EvaluationSettings,
        MatchingSettings,
        evaluate,
        evaluation_document,
        evaluation_tables,
    )
    from echoplan.io import read_map, read_truth  # noqa: PLC0415
    from echoplan.io.text import format_json  # noqa: PLC0415

    drawn, true = read_map(feature_map), read_truth(truth)
    min_stations = replaces_min_heard(min_stations, min_heard)
    matching = MatchingSettings(min_stations=min_stations, opening_reach=reach)
    evaluation = evaluate(drawn, true, EvaluationSettings(matching=matching))
    if as_json:
        put(format_json(evaluation_document(evaluation)))
        return
    for table in evaluation_tables(evaluation):
        show(table)
    if len(true.poses) and len(drawn.poses) and len(true.poses) != len(drawn.poses):
        put(f"Poses are not compared: the map has {len(drawn.poses)}, the truth {len(true.poses)}.")


def replaces_min_heard(min_stations: int, min_heard: int | None) -> int:
    """Return the value of ``--min-stations``, or that of its former name, with a warning on standard error."""
    if min_heard is None:
        return min_stations
    typer.echo("echoplan: --min-heard is now called --min-stations; the old name will go in a later version", err=True)
    return min_heard
