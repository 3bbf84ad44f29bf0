"""Makes the pictures of the documents anew: python docs/pictures.py."""

import re
import subprocess
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stdout
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import drawings  # type: ignore[import-not-found]  # beside this file
import numpy as np
from joint_pictures import DRAWINGS as OF_JOINT  # type: ignore[import-not-found]  # beside this file
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from echoplan.classical.topological import TopologicalMapper
from echoplan.cli import demo
from echoplan.io import builtin_rig, builtin_route, builtin_world, write_bytes
from echoplan.methods import METHODS, Mapper, grid_of, map_sweeps, points_of
from echoplan.model import FeatureMap, Recording, Truth
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.simulation.settings import OdometryNoise
from echoplan.sources import find_truth, open_source
from echoplan.viewer.maps import draw_cylinders, draw_openings, draw_truth, draw_unobserved, draw_walls

PICTURES = Path(__file__).parent / "pictures"
# Figures of the paper that its page shows.
PAPER_FIGURES = ("02-ranges", "05-fit", "07-memberships", "10-filter", "11-clusters", "12-classes", "13-map")


def main() -> None:
    """Draw all of them."""
    for draw in DRAWINGS:
        draw()


def flat() -> None:
    """Copy the map of ``echoplan demo`` for the README."""
    _take(["map"], paper=False)


def paper_room() -> None:
    """Copy the figures of ``echoplan demo --paper`` for docs/paper.md."""
    _take([f"figure-{name}" for name in PAPER_FIGURES], paper=True)


def _take(names: Sequence[str], *, paper: bool) -> None:
    with TemporaryDirectory() as folder:
        with redirect_stdout(StringIO()):
            demo.run(Path(folder) / "demo", paper=paper)
        for name in names:
            write_bytes(PICTURES / f"{name}.png", (Path(folder) / "demo" / "pictures" / f"{name}.png").read_bytes())


def first_map() -> None:
    """Record the simulated device, and keep the map: what docs/build.md shows."""
    program = [sys.executable, "-m", "echoplan"]
    command = [*program, "device", "square", "--tcp", "0", "--speed", "10"]
    with TemporaryDirectory() as folder, subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as device:  # noqa: S603
        try:
            assert device.stdout is not None
            address = re.search(r"tcp://\S+", device.stdout.readline())
            assert address is not None, "the device did not start"
            for words in (
                ["record", address[0], "--place", "-40 20 17", "--out", f"{folder}/rec"],
                ["map", f"{folder}/rec", "--out", f"{folder}/map"],
            ):
                subprocess.run([*program, *words], check=True, stdout=subprocess.DEVNULL)  # noqa: S603
        finally:
            device.terminate()
        write_bytes(PICTURES / "first-map.svg", (Path(folder) / "map" / "map.svg").read_bytes())


def methods_side_by_side() -> None:
    """Map two rooms by every method: what docs/methods.md shows."""
    for room, name in (("sim:paper-room", "methods"), ("sim:square", "square")):
        source = open_source(room)
        truth = find_truth(source)
        recording = Recording(name=source.name, rig=source.rig, sweeps=tuple(source))
        figure, panels = _panels(len(METHODS), columns=5)
        for panel, method in zip(panels, METHODS.values(), strict=False):
            mapper = method.build(recording.rig)
            _draw_map(panel, map_sweeps(mapper, recording), truth)
            _draw_beneath(panel, mapper)
            panel.set_title(method.name, fontsize=8)
        _save(figure, name)


