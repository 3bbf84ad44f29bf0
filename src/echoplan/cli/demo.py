"""``echoplan demo``: a flat from the echoes to the map, or the room of the paper beside the paper's own figures."""

from dataclasses import dataclass, replace
from math import isnan, nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.results import PICTURES, RESULTS, Results, mapped, results_folder, say_what_was_found
from echoplan.cli.terminal import Progressing, put, report_files, show

if TYPE_CHECKING:
    from collections.abc import Sequence

    from echoplan.arrays import FloatArray
    from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper
    from echoplan.evaluation import Evaluation, Match, Matching
    from echoplan.joint.mapper import JointMapper
    from echoplan.methods import Mapper
    from echoplan.model import FeatureMap, Sweep, Table
    from echoplan.simulation import Simulation
    from echoplan.viewer import Picture, Plan, Section

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

    check_folder(out, RESULTS)
    (_map_paper_room if paper else _map_flat)(out, seed)
    put(f"Now open {out / 'report.html'} in a browser.")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Drive:
    """A simulated drive with its sweeps, and the echoes as points."""

    world: str
    simulation: "Simulation"
    sweeps: "Sequence[Sweep]"
    echoes_xy: "FloatArray"
    times: "FloatArray"


def _map_flat(out: Path, seed: int) -> None:
    from echoplan.evaluation import evaluate  # noqa: PLC0415
    from echoplan.joint.mapper import JointMapper  # noqa: PLC0415
    from echoplan.viewer import Plan, Text, map_picture  # noqa: PLC0415

    put(f"{_FLAT_INTRODUCTION}\n")
    drive = _simulated(_FLAT, seed)
    mapper, truth = JointMapper(drive.simulation.rig), drive.simulation.truth
    plan = Plan(feature_map=_assessed(mapped(mapper, drive.sweeps), drive), truth=truth, echoes_xy=drive.echoes_xy)
    evaluation = evaluate(plan.feature_map, truth)
    table = _score_table(evaluation)
    say_what_was_found(plan)
    put()
    show(table)
    _say_lengths(evaluation)
    introduction = Text(title="What this is", paragraphs=(_FLAT_INTRODUCTION,))
    results = _results("A flat of two rooms", drive, mapper, plan, (introduction, table))
    _write(out, results, drive.simulation, (map_picture(plan),))


def _map_paper_room(out: Path, seed: int) -> None:
    from echoplan.classical.mdp_fuzzy import MdpFuzzyMapper  # noqa: PLC0415
    from echoplan.classical.rcd import RcdMapper  # noqa: PLC0415
    from echoplan.joint.mapper import JointMapper  # noqa: PLC0415
    from echoplan.viewer import Plan, Text, map_picture  # noqa: PLC0415

    drive = _simulated(_PAPER_ROOM, seed)
    rig = drive.simulation.rig
    joint, paper = JointMapper(rig), MdpFuzzyMapper(rig)
    mappers: dict[str, Mapper] = {"joint": joint, "mdp-fuzzy": paper, "rcd": RcdMapper(rig)}
    maps = {name: mapped(mapper, drive.sweeps) for name, mapper in mappers.items()}
    plan = Plan(feature_map=_assessed(maps["joint"], drive), truth=drive.simulation.truth, echoes_xy=drive.echoes_xy)
    figures = _paper_figures(paper, drive.sweeps, replace(plan, feature_map=maps["mdp-fuzzy"]))
    table = _table5(maps, drive.simulation)
    say_what_was_found(plan)
    put()
    show(table)
    introduction = Text(title="What this is", paragraphs=_PAPER_INTRODUCTION)
    results = _results("The room of the paper", drive, joint, plan, (introduction, table, *figures))
    _write(out, results, drive.simulation, (map_picture(plan), *figures))


def _simulated(world: str, seed: int) -> _Drive:
    from echoplan.io import builtin_rig, builtin_route, builtin_world  # noqa: PLC0415
    from echoplan.simulation import Simulation, SimulationSettings  # noqa: PLC0415
    from echoplan.viewer import EchoListener  # noqa: PLC0415

    simulation = Simulation(
        world=builtin_world(world),
        rig=builtin_rig(_RIG),
        route=builtin_route(world),
        settings=SimulationSettings(dropout=0.02, stray=0.02),
        seed=seed,
    )
    listener = EchoListener(simulation.rig)
    sweeps = list(listener.listen(Progressing(simulation, "simulating")))
    return _Drive(world=world, simulation=simulation, sweeps=sweeps, echoes_xy=listener.points_xy, times=listener.times)


def _results(
    title: str, drive: _Drive, mapper: "JointMapper", plan: "Plan", sections: "tuple[Section, ...]"
) -> Results:
    from echoplan.config import Run  # noqa: PLC0415

    seed = drive.simulation.seed
    return Results(
        title=title,
        run=Run(source=f"sim:{drive.world},rig={_RIG},seed={seed}", method="joint", seed=seed),
        settings={"simulation": drive.simulation.settings, "method": mapper.settings},
        plan=plan,
        times=drive.times,
        sections=sections,
    )


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
    from echoplan.viewer.wording import plural  # noqa: PLC0415

    lengths = evaluation.floor_plan.lengths
    put(
        f"Of the length of the true walls {100 * lengths.recall:.1f} % is drawn; of the length of the drawn walls "
        f"{100 * lengths.precision:.1f} % is right. The path crosses {plural(lengths.walked_through, 'drawn wall')}."
    )
    put()


def _assessed(feature_map: "FeatureMap", drive: _Drive) -> "FeatureMap":
    from echoplan.diagnosis import assess  # noqa: PLC0415

    return replace(feature_map, quality=assess(feature_map, drive.simulation.rig, drive.sweeps))


def _paper_figures(mapper: "MdpFuzzyMapper", sweeps: "Sequence[Sweep]", plan: "Plan") -> "tuple[Picture, ...]":
    from echoplan.viewer import paper_pictures, sweep_stages  # noqa: PLC0415

    return paper_pictures([sweep_stages(mapper, sweep) for sweep in sweeps], plan)


def _write(out: Path, results: Results, simulation: "Simulation", pictures: "tuple[Picture, ...]") -> None:
    from echoplan.io import write_bytes, write_recording, write_truth  # noqa: PLC0415

    with results_folder(out, results) as draft:
        write_recording(draft / "recording", simulation)
        write_truth(draft / "recording" / "truth.json", simulation.truth)
        for picture in pictures:
            write_bytes(draft / PICTURES / f"{picture.name}.png", picture.png)
    report_files(out / "recording", ["pings.csv", "rig.toml", "truth.json"])
    report_files(out / PICTURES, [f"{picture.name}.png" for picture in pictures])
    report_files(out, RESULTS)


def _table5(maps: "dict[str, FeatureMap]", simulation: "Simulation") -> "Table":
    from echoplan.evaluation import evaluate, table5  # noqa: PLC0415

    return table5({name: evaluate(found, simulation.truth) for name, found in maps.items()})
