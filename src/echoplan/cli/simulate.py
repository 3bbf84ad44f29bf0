"""``echoplan simulate``: a world, a rig and a route make a recording with the truth beside it."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from echoplan.cli.configuration import settings_of
from echoplan.cli.terminal import Progressing, report_files

if TYPE_CHECKING:
    from echoplan.simulation import Simulation

__all__ = ["run"]


def run(
    world: Annotated[
        str, typer.Argument(help="A built-in world (square, paper-room, two-room-flat, ...) or a world.toml.")
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder for the recording.")],
    rig: Annotated[str, typer.Option(help="A built-in rig or a rig.toml.")] = "rotary-array",
    route: Annotated[str | None, typer.Option(help="A built-in route or a route.csv; else that of the world.")] = None,
    config: Annotated[Path | None, typer.Option(help="Settings of the simulator, in a [simulation] table.")] = None,
    seed: Annotated[int, typer.Option(help="Seed of all noise.")] = 0,
) -> None:
    """Simulate a recording: pings.csv, rig.toml and truth.json.

    If odometry is noisy, rig.toml states its standard deviations.

    Example: echoplan simulate paper-room --out rec/ --seed 1
    """
    from echoplan.config import Run, write_run  # noqa: PLC0415 - --help must not wait for NumPy
    from echoplan.io import write_recording, write_truth, written_whole  # noqa: PLC0415
    from echoplan.simulation import Simulation, SimulationSettings, with_odometry  # noqa: PLC0415
    from echoplan.sources import find_rig, find_route, find_world  # noqa: PLC0415

    settings = settings_of(config, "simulation", SimulationSettings)
    place, using, way = find_world(world), with_odometry(find_rig(rig), settings.odometry), find_route(route or world)
    with _attributed_to(world):
        simulation = Simulation(world=place, rig=using, route=way, settings=settings, seed=seed)
    _check_in_reach(simulation, route or world)
    with written_whole(out) as draft:
        write_recording(draft, Progressing(simulation, "simulating"))
        write_truth(draft / "truth.json", simulation.truth)
        source = f"sim:{world},rig={rig}{f',route={route}' if route else ''},seed={seed}"
        write_run(draft / "run.toml", Run(source=source, seed=seed), {"simulation": settings})
    report_files(out, ["pings.csv", "rig.toml", "truth.json", "run.toml"])


@contextmanager
def _attributed_to(world: str) -> Iterator[None]:
    """Attribute an unknown material to the file of the world."""
    from echoplan.errors import InputError, UnknownNameError  # noqa: PLC0415

    try:
        yield
    except UnknownNameError as error:
        problem, _, remedy = str(error).partition("; ")
        raise InputError(world, problem, remedy=remedy) from error


def _check_in_reach(simulation: "Simulation", route: str) -> None:
    """Refuse a route that is nowhere near anything: it is that of another place, or not in metres."""
    import numpy as np  # noqa: PLC0415

    from echoplan.errors import InputError  # noqa: PLC0415
    from echoplan.geometry import distances_to_segments  # noqa: PLC0415

    world, stations = simulation.world, simulation.route.map_from_base[:, :2]
    centers, radii = world.discs[:, :2], world.discs[:, 2]
    away = np.concatenate(
        [
            distances_to_segments(stations, world.segments_xy).ravel(),
            (np.linalg.norm(stations[:, None] - centers, axis=2) - radii).ravel(),
        ]
    )
    reach = max(sensor.max_range for sensor in simulation.rig.sensors)
    if len(away) and away.min() > reach:
        raise InputError(
            route,
            f"nothing of the world {world.name!r} is in reach of it: the nearest is {away.min():.1f} m away, and "
            f"sensors reach {reach:g} m",
            remedy="write metres, or take the route of that world",
        )
