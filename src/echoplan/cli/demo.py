"""``echoplan demo``: a flat from the echoes to the map, or the room of the paper beside the paper's own figures."""

from dataclasses import replace
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.results import say_what_was_found
from echoplan.cli.terminal import Progressing, TerminalProgress, put, report_files, show

if TYPE_CHECKING:
    from echoplan.evaluation import Evaluation, Match, Matching
    from echoplan.mapping import MapResult
    from echoplan.model import Table
    from echoplan.simulation import Simulation
    from echoplan.viewer import Picture

__all__ = ["run"]

_FLAT, _PAPER_ROOM, _RIG = "two-room-flat", "paper-room", "rotary-array"

_FLAT_INTRODUCTION = (
    "A robot with four ultrasonic sensors on a servo drives through a furnished flat of two rooms and stops at 25 "
    "stations. Flat and sensors are simulated, with 2 % of the echoes missing and 2 % false. The map is made by joint, "
    "from the echoes and the poses of the robot alone; the true flat is drawn dashed."
)
_PAPER_INTRODUCTION = (
    (
        "A robot with four ultrasonic sensors on a servo stops at ten stations A to J in a room with eight flat faces, "
        "a cylinder and a corner. Room and sensors are simulated, with 2 % of the echoes missing and 2 % false. "
        "The map is made by joint, which explains all stations at once. The figures of the paper are drawn by its own "
        "method, mdp-fuzzy; rcd is the conventional one."
    ),
    (
        "Table 5 of the paper was measured in a real room of the same kind: the figures beside each other are of the "
        "same sort, but not of the same walls."
    ),
)


def run(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for the recording, the map and the pictures.")
    ] = Path("echoplan-demo"),
    seed: Annotated[int, typer.Option(help="Seed of all noise.")] = 0,
    paper: Annotated[bool, typer.Option("--paper", help="Map the paper's room: its figures and Table 5.")] = False,
) -> None:
    """Simulate a furnished flat of two rooms, map it, and compare the map with the truth.

    Example: echoplan demo --seed 1
    """
    from echoplan.io import check_folder  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.mapping import PRIOR, RESULTS  # noqa: PLC0415

    check_folder(out, [*RESULTS, PRIOR])
    (_map_paper_room if paper else _map_flat)(out, seed)
    put(f"Now open {out / 'report.html'} in a browser.")


def _map_flat(out: Path, seed: int) -> None:
    from echoplan.viewer import Text, map_picture  # noqa: PLC0415

    put(f"{_FLAT_INTRODUCTION}\n")
    simulation = _simulated(_FLAT, seed)
    (result,) = _mapped(simulation, "joint")
    evaluation = result.evaluate()
    table = _score_table(evaluation)
    say_what_was_found(result.plan)
    put()
    show(table)
    _say_lengths(evaluation)
    introduction = Text(title="What this is", paragraphs=(_FLAT_INTRODUCTION,))
    result = replace(result, title="A flat of two rooms", sections=(introduction, table))
    _write(out, result, simulation, (map_picture(result.plan),))


def _map_paper_room(out: Path, seed: int) -> None:
    from echoplan.evaluation import table5  # noqa: PLC0415
    from echoplan.viewer import Text, map_picture  # noqa: PLC0415

    simulation = _simulated(_PAPER_ROOM, seed)
    results = _mapped(simulation, "joint", "mdp-fuzzy", "rcd")
    result, figures = results[0], _paper_figures(results[1])
    table = table5({each.feature_map.method: each.evaluate() for each in results})
    say_what_was_found(result.plan)
    put()
    show(table)
    introduction = Text(title="What this is", paragraphs=_PAPER_INTRODUCTION)
    result = replace(result, title="The room of the paper", sections=(introduction, table, *figures))
    _write(out, result, simulation, (map_picture(result.plan), *figures))


