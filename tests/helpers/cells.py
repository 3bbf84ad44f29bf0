"""Cones for tests, and which cells they cover: plain NumPy over all cells, an angle and a distance for each."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from echoplan.arrays import BoolArray, FloatArray
from echoplan.classical.grids import CanvasSettings, Cones, GridRule, Raster
from echoplan.model import OccupancyGrid

COARSE = CanvasSettings(resolution=0.1)


def cone(
    x: float = 0.0,
    y: float = 0.0,
    *,
    bearing: float = 0.0,
    reading: float = 1.0,
    half_aperture: float = 0.6,
    hub: tuple[float, float] | None = None,
) -> Cones:
    """The cone of one ping; the turret's axis is in the sensor by default."""
    hub_x, hub_y = hub or (x, y)
    row = (x, y, np.cos(bearing), np.sin(bearing), half_aperture, reading, 0.05, 3.0, hub_x, hub_y)
    return Cones(*(np.array([value]) for value in row))


def random_cones(rng: np.random.Generator, count: int = 40) -> Cones:
    """Cones of all kinds, near each other; one in five detects nothing."""
    bearings = rng.uniform(-np.pi, np.pi, count)
    x, y = rng.uniform(-1.0, 1.0, (2, count))
    return Cones(
        x=x,
        y=y,
        ux=np.cos(bearings),
        uy=np.sin(bearings),
        half_apertures=rng.choice([0.1, 0.6, 1.2, np.pi / 2], count),
        readings=np.where(rng.random(count) < 0.2, np.inf, rng.uniform(0.05, 2.5, count)),
        blanks=np.full(count, 0.05),
        reaches=np.full(count, 2.5),
        hub_x=np.round(x, 1),
        hub_y=np.round(y, 1),
    )


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Seen:
    """How a ping sees all cells: distances [m], turns from the axis as shares of half the aperture, and its cone."""

    reading: float
    reach: float
    distances: FloatArray
    turns: FloatArray
    inside: BoolArray


def seen(cones: Cones, raster: Raster) -> Iterator[Seen]:
    """Look at all cells from each ping."""
    centers_x = raster.x + raster.resolution * (np.arange(raster.columns) + 0.5)
    centers_y = raster.y + raster.resolution * (np.arange(raster.rows) + 0.5)
    for x, y, ux, uy, half_aperture, reading, _, reach, *_ in zip(*cones, strict=True):
        away = (centers_x - x)[None] + 1j * (centers_y - y)[:, None]
        turns = np.angle(away * (ux - 1j * uy)) / half_aperture
        yield Seen(
            reading=float(reading), reach=float(reach), distances=np.abs(away), turns=turns, inside=np.abs(turns) <= 1.0
        )


def raster_of(grid: OccupancyGrid) -> Raster:
    """Where the cells of a grid lie."""
    (x, y), (rows, columns) = grid.origin_xy.tolist(), grid.values.shape
    return Raster(x, y, grid.resolution, rows, columns)


def value_at(rule: GridRule, x: float, y: float) -> float:
    """What a rule makes of the cell of a point."""
    row, column = rule.grid.cells_of([x, y])
    return float(rule.grid.values[row, column])
