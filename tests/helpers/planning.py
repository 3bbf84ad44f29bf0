"""A flat with and without a door, and what a path planner makes of its grid, for tests."""

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

from echoplan.arrays import BoolArray
from echoplan.model import OccupancyGrid, Opening
from helpers.maps import drawn, wall

# Two rooms of 3 m by 4 m; the door between them is 0.8 m wide.
OUTSIDE = [wall([0, 0], [6, 0]), wall([6, 0], [6, 4]), wall([6, 4], [0, 4]), wall([0, 4], [0, 0])]
BESIDE_DOOR = [wall([3, 0], [3, 1.5]), wall([3, 2.3], [3, 4])]
DOOR = Opening(endpoints_xy=np.array([[3.0, 1.5], [3.0, 2.3]]), width_sigma=0.01, walls=(4, 5), passed=True)
POSES = [[1.5, 2.0, 0.0], [2.6, 1.9, 0.0], [3.4, 1.9, 0.0], [4.5, 2.0, 0.0]]
TWO_ROOMS = replace(drawn(*OUTSIDE, *BESIDE_DOOR, poses=POSES), openings=(DOOR,))
CLOSED = drawn(*OUTSIDE, wall([3, 0], [3, 4]), poses=POSES)


def is_free(grid: OccupancyGrid, point_xy: ArrayLike) -> bool:
    """Whether a point lies in a free cell; what lies beyond the grid is unknown."""
    row, column = grid.cells_of(point_xy)
    return bool(grid.contains(point_xy) and grid.values[row, column] == 0.0)


def passable(grid: OccupancyGrid, radius: float) -> BoolArray:
    """Cells whose centre a round robot may take: all cells within its radius are free."""
    free = np.pad(grid.values == 0.0, 1)
    distances = grid.resolution * ndimage.distance_transform_edt(free)
    return np.asarray(distances > radius)[1:-1, 1:-1]


def path_exists(grid: OccupancyGrid, start_xy: ArrayLike, goal_xy: ArrayLike, *, radius: float = 0.15) -> bool:
    """Whether a round robot finds a way between two points, also by diagonal steps."""
    areas, _ = ndimage.label(passable(grid, radius), structure=np.ones((3, 3)))
    first, last = (areas[tuple(grid.cells_of(point))] for point in (start_xy, goal_xy))
    return bool(first > 0 and first == last)
