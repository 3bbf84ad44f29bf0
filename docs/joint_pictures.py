"""Makes the pictures of the estimator anew, for docs/theory.md and docs/results.md: python docs/joint_pictures.py.

Those of consistency and of class probabilities show what
``python benchmarks/joint.py --misset --save docs/pictures/joint.json`` kept.
"""

from __future__ import annotations

import itertools
import json
from collections.abc import Callable
from pathlib import Path
from runpy import run_path
from typing import TYPE_CHECKING, Any

import numpy as np

from echoplan.acoustics.predicted_echo import EchoModel, Kind, SonarTables, predict_echo, shape_of
from echoplan.arrays import FloatArray
from echoplan.geometry import directions, wrap
from echoplan.io import builtin_rig
from echoplan.joint.search.refinement import refine
from echoplan.methods import find_method, map_sweeps
from echoplan.model import Polyline, Route, World
from echoplan.preprocessing.measurements import Measurements, measurements_of
from echoplan.simulation import Simulation
from echoplan.viewer import Plan
from echoplan.viewer.figures import plan_figure
from echoplan.viewer.maps import draw_truth
from echoplan.viewer.palette import COLORS, FAINT, INK, MUTED, TRUTH
from echoplan.viewer.style import add_legend, dress, dress_map, letter, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

PICTURES = Path(__file__).parent / "pictures"
ROUND = np.linspace(0.0, 2 * np.pi, 49)
MEASURED = PICTURES / "joint.json"
ROOMS = Path(__file__).parents[1] / "benchmarks" / "library" / "rooms.py"
# An oblique L with a box and cylinders.
SEED = 5
# A drive through a right-angled room with cylinders.
DRIVE = 8
# From the axis of the rotary array to its sensors [m].
_ARM = 0.05
WALL, CORNER, CYLINDER = COLORS.values()


def main() -> None:
    """Draw all of them."""
    for draw in DRAWINGS:
        draw()


def arcs() -> None:
    """Draw the readings of one wall from three stations: points on arcs, and the common tangent of the arcs."""
    wall = np.array([[-0.2, 1.5], [2.4, 1.5]])
    stations = np.array([[0.2, 0.3, 1.5], [1.1, 0.7, 1.7], [1.9, -0.1, 1.6]])
    figure = new_figure(height=3.3)
    axes = figure.subplots()
    axes.plot(*wall.T, color=TRUTH, linewidth=5, alpha=0.6, label="the wall")
    for number, measurements in enumerate(_simulated_measurements([wall], stations)):
        center, facing = measurements.centers[0], np.pi / 2
        near = np.isfinite(measurements.readings) & (np.abs(wrap(measurements.bearings - facing)) < np.radians(60))
        ends = np.column_stack([measurements.x, measurements.y]) + measurements.readings[:, None] * np.column_stack(
            [measurements.ux, measurements.uy]
        )
        axes.plot(
            *ends[near].T, ".", color=CORNER, markersize=2.5, label="readings as if sound were a ray" * (not number)
        )
        radius = float(np.hypot(*(ends[near] - center).T).min())
        circle = center + radius * directions(facing + np.radians(np.linspace(-50, 50, 101)))
        axes.plot(*circle.T, color=MUTED, linewidth=0.8, label="circle of the nearest reading" * (not number))
        axes.plot(*center, "o", color=INK, markersize=4)
        axes.plot(*np.array([center, center + radius * directions(facing)]).T, color=FAINT, linewidth=0.8, zorder=0)
    axes.plot(wall[:, 0], [1.5, 1.5], "--", color=WALL, linewidth=1.2, label="common tangent")
    dress_map(axes)
    add_legend(axes, columns=2, where="above")
    _save(figure, "joint-arcs")


