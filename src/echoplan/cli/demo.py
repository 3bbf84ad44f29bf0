"""``echoplan demo``: the paper's room from the echoes to the map, beside the paper's own figures."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.results import RESULTS, Results, say_what_was_found, write_results
from echoplan.cli.terminal import Progressing, put, report_files, show

if TYPE_CHECKING:
    from echoplan.arrays import FloatArray
    from echoplan.methods.mdp_fuzzy import MdpFuzzyMapper
    from echoplan.model import FeatureMap, Sweep, Table
    from echoplan.simulation import Simulation
    from echoplan.viewer import Picture, Plan

__all__ = ["run"]

_WORLD, _RIG = "paper-room", "rotary-array"

_INTRODUCTION = (
    (
        "A robot with four ultrasonic sensors on a servo stops at ten stations A to J in a room with eight flat faces, "
        "a cylinder and a corner. Room and sensors are simulated, with 2 % of the echoes missing and 2 % astray; "
        "the map is made by the method of the paper, and by the conventional one for comparison."
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
    """Simulate the paper's room, map it by two methods, and draw the figures of the paper.

    Example: echoplan demo --seed 1
    """
    from echoplan.config import Run  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import check_folder, write_recording, write_truth, written_whole  # noqa: PLC0415
    from echoplan.methods.mdp_fuzzy import MdpFuzzyMapper  # noqa: PLC0415
    from echoplan.viewer import Text  # noqa: PLC0415

    check_folder(out, RESULTS)
    simulation = _simulation(seed)
    sweeps = list(Progressing(simulation, "simulating"))
    with written_whole(out / "recording") as draft:
        write_recording(draft, simulation)
        write_truth(draft / "truth.json", simulation.truth)
    mapper = MdpFuzzyMapper(simulation.rig)
    maps = {"mdp-fuzzy": _mapped(mapper, sweeps), "rcd": _mapped_by("rcd", simulation, sweeps)}
    plan, pictures, times = _drawn(mapper, sweeps, maps["mdp-fuzzy"], simulation)
    table = _table5(maps, simulation)
    say_what_was_found(plan)
    put()
    show(table)
    _write_pictures(out / "pictures", pictures)
    results = Results(
        title="The room of the paper",
        run=Run(source=f"sim:{_WORLD},rig={_RIG},seed={seed}", method="mdp-fuzzy", seed=seed),
        settings={"simulation": simulation.settings, "method": mapper.settings},
        plan=plan,
        times=times,
        sections=(Text(title="What this is", paragraphs=_INTRODUCTION), table, *pictures),
    )
    write_results(out, results)
    report_files(out / "recording", ["pings.csv", "rig.toml", "truth.json"])
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


def _mapped(mapper: "MdpFuzzyMapper", sweeps: "list[Sweep]") -> "FeatureMap":
    from echoplan.methods import map_sweeps  # noqa: PLC0415

    return map_sweeps(mapper, sweeps)


def _mapped_by(name: str, simulation: "Simulation", sweeps: "list[Sweep]") -> "FeatureMap":
    from echoplan.methods import find_method, map_sweeps  # noqa: PLC0415

    return map_sweeps(find_method(name).build(simulation.rig), sweeps)


def _drawn(
    mapper: "MdpFuzzyMapper", sweeps: "list[Sweep]", feature_map: "FeatureMap", simulation: "Simulation"
) -> "tuple[Plan, tuple[Picture, ...], FloatArray]":
    from echoplan.viewer import EchoListener, Plan, paper_pictures, sweep_stages  # noqa: PLC0415

    listener = EchoListener(simulation.rig)
    stages = [sweep_stages(mapper, sweep) for sweep in listener.listen(sweeps)]
    plan = Plan(
        feature_map=feature_map,
        truth=simulation.truth,
        heard=tuple(mapper.observations),
        echoes_xy=listener.points_xy,
    )
    return plan, paper_pictures(stages, plan), listener.times


def _write_pictures(folder: Path, pictures: "tuple[Picture, ...]") -> None:
    from echoplan.io import write_bytes, written_whole  # noqa: PLC0415

    with written_whole(folder) as draft:
        for picture in pictures:
            write_bytes(draft / f"{picture.name}.png", picture.png)
    report_files(folder, [f"{picture.name}.png" for picture in pictures])


def _table5(maps: "dict[str, FeatureMap]", simulation: "Simulation") -> "Table":
    from echoplan.evaluation import evaluate, table5  # noqa: PLC0415

    return table5({name: evaluate(found, simulation.truth) for name, found in maps.items()})
