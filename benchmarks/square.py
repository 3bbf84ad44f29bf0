"""How square a square room comes out: python benchmarks/square.py [SEED...].

Maps the built-in square room, five stations of the built-in array, by every method and prints two figures for what it
makes its map of (points, or the occupied cells of its grid) and for the walls and cylinders of the map itself:

- map error: the symmetric mean nearest-point distance to the true walls (Barshan 2008);
- tilt: the mean local angle between the drawing and the nearest true wall: 0 degrees is drawn square, 22.5 degrees is a
  circle, which has all directions.
"""

import sys
from collections.abc import Iterable
from dataclasses import dataclass
from math import degrees, nan
from statistics import fmean

import numpy as np
from scipy.spatial import cKDTree

from echoplan.arrays import FloatArray
from echoplan.cli.terminal import show
from echoplan.evaluation import Outline, map_error
from echoplan.methods import METHODS, Mapper, grid_of, map_sweeps, points_of
from echoplan.model import FeatureMap, Table, Truth
from echoplan.simulation import Simulation
from echoplan.sources import open_source

# Sampling distance of lines [m]; points within the radius of three cells give the direction of a drawing [m].
SPACING, NEAR = 0.01, 0.15
# Likelier cells are drawn: the threshold of map_server.
OCCUPIED = 0.65


@dataclass(frozen=True, slots=True, kw_only=True)
class Squareness:
    """How square a drawing is: its map error [m] and its tilt [rad]; nan if it is empty."""

    error: float = nan
    tilt: float = nan


def main(arguments: list[str]) -> None:
    """Map the square room by every method and print how square it comes out."""
    seeds = [int(each) for each in arguments] or [0, 1, 2]
    rooms = [square_room(seed) for seed in seeds]
    truth = rooms[0].truth
    itself = squareness(Outline(segments_xy=truth.walls_xy, circles=truth.cylinders).samples(SPACING), truth)
    rows: list[tuple[str, ...]] = [("the room itself", "-", "-", "-", *cells([itself]))]
    rows += [row(name, [judged(room, name) for room in rooms]) for name in METHODS]
    show(
        Table(
            title=f"The square room by every method, means of seeds {', '.join(map(str, seeds))}",
            columns=("method", "drawn", "error (mm)", "tilt (°)", "map: error (mm)", "tilt (°)"),
            rows=tuple(rows),
        )
    )


def square_room(seed: int) -> Simulation:
    """Simulate the square room."""
    source = open_source(f"sim:square,seed={seed}")
    assert isinstance(source, Simulation)
    return source


def judged(room: Simulation, name: str) -> tuple[str, Squareness, Squareness]:
    """Map the room: what a method draws, how square that is, and how square its map."""
    mapper = METHODS[name].build(room.rig)
    found = map_sweeps(mapper, room)
    kind, points = drawing(mapper)
    return kind, squareness(points, room.truth), squareness(outline(found), room.truth)


def drawing(mapper: Mapper) -> tuple[str, FloatArray]:
    """Take what a method makes its map of, by its name and as points."""
    grid = grid_of(mapper)
    if grid is not None:
        return "cells", grid.centers_xy[grid.values > OCCUPIED]
    points = points_of(mapper)
    return ("points", points) if len(points) else ("-", points)


def outline(found: FeatureMap) -> FloatArray:
    """Points of the walls and cylinders of a map."""
    circles = np.reshape([[*each.center_xy, each.radius] for each in found.cylinders], (-1, 3))
    walls = np.reshape([wall.endpoints_xy for wall in found.walls], (-1, 2, 2))
    return Outline(segments_xy=walls, circles=circles).samples(SPACING)


def squareness(points_xy: FloatArray, truth: Truth) -> Squareness:
    """Compare a drawing with a room of upright and level walls."""
    faces = Outline(segments_xy=truth.walls_xy, circles=truth.cylinders).samples(SPACING)
    return Squareness(error=map_error(points_xy, faces).mean, tilt=tilt(points_xy))


def tilt(points_xy: FloatArray) -> float:
    """Mean angle between a drawing and the nearer of the two axes [rad].

    About each point the principal direction of what lies near; it counts as much as it is one: by the difference of the
    principal variances as a share of their sum.
    """
    if len(points_xy) < 2:
        return nan
    near = cKDTree(points_xy).query_ball_point(points_xy, NEAR)
    spreads = np.stack([np.cov(points_xy[those].T, bias=True) for those in near])
    along, across = spreads[:, 0, 0] - spreads[:, 1, 1], 2 * spreads[:, 0, 1]
    # Twice the angle of the principal axis, folded to the nearer of x and y.
    folded = np.abs(np.abs(np.arctan2(across, along)) - np.pi / 2)
    total = spreads[:, 0, 0] + spreads[:, 1, 1]
    weights = np.hypot(along, across) / np.where(total > 0, total, 1.0)
    return float(np.average((np.pi / 2 - folded) / 2, weights=weights)) if weights.any() else nan


def row(name: str, results: Iterable[tuple[str, Squareness, Squareness]]) -> tuple[str, ...]:
    """Write the row of a method."""
    kinds, drawn, mapped = zip(*results, strict=True)
    return (name, kinds[0], *cells(drawn), *cells(mapped))


def cells(found: Iterable[Squareness]) -> tuple[str, str]:
    """Write error and tilt, means over the rooms in which there is something to judge."""
    every = [each for each in found if not np.isnan(each.error)]
    if not every:
        return "-", "-"
    return f"{1000 * fmean(each.error for each in every):.1f}", f"{degrees(fmean(each.tilt for each in every)):.1f}"


if __name__ == "__main__":
    main(sys.argv[1:])