def evidence() -> None:
    """Draw the readings of two stations with what two walls and a false wall predict."""
    turn = np.radians(70)
    corner = [2.6 * directions(0.0), np.zeros(2), 2.6 * directions(turn)]
    stations = np.column_stack([np.array([1.5, 2.0])[:, None] * directions(np.array([0.65, 0.35])), [0.0, 0.0]])
    transducer = builtin_rig("rotary-array").transducer
    assert transducer is not None
    tables = EchoModel.of(transducer).tabulated()
    walls = [np.array([Kind.WALL, -np.pi / 2, 0.0, 0.0]), np.array([Kind.WALL, turn + np.pi / 2, 0.0, 0.0])]
    both = _simulated_measurements([np.array(corner)], stations)
    # Sound that goes over both walls comes back as if from the image of the image.
    ghost = _as_wall(both[0], tables, float(np.hypot(*stations[0, :2]) * np.sin(turn)))
    figure = new_figure(height=3.3)
    for panel, measurements, name in zip(figure.subplots(1, 2, sharey=True), both, "ab", strict=True):
        finite = np.isfinite(measurements.readings)
        bearings = np.degrees(wrap(measurements.bearings - np.pi - turn / 2))
        panel.plot(bearings[finite], measurements.readings[finite], ".", color=MUTED, markersize=3, label="measured")
        for number, wall in enumerate(walls):
            _draw_expected(panel, measurements, tables, wall, color=WALL, label="predicted by the walls" * (not number))
        _draw_expected(
            panel, measurements, tables, ghost, color=CORNER, label="predicted by a wall fitted to the multipath"
        )
        letter(panel, f"({name}) station {'AB'['ab'.index(name)]}")
        dress(panel, x="bearing relative to the bisector (degrees)", y="reading (m)")
        panel.set(xlim=(-120, 120), ylim=(0.0, 2.2))
    add_legend(panel)
    _save(figure, "joint-evidence")


def random_room() -> None:
    """Draw the map of a random room over the ground truth."""
    simulation: Simulation = run_path(str(ROOMS))["random_simulation"](SEED)
    found = map_sweeps(find_method("joint").build(simulation.rig), simulation)
    _save(plan_figure(Plan(feature_map=found, truth=simulation.truth)), "joint-map", dots=120)


def drift() -> None:
    """Draw the map of a drive by dead reckoning, as recorded and corrected, over the true room and path."""
    simulation = run_path(str(ROOMS))["random_drive"](DRIVE)
    sweeps, truth = tuple(simulation), simulation.truth
    figure = new_figure(width=7.2, height=3.9)
    for axes, mode, words in zip(
        figure.subplots(1, 2), ("trust", "correct"), ("as recorded", "corrected"), strict=True
    ):
        method = find_method("joint")
        found = map_sweeps(method.build(simulation.rig, method.settings_type(poses=mode)), sweeps)
        draw_truth(axes, truth)
        axes.plot(*truth.poses[:, :2].T, color=TRUTH, linewidth=0.8)
        for wall in found.walls:
            axes.plot(*wall.endpoints_xy.T, color=WALL, linewidth=1.4)
        around = np.column_stack([np.cos(ROUND), np.sin(ROUND)])
        for cylinder in found.cylinders:
            axes.plot(*(cylinder.center_xy + cylinder.radius * around).T, color=WALL, linewidth=1.4)
        axes.plot(*found.poses[:, :2].T, "o-", color=CORNER, markersize=2.5, linewidth=0.8)
        dress_map(axes)
        letter(axes, words)
    _save(figure, "joint-drift")


def consistency() -> None:
    """Draw the distribution of NEES, and the chi-square distribution of right covariances."""
    from scipy.stats import chi2  # noqa: PLC0415 - slow to import

    measured = _measured()["nees"]
    figure = new_figure(height=2.6)
    for panel, (name, color) in zip(figure.subplots(1, 3), COLORS.items(), strict=True):
        squares, freedom = np.array(measured[name]), 3 if name == "cylinder" else 2
        edges = np.linspace(0.0, 12.0, 25)
        panel.hist(np.minimum(squares, 11.99), edges, density=True, color=color, alpha=0.75, label="rooms")
        panel.plot(edges, chi2.pdf(edges, freedom), color=INK, linewidth=1.0, label=f"chi-square, {freedom}")
        letter(panel, f"{len(squares)} {name}s")
        dress(panel, x="NEES", y="density")
        add_legend(panel)
    _save(figure, "joint-consistency")