def drifting_odometry() -> None:
    """Map one room from poses that drift, by a method that trusts them and by two that correct them."""
    noise = OdometryNoise(along=0.02, lateral=0.02, yaw_per_metre=0.035, yaw_per_radian=0.035)
    simulation = Simulation(
        world=builtin_world("paper-room"),
        rig=builtin_rig("rotary-array"),
        route=builtin_route("paper-room"),
        settings=SimulationSettings(odometry=noise),
        seed=1,
    )
    sweeps = tuple(simulation)
    figure, panels = _panels(3, columns=3)
    for panel, name in zip(panels, ("mdp-fuzzy", "salient-ekf", "joint"), strict=True):
        _draw_map(panel, map_sweeps(METHODS[name].build(simulation.rig), sweeps), simulation.truth)
        panel.plot(*simulation.truth.poses[:, :2].T, "x", color="black", markersize=3)
        panel.set_title(name, fontsize=8)
    _save(figure, "drift")


def places() -> None:
    """Draw the places and the passage of a corridor with a bend, on its free space."""
    source = open_source("sim:corridor")
    mapper = TopologicalMapper(source.rig)
    map_sweeps(mapper, source)
    free, graph = mapper.free_space(), mapper.graph()
    figure, (panel,) = _panels(1, columns=1)
    low, high = free.origin_xy, free.origin_xy + free.resolution * np.array(free.data.shape[::-1])
    panel.imshow(free.data, origin="lower", extent=(low[0], high[0], low[1], high[1]), cmap="Greys_r", vmin=-2)
    truth = find_truth(source)
    if truth is not None:
        draw_truth(panel, truth)
    for place in graph.places:
        panel.plot(*place.center_xy, "o", color="tab:blue", markersize=8)
    for passage in graph.passages:
        ends = [graph.places[passage.first].center_xy, passage.position_xy, graph.places[passage.second].center_xy]
        panel.plot(*np.transpose(ends), "-", color="tab:blue", linewidth=1.5)
        panel.plot(*passage.position_xy, "s", color="tab:orange", markersize=7)
    _save(figure, "places")


def _panels(count: int, *, columns: int) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(1.65 * columns if columns > 2 else 3.2 * columns, 1.8 * -(-count // columns) + 1.0))
    grid = figure.subplots(-(-count // columns), columns, squeeze=False)
    for panel in grid.flat:
        panel.set_aspect("equal")
        panel.axis("off")
    return figure, list(grid.flat)


def _draw_map(panel: Axes, found: FeatureMap, truth: Truth | None) -> None:
    if truth is not None:
        draw_truth(panel, truth)
        low, high = truth.walls_xy.reshape(-1, 2).min(axis=0) - 0.3, truth.walls_xy.reshape(-1, 2).max(axis=0) + 0.3
        panel.set_xlim(low[0], high[0])
        panel.set_ylim(low[1], high[1])
    draw_walls(panel, found.walls, found.poses[:, :2], thickness=0.04)
    draw_unobserved(panel, found.unobserved)
    draw_openings(panel, found, thickness=0.04)
    draw_cylinders(panel, found.cylinders)
    panel.plot(*found.poses[:, :2].T, ".", color="gray", markersize=2)


def _draw_beneath(panel: Axes, mapper: Mapper) -> None:
    """Draw the points or the occupied cells from which a method made its map."""
    panel.plot(*points_of(mapper).T, ",", color="tab:red", alpha=0.8, zorder=5)
    grid = grid_of(mapper)
    if grid is not None:
        low, high = grid.origin_xy, grid.origin_xy + grid.size_xy
        extent = (low[0], high[0], low[1], high[1])
        limits = (panel.get_xlim(), panel.get_ylim())
        panel.imshow(grid.values, origin="lower", extent=extent, cmap="Greys", vmin=0.1, vmax=1.6, zorder=-1)
        panel.set(xlim=limits[0], ylim=limits[1])


def _save(figure: Figure, name: str) -> None:
    figure.tight_layout(pad=0.4)
    figure.savefig(PICTURES / f"{name}.png", dpi=90)


DRAWINGS: tuple[Callable[[], None], ...] = (
    flat,
    paper_room,
    methods_side_by_side,
    drifting_odometry,
    places,
    *OF_JOINT,
    drawings.main,
    first_map,
)

if __name__ == "__main__":
    main()
