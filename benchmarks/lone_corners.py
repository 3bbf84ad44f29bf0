"""Corners without two walls in the map: python benchmarks/lone_corners.py [ROOMS] [--first SEED].

Maps random rooms with a pier or a niche (40 by default, from 30 stations each), and lists the corners of the maps that
lie where no two walls cross: how far they are from the nearest true vertex, and whether their covariances are right.
Prints the standard deviation that their errors need besides the covariance of the estimate, by maximum likelihood; that
is what ``MapSettings.lone_corner_sigma`` stands for.  It was chosen on seeds 620 to 659; other seeds check it.
"""

import argparse
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor
from itertools import combinations

import numpy as np

from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show, tracked
from echoplan.geometry import intersections
from echoplan.joint.map_extraction.map_builder import MapSettings
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.methods import map_sweeps
from echoplan.model import Corner, FeatureMap, Table
from library.rooms import random_simulation

ROOMS, FIRST, STATIONS = 40, 700, 30
# A corner this near to the crossing of two walls was drawn there [m].
SAME = 1e-6
# Farther from every true vertex than this it is a false corner, and its error says nothing [m].
FALSE = 0.15
# Standard deviations that are compared [m].
GRID = np.arange(0.0, 0.0101, 0.001)
# Square of the Mahalanobis distance within which 95 % of errors in two dimensions lie.
INSIDE = 5.991


def main() -> None:
    """Map all rooms and print what the errors of such corners need."""
    parser = argparse.ArgumentParser(description="Corners without two walls in the map.")
    parser.add_argument("rooms", type=int, nargs="?", default=ROOMS)
    parser.add_argument("--first", type=int, default=FIRST, metavar="SEED", help="seed of the first room")
    parser.add_argument("--workers", type=int)
    arguments = parser.parse_args()
    seeds = range(arguments.first, arguments.first + arguments.rooms)
    with ProcessPoolExecutor(arguments.workers) as workers:
        found = list(tracked(workers.map(lone_corners, seeds), total=len(seeds), task="mapping"))
    corners = [each for room in found for each in room]
    rows = [row(sigma, corners) for sigma in GRID]
    columns = ("added sigma (mm)", "log-likelihood", "mean NEES (ideal 2)", "inside 95 % (%)")
    title = (
        f"{len(corners)} corners without two walls in {len(seeds)} rooms, median error {median_error(corners):.1f} mm"
    )
    show(Table(title=title, columns=columns, rows=tuple(rows)))


class _WithoutModelError(MapSettings):
    lone_corner_sigma = 0.0


def lone_corners(seed: int) -> list[tuple[FloatArray, FloatArray]]:
    """Map a room; return error [m] and covariance, without the model error, of each corner without two walls."""
    simulation = random_simulation(seed, recess=True, stations=STATIONS)
    settings = JointSettings(map=_WithoutModelError())
    found = map_sweeps(JointMapper(simulation.rig, settings), tuple(simulation))
    vertices = simulation.truth.walls_xy.reshape(-1, 2)
    errors = []
    for corner in found.corners:
        away = corner.position_xy - vertices
        distances = np.hypot(*away.T)
        if not is_at_crossing(corner, found) and distances.min() < FALSE:
            errors.append((away[np.argmin(distances)], corner.covariance))
    return errors


def is_at_crossing(corner: Corner, found: FeatureMap) -> bool:
    """Return True if a corner is drawn where two walls of the map cross."""
    lines = np.array([(each.normal_angle, each.offset) for each in found.walls]).reshape(-1, 2)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossings = [intersections(*pair) for pair in combinations(lines, 2)]
    return any(np.hypot(*(each - corner.position_xy)) < SAME for each in crossings)


def row(sigma: float, corners: Sequence[tuple[FloatArray, FloatArray]]) -> tuple[str, ...]:
    """Tabulate how likely errors are if the model error has this standard deviation [m]."""
    total, squares = 0.0, list[float]()
    for error, covariance in corners:
        whole = covariance + sigma**2 * np.eye(2)
        squares.append(float(error @ np.linalg.solve(whole, error)))
        total -= 0.5 * (squares[-1] + float(np.linalg.slogdet(whole)[1]))
    inside = np.mean(np.array(squares) < INSIDE) if squares else np.nan
    mean = np.mean(squares) if squares else np.nan
    return f"{1000 * sigma:.0f}", f"{total:.1f}", f"{mean:.1f}", f"{100 * inside:.1f}"


def median_error(corners: Sequence[tuple[FloatArray, FloatArray]]) -> float:
    """Return the median distance from the true vertex [mm]; NaN if there is no corner."""
    return 1000.0 * float(np.median([np.hypot(*error) for error, _ in corners])) if corners else np.nan


if __name__ == "__main__":
    main()