def _simulated(world: str, seed: int) -> "Simulation":
    from echoplan.io import builtin_rig, builtin_route, builtin_world  # noqa: PLC0415
    from echoplan.simulation import Simulation, SimulationSettings  # noqa: PLC0415

    return Simulation(
        world=builtin_world(world),
        rig=builtin_rig(_RIG),
        route=builtin_route(world),
        settings=SimulationSettings(dropout=0.02, stray=0.02),
        seed=seed,
    )


def _mapped(simulation: "Simulation", *methods: str) -> "list[MapResult]":
    """Simulate once, and map with each method."""
    from echoplan.mapping import map_source  # noqa: PLC0415
    from echoplan.model import Recording  # noqa: PLC0415

    recording = Recording(
        name=f"sim:{simulation.world.name},rig={_RIG},seed={simulation.seed}",
        rig=simulation.rig,
        sweeps=tuple(Progressing(simulation, "simulating")),
    )
    results = [
        map_source(recording, method=method, truth=simulation.truth, progress=TerminalProgress()) for method in methods
    ]
    return [
        replace(
            each,
            run=replace(each.run, seed=simulation.seed),
            settings={"simulation": simulation.settings, **each.settings},
        )
        for each in results
    ]


def _score_table(evaluation: "Evaluation") -> "Table":
    """Compare the map with the truth, a row for each kind of object."""
    from echoplan.model import Table  # noqa: PLC0415

    plan = evaluation.floor_plan
    found = {f"{kind}s": (each.tally, _mean_error(each)) for kind, each in evaluation.matches.by_class.items()}
    found["openings (width)"] = (plan.openings, plan.opening_widths.mean)
    return Table(
        title="The map compared with the true flat",
        columns=("objects", "true", "found", "false or duplicate", "mean error (mm)"),
        rows=tuple(
            (
                name,
                str(tally.wanted),
                str(tally.found),
                str(tally.estimates - tally.right),
                "-" if isnan(error) else f"{1000 * error:.1f}",
            )
            for name, (tally, error) in found.items()
        ),
    )


def _mean_error(matching: "Matching[Match]") -> float:
    """Return the mean distance of the right estimates from their true objects [m]; nan without any."""
    distances = [match.distance for match in matching.right]
    return sum(distances) / len(distances) if distances else nan


def _say_lengths(evaluation: "Evaluation") -> None:
    from echoplan.evaluation import MatchingSettings  # noqa: PLC0415
    from echoplan.viewer.wording import plural  # noqa: PLC0415

    lengths, least = evaluation.floor_plan.lengths, MatchingSettings().min_stations
    put(
        f"True objects are those that at least {plural(least, 'station')} can detect; the map may show more. "
        f"Of the length of the true walls {100 * lengths.recall:.1f} % is drawn; of the length of the drawn walls "
        f"{100 * lengths.precision:.1f} % is right. The path crosses {plural(lengths.walked_through, 'drawn wall')}."
    )
    put()


def _paper_figures(result: "MapResult") -> "tuple[Picture, ...]":
    from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper  # noqa: PLC0415
    from echoplan.viewer import paper_pictures, sweep_stages  # noqa: PLC0415

    mapper = MdpFuzzyMapper(result.rig)
    for sweep in result.sweeps:
        mapper.add(sweep)
    return paper_pictures([sweep_stages(mapper, sweep) for sweep in result.sweeps], result.plan)


def _write(out: Path, result: "MapResult", simulation: "Simulation", pictures: "tuple[Picture, ...]") -> None:
    from echoplan.io import write_bytes, write_recording, write_truth  # noqa: PLC0415
    from echoplan.mapping import PICTURES, PRIOR, RESULTS, results_folder  # noqa: PLC0415

    with results_folder(out, result) as draft:
        write_recording(draft / "recording", simulation)
        write_truth(draft / "recording" / "truth.json", simulation.truth)
        for picture in pictures:
            write_bytes(draft / PICTURES / f"{picture.name}.png", picture.png)
    report_files(out / "recording", ["pings.csv", "rig.toml", "truth.json"])
    report_files(out / PICTURES, [f"{picture.name}.png" for picture in pictures])
    report_files(out, RESULTS if result.known is None else [*RESULTS, PRIOR])
