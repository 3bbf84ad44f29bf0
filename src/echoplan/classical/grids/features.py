"""Features of a grid: walls, corners and cylinders among its occupied cells."""

import numpy as np
from pydantic import Field

from echoplan.arrays import FloatArray, IntArray
from echoplan.classical.points import PointFeatures, PointFeatureSettings, SegmentSettings, features_of_points
from echoplan.model import OccupancyGrid
from echoplan.settings import Settings

__all__ = ["GridFeatureSettings", "features_of_grid", "free_sides", "occupied_cells"]

# Neighbourhood [cells] that decides from which side a cell was observed.
_AROUND = 3


class GridFeatureSettings(Settings):
    """Which cells are occupied, and what makes features of them."""

    occupied: float = Field(
        default=0.65,
        gt=0.5,
        lt=1.0,
        description="Probability above which a cell is occupied: the threshold of map_server of ROS.",
    )
    # Cells of 5 cm lie up to a cell beside their wall, and all of one row err alike.
    points: PointFeatureSettings = Field(
        default_factory=lambda: PointFeatureSettings(
            segments=SegmentSettings(band=0.05, common_sigma=0.05 / np.sqrt(12.0))
        ),
        description="Extraction of features from the centres of cells; the bands are those of cells of 5 cm.",
    )


def features_of_grid(grid: OccupancyGrid, settings: GridFeatureSettings) -> PointFeatures:
    """Find walls, corners and cylinders on a grid.

    Parameters
    ----------
    grid : OccupancyGrid
        The grid.
    settings : GridFeatureSettings
        Which cells are occupied, and what makes features of them.

    Returns
    -------
    PointFeatures
        Features of the centres of the occupied cells, each weighted by how far it is from unknown.

    Examples
    --------
    >>> values = np.full((20, 60), 0.1)
    >>> values[10, 5:55] = 0.9
    >>> grid = OccupancyGrid(origin_xy=[0, 0], resolution=0.05, values=values)
    >>> (wall,) = features_of_grid(grid, GridFeatureSettings()).walls
    >>> round(abs(wall.offset), 3), round(wall.length, 2)
    (0.525, 2.45)
    """
    cells = occupied_cells(grid, settings.occupied)
    rows, columns = cells.T
    points = grid.centers_xy[rows, columns]
    weights = 2.0 * grid.values[rows, columns] - 1.0
    return features_of_points(points, weights, settings.points, origins_xy=points + free_sides(grid, cells))


def occupied_cells(grid: OccupancyGrid, threshold: float) -> IntArray:
    """Choose the cells that are occupied.

    Parameters
    ----------
    grid : OccupancyGrid
        The grid.
    threshold : float
        Likelier cells are occupied.

    Returns
    -------
    ndarray of int, shape (n, 2)
        Row and column of each.

    Examples
    --------
    >>> grid = OccupancyGrid(origin_xy=[0, 0], resolution=0.05, values=[[0.5, 0.9], [0.1, 0.6]])
    >>> occupied_cells(grid, 0.65)
    array([[0, 1]])
    """
    return np.argwhere(grid.values > threshold)


def free_sides(grid: OccupancyGrid, cells: IntArray) -> FloatArray:
    """Find on which side of cells there is free space.

    Parameters
    ----------
    grid : OccupancyGrid
        The grid.
    cells : ndarray of int, shape (n, 2)
        Row and column of each cell.

    Returns
    -------
    ndarray, shape (n, 2)
        Towards the middle of the free cells around each [m]; no way at all where there is none.

    Examples
    --------
    >>> grid = OccupancyGrid(origin_xy=[0, 0], resolution=1.0, values=[[0.5, 0.9, 0.0]])
    >>> free_sides(grid, np.array([[0, 1]]))
    array([[0.5, 0. ]])
    """
    free = np.pad(np.maximum(0.5 - grid.values, 0.0), _AROUND)
    steps = np.stack(np.meshgrid(*[np.arange(-_AROUND, _AROUND + 1)] * 2, indexing="ij"), axis=-1).reshape(-1, 2)
    around = free[tuple(np.moveaxis(cells[:, None] + _AROUND + steps, -1, 0))]
    sides: FloatArray = grid.resolution * around @ steps[:, ::-1]
    return sides