def class_probabilities() -> None:
    """Draw class probabilities, and the share of features whose class is right."""
    from scipy.stats import binomtest  # noqa: PLC0415 - slow to import

    pairs = np.array(_measured()["class_probabilities"])
    edges = np.array([0.0, 0.5, 0.9, 0.99, 0.999, 1.0])
    places = np.clip(np.digitize(pairs[:, 0], edges) - 1, 0, len(edges) - 2)
    groups = {place: pairs[places == place] for place in range(len(edges) - 1) if (places == place).any()}
    figure = new_figure(width=4.6, height=2.8)
    axes = figure.subplots()
    for place, group in groups.items():
        probability, right = group.mean(axis=0)
        interval = binomtest(int(group[:, 1].sum()), len(group)).proportion_ci(method="wilson")
        first = place == min(groups)
        axes.plot(
            place - 0.08, probability, "s", color=CORNER, markersize=5, label="mean probability" if first else None
        )
        axes.plot([place + 0.08] * 2, [interval.low, interval.high], color=WALL, linewidth=1.2)
        axes.plot(place + 0.08, right, "o", color=WALL, markersize=5, label="share right, 95 %" if first else None)
    names = [
        f"{low:g} to {high:g}\n{len(groups.get(k, ()))}" for k, (low, high) in enumerate(itertools.pairwise(edges))
    ]
    dress(axes, x="probability of the class; number of features", y="share")
    axes.set_xticks(range(len(names)), names)
    axes.set_ylim(0.0, 1.05)
    add_legend(axes, columns=2, where="above")
    _save(figure, "joint-class-probabilities")


def _simulated_measurements(lines: list[FloatArray], stations: FloatArray) -> list[Measurements]:
    """Simulate the pings of the rotary array in a world of open polylines."""
    world = World(name="lines", polylines=tuple(Polyline(points_xy=line) for line in lines))
    rig = builtin_rig("rotary-array")
    simulation = Simulation(world=world, rig=rig, route=Route(map_from_base=stations))
    return [measurements_of(sweep, rig) for sweep in simulation]


def _as_wall(measurements: Measurements, tables: SonarTables, depth: float) -> FloatArray:
    """Fit a wall to the echoes of about one depth."""
    near = np.flatnonzero(np.abs(measurements.readings + _ARM - depth) < 0.05)
    angle = float(np.angle(np.mean(np.exp(1j * measurements.bearings[near]))))
    start = np.array([Kind.WALL, angle, float(measurements.centers[0] @ directions(angle)) + depth, 0.0])
    return refine(measurements, tables, start, near, (0.005, 0.05), 8)


def _draw_expected(
    axes: Axes, measurements: Measurements, tables: SonarTables, reflector: FloatArray, *, color: str, label: str
) -> None:
    """Draw the readings that a landmark predicts, where it should be detected."""
    order = np.argsort(measurements.bearings)
    shape = shape_of(reflector)
    pings = zip(
        measurements.x[order], measurements.y[order], measurements.ux[order], measurements.uy[order], strict=True
    )
    echoes = np.array([predict_echo(tables, shape, ping) for ping in pings])
    bearings = np.degrees(wrap(measurements.bearings[order] - np.pi - np.radians(35)))
    readings = np.where(echoes[:, 1] > 0.0, echoes[:, 2], np.nan)
    turned = np.argsort(bearings)
    axes.plot(bearings[turned], readings[turned], color=color, linewidth=1.4, label=label or None)


def _measured() -> Any:
    return json.loads(MEASURED.read_text(encoding="utf-8"))


def _save(figure: Figure, name: str, *, dots: int = 180) -> None:
    figure.savefig(PICTURES / f"{name}.png", dpi=dots, metadata={"Software": None})


DRAWINGS: tuple[Callable[[], None], ...] = (arcs, evidence, random_room, drift, consistency, class_probabilities)

if __name__ == "__main__":
    main()
