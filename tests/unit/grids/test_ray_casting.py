"""Rays through cells, against a slow twin."""

import numpy as np
import pytest

from echoplan.arrays import BoolArray, IntArray
from echoplan.grids.ray_casting import Fans, cells_on_segments, fans_of, join_fans, rays_per_cell


def slow_counts(fans: Fans, blocked: BoolArray) -> IntArray:
    """Sort the places where each ray crosses sides of cells; the cells lie about the middles between them."""
    counts = np.zeros(blocked.shape, dtype=np.int64)
    for x, y, bearing, half_angle, reach, horizon in zip(*fans, strict=True):
        found: set[tuple[int, int]] = set()
        rays = int(np.ceil(2 * half_angle * reach)) + 1
        for angle in np.linspace(bearing - half_angle, bearing + half_angle, rays) if half_angle else [bearing]:
            cells, _ = slow_ray((x, y), angle, reach, blocked)
            found |= set(cells) if not horizon or slow_ray((x, y), angle, horizon, blocked)[1] else set()
        for cell in found:
            counts[cell] += 1
    return counts


def slow_ray(
    origin: tuple[float, float], angle: float, reach: float, blocked: BoolArray
) -> tuple[list[tuple[int, int]], bool]:
    """Cells of a ray, and whether it ends at a blocked one."""
    start, way = np.array(origin), np.array([np.cos(angle), np.sin(angle)])
    sides = np.arange(-1, max(blocked.shape) + 2)
    crossed = np.concatenate([(sides - start[axis]) / way[axis] for axis in (0, 1)])
    bounds = np.concatenate([[0.0], np.sort(crossed[(crossed > 0.0) & (crossed < reach)]), [reach]])
    cells: list[tuple[int, int]] = []
    for middle in 0.5 * (bounds[1:] + bounds[:-1]):
        column, row = np.floor(start + middle * way).astype(int).tolist()
        if not (0 <= row < blocked.shape[0] and 0 <= column < blocked.shape[1]):
            return cells, False
        if blocked[row, column]:
            return cells, True
        cells.append((row, column))
    return cells, False


@pytest.mark.parametrize("horizon", [0.0, 12.0])
@pytest.mark.parametrize("seed", range(5))
def test_cells_are_counted_as_by_a_slow_reference(seed: int, horizon: float) -> None:
    rng = np.random.default_rng(seed)
    blocked = rng.random((20, 30)) < 0.05
    fans = fans_of(
        rng.uniform(0, [30, 20], (12, 2)),
        bearings=rng.uniform(-4, 4, 12),
        half_angles=rng.choice([0.0, 0.3, 1.2], 12),
        reaches=rng.uniform(0.1, 15, 12),
        horizons=horizon,
    )
    assert np.array_equal(rays_per_cell(fans, blocked), slow_counts(fans, blocked))


def test_rays_along_sides_of_cells_and_of_no_length_stay_on_the_grid() -> None:
    fans = fans_of(
        [[0.0, 0.0], [2.0, 2.0], [3.0, 1.0]], bearings=[0.0, np.pi, np.pi / 2], half_angles=0.0, reaches=[9, 9, 0]
    )
    counts = rays_per_cell(fans, np.zeros((4, 4), dtype=np.bool_))
    assert counts[0].tolist() == [1, 1, 1, 1]
    assert counts[2].tolist() == [1, 1, 1, 0]
    assert counts[1, 3] == 1


@pytest.mark.parametrize("turn", np.linspace(0.0, np.pi, 9))
def test_no_ray_passes_a_wall_between_its_cells(turn: float) -> None:
    way = np.array([np.cos(turn), np.sin(turn)])
    center = np.array([40.3, 40.6])
    blocked = cells_on_segments([[center - 38 * way, center + 38 * way]], shape=(80, 80))
    side = center + 9.0 * np.array([-way[1], way[0]])
    counts = rays_per_cell(fans_of([side], reaches=30.0), blocked)
    rows, columns = np.nonzero(counts)
    beyond = (np.column_stack([columns, rows]) + 0.5 - center) @ [-way[1], way[0]]
    assert beyond.min() > -0.75


def test_without_fans_no_cell_is_reached() -> None:
    assert not rays_per_cell(join_fans([]), np.zeros((2, 3), dtype=np.bool_)).any()
