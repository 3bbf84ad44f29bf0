"""``echoplan demo``: the paper's room from the echoes to the map, beside the paper's own figures."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.results import RESULTS, Results, say_what_was_found, write_results
from echoplan.cli.terminal import Progressing, put, report_files, show, tracked

if TYPE_CHECKING:
    from collections.abc import Sequence

    from echoplan.methods import Mapper
    from echoplan.methods.mdp_fuzzy import MdpFuzzyMapper
    from echoplan.model import FeatureMap, Sweep, Table
    from echoplan.simulation import Simulation
    from echoplan.viewer import Picture, Plan

__all__ = ["run"]

_WORLD, _RIG = "paper-room", "rotary-array"

_INTRODUCTION = (
    (
        "A robot with four ultrasonic sensors on a servo stops at ten stations A to J in a room with eight flat faces, "
        "a cylinder and a corner. Room and sensors are simulated, with 2 % of the echoes missing and 2 % astray. "
        "The map is made by joint, which explains all stations at once. The figures of the paper are drawn by its own "
        "method, mdp-fuzzy; rcd is the conventional one."
    ),
    (
        "Table 5 of the paper was measured in a real room of the same kind: the figures beside each other are of the "
        "same sort, but not of the same walls."
    ),
)


def run(
    out: Annotated[Path, typer.Option(help="Folder for the recording, the map and the pictures.")] = Path(
        "echoplan-demo"
    ),
    seed: Annotated[int, typer.Option(help="Seed of all noise.")] = 0,
) -> None:
    """Simulate the paper's room, map it by three methods, and draw the figures of the paper.

    Example: echoplan demo --seed 1
    """
    from echoplan.config import Run  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import check_folder  # noqa: PLC0415
    from echoplan.methods.joint import JointMapper  # noqa: PLC0415
    from echoplan.methods.mdp_fuzzy import MdpFuzzyMapper  # noqa: PLC0415
    from echoplan.methods.rcd import RcdMapper  # noqa: PLC0415
    from echoplan.viewer import EchoListener, Plan, Text, map_picture  # noqa: PLC0415

    check_folder(out, RESULTS)
    simulation = _simulation(seed)
    listener = EchoListener(simulation.rig)
    sweeps = list(listener.listen(Progressing(simulation, "simulating")))
    joint, paper = JointMapper(simulation.rig), MdpFuzzyMapper(simulation.rig)
    mappers: dict[str, Mapper] = {"joint": joint, "mdp-fuzzy": paper, "rcd": RcdMapper(simulation.rig)}
    maps = {name: _mapped(mapper, sweeps) for name, mapper in mappers.items()}
    plan = Plan(feature_map=maps["joint"], truth=simulation.truth, echoes_xy=listener.points_xy)
    figures = _paper_figures(paper, sweeps, replace(plan, feature_map=maps["mdp-fuzzy"]))
    table = _table5(maps, simulation)
    _say(plan, table)
    _write_recording(out / "recording", simulation)
    _write_pictures(out / "pictures", (map_picture(plan), *figures))
    results = Results(
        title="The room of the paper",
        run=Run(source=f"sim:{_WORLD},rig={_RIG},seed={seed}", method="joint", seed=seed),
        settings={"simulation": simulation.settings, "method": joint.settings},
        plan=plan,
        times=listener.times,
        sections=(Text(title="What this is", paragraphs=_INTRODUCTION), table, *figures),
    )
    write_results(out, results)
    put(f"Now open {out / 'report.html'} in a browser.")


def _simulation(seed: int) -> "Simulation":
    from echoplan.io import builtin_rig, builtin_route, builtin_world  # noqa: PLC0415
    from echoplan.simulation import Simulation, SimulationSettings  # noqa: PLC0415

    return Simulation(
        world=builtin_world(_WORLD),
        rig=builtin_rig(_RIG),
        route=builtin_route(_WORLD),
        settings=SimulationSettings(dropout=0.02, stray=0.02),
        seed=seed,
    )


def _mapped(mapper: "Mapper", sweeps: "Sequence[Sweep]") -> "FeatureMap":
    from echoplan.methods import map_sweeps  # noqa: PLC0415

    return map_sweeps(mapper, tracked(sweeps, total=len(sweeps), task="mapping"))


def _say(plan: "Plan", table: "Table") -> None:
    say_what_was_found(plan)
    put()
    show(table)


def _paper_figures(mapper: "MdpFuzzyMapper", sweeps: "Sequence[Sweep]", plan: "Plan") -> "tuple[Picture, ...]":
    from echoplan.viewer import paper_pictures, sweep_stages  # noqa: PLC0415

    return paper_pictures([sweep_stages(mapper, sweep) for sweep in sweeps], plan)


def _write_recording(folder: Path, simulation: "Simulation") -> None:
    from echoplan.io import write_recording, write_truth, written_whole  # noqa: PLC0415

    with written_whole(folder) as draft:
        write_recording(draft, simulation)
        write_truth(draft / "truth.json", simulation.truth)
    report_files(folder, ["pings.csv", "rig.toml", "truth.json"])


def _write_pictures(folder: Path, pictures: "tuple[Picture, ...]") -> None:
    from echoplan.io import write_bytes, written_whole  # noqa: PLC0415

    with written_whole(folder) as draft:
        for picture in pictures:
            write_bytes(draft / f"{picture.name}.png", picture.png)
    report_files(folder, [f"{picture.name}.png" for picture in pictures])


def _table5(maps: "dict[str, FeatureMap]", simulation: "Simulation") -> "Table":
    from echoplan.evaluation import evaluate, table5  # noqa: PLC0415

    return table5({name: evaluate(found, simulation.truth) for name, found in maps.items()})
