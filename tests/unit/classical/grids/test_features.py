import numpy as np

from echoplan.arrays import FloatArray
from echoplan.classical.grids import GridFeatureSettings, features_of_grid, free_sides, occupied_cells
from echoplan.model import OccupancyGrid

RESOLUTION = 0.05


def room(*, low: tuple[int, int] = (10, 10), high: tuple[int, int] = (60, 80)) -> OccupancyGrid:
    """A room whose walls are one cell thick; nothing is known outside."""
    values = np.full((80, 100), 0.5)
    values[low[0] : high[0] + 1, low[1] : high[1] + 1] = 0.9
    values[low[0] + 1 : high[0], low[1] + 1 : high[1]] = 0.1
    return OccupancyGrid(origin_xy=np.array([-1.0, 2.0]), resolution=RESOLUTION, values=values)


def ends_of_walls(grid: OccupancyGrid) -> FloatArray:
    walls = features_of_grid(grid, GridFeatureSettings()).walls
    return np.array([wall.endpoints_xy for wall in walls]).reshape(-1, 2)


def test_the_walls_of_a_room_go_through_the_middle_of_their_cells() -> None:
    found = features_of_grid(room(), GridFeatureSettings())
    assert len(found.walls) == len(found.corners) == 4
    assert not found.cylinders
    low, high = room().centers_xy[10, 10], room().centers_xy[60, 80]
    corners = np.array([corner.position_xy for corner in found.corners])
    assert np.abs(np.sort(corners[:, 0]) - [low[0], low[0], high[0], high[0]]).max() < 0.01
    assert np.abs(np.sort(corners[:, 1]) - [low[1], low[1], high[1], high[1]]).max() < 0.01


def test_free_space_on_the_inner_side_makes_corners_concave_and_on_the_outer_side_convex() -> None:
    inverted = OccupancyGrid(
        origin_xy=room().origin_xy, resolution=RESOLUTION, values=np.where(room().values == 0.1, 0.5, room().values)
    )
    outside = np.where(inverted.values == 0.5, 0.1, inverted.values)
    outside[11:60, 11:80] = 0.5
    box = OccupancyGrid(origin_xy=room().origin_xy, resolution=RESOLUTION, values=outside)
    kinds = [
        {corner.kind.value for corner in features_of_grid(grid, GridFeatureSettings()).corners}
        for grid in (room(), box)
    ]
    assert kinds == [{"concave"}, {"convex"}]


def test_free_sides_point_to_the_free_cells_and_nowhere_where_there_are_none() -> None:
    grid = room()
    sides = free_sides(grid, np.array([[10, 40], [30, 10], [30, 80], [0, 0]]))
    assert np.sign(sides.round(9)).tolist() == [[0.0, 1.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 0.0]]


def test_only_cells_likelier_than_the_threshold_are_occupied() -> None:
    grid = OccupancyGrid(origin_xy=np.zeros(2), resolution=1.0, values=np.array([[0.65, 0.66], [0.2, 1.0]]))
    assert occupied_cells(grid, 0.65).tolist() == [[0, 1], [1, 1]]


def test_an_unknown_grid_has_no_features() -> None:
    unknown = OccupancyGrid(origin_xy=np.zeros(2), resolution=RESOLUTION, values=np.full((3, 4), 0.5))
    found = features_of_grid(unknown, GridFeatureSettings())
    assert (found.walls, found.corners, found.cylinders) == ((), (), ())


def test_a_round_pillar_is_a_cylinder() -> None:
    grid = OccupancyGrid(origin_xy=np.zeros(2), resolution=0.02, values=np.full((60, 60), 0.1))
    away = np.hypot(*(grid.centers_xy - [0.6, 0.62]).transpose(2, 0, 1))
    drawn = OccupancyGrid(
        origin_xy=grid.origin_xy, resolution=0.02, values=np.where(np.abs(away - 0.15) < 0.012, 0.9, grid.values)
    )
    found = features_of_grid(drawn, GridFeatureSettings())
    assert not found.walls
    assert len(found.cylinders) == 1
    assert np.abs(found.cylinders[0].center_xy - [0.6, 0.62]).max() < 0.01
    assert abs(found.cylinders[0].radius - 0.15) < 0.01


def test_walls_end_where_their_cells_end() -> None:
    values = np.full((40, 60), 0.1)
    values[20, 10:50] = 0.95
    grid = OccupancyGrid(origin_xy=np.zeros(2), resolution=RESOLUTION, values=values)
    x, y = np.sort(ends_of_walls(grid), axis=0).T
    assert np.abs(x - [0.525, 2.475]).max() < 0.06
    assert np.abs(y - 1.025).max() < 0.01
