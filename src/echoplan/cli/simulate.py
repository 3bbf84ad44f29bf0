"""``echoplan simulate``: a world, a rig and a route make a recording with the truth beside it."""

from pathlib import Path
from typing import Annotated

import typer

from echoplan.cli.terminal import Progressing, report_files

__all__ = ["run"]


def run(
    world: Annotated[str, typer.Argument(help="A built-in world (square, paper-room, office, ...) or a world.toml.")],
    out: Annotated[Path, typer.Option(help="Folder for the recording.")],
    rig: Annotated[str, typer.Option(help="A built-in rig or a rig.toml.")] = "rotary-array",
    route: Annotated[str | None, typer.Option(help="A built-in route or a route.csv; else that of the world.")] = None,
    config: Annotated[Path | None, typer.Option(help="Settings of the simulator, in a [simulation] table.")] = None,
    seed: Annotated[int, typer.Option(help="Seed of all noise.")] = 0,
) -> None:
    """Simulate a recording: pings.csv, rig.toml and truth.json.

    Where odometry is noisy rig.toml tells by how much, as a careful maker would.

    Example: echoplan simulate paper-room --out rec/ --seed 1
    """
    from echoplan.config import Run, read_config, write_run  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import write_recording, write_truth, written_whole  # noqa: PLC0415
    from echoplan.simulation import Simulation, SimulationSettings, with_odometry  # noqa: PLC0415
    from echoplan.sources import find_rig, find_route, find_world  # noqa: PLC0415

    sections = {"simulation": SimulationSettings}
    settings = read_config(config, sections)["simulation"] if config else SimulationSettings()
    simulation = Simulation(
        world=find_world(world),
        rig=with_odometry(find_rig(rig), settings.odometry),
        route=find_route(route or world),
        settings=settings,
        seed=seed,
    )
    with written_whole(out) as draft:
        write_recording(draft, Progressing(simulation, "simulating"))
        write_truth(draft / "truth.json", simulation.truth)
        write_run(draft / "run.toml", Run(source=world, seed=seed), {"simulation": settings})
    report_files(out, ["pings.csv", "rig.toml", "truth.json", "run.toml"])
