from dataclasses import replace
from math import isnan, nan

import numpy as np
import pytest
from scipy.ndimage import label

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.evaluation import GridScore, pool_grid_scores, score_grid, true_grid
from echoplan.model import OccupancyGrid, Truth
from helpers import maps

RESOLUTION = 0.1


def unknown(value: float = 0.5) -> OccupancyGrid:
    """Cells about the room of the truth by hand, all alike."""
    return OccupancyGrid(origin_xy=np.array([-0.55, -0.55]), resolution=RESOLUTION, values=np.full((41, 61), value))


def drawn(values: FloatArray) -> OccupancyGrid:
    return replace(unknown(), values=values)


def at(grid: OccupancyGrid, *point: float) -> float:
    return float(grid.values[tuple(grid.cells_of(point))])


def test_walls_and_cylinders_are_occupied_what_is_seen_is_free_and_the_rest_unknown() -> None:
    wanted = true_grid(maps.ROOM, unknown())
    on_walls = [(2.5, 0.0), (0.0, 1.5), (5.0, 0.7), (1.0, 3.0)]
    assert {at(wanted, *point) for point in on_walls} == {1.0}
    assert at(wanted, 3.6, 0.6) == 1.0
    assert at(wanted, 1.5, 1.0) == at(wanted, 0.5, 2.5) == 0.0
    # Outside, round the corner of the L, in a column and in its shadow.
    assert {at(wanted, *point) for point in ((5.3, 1.0), (4.0, 2.5), (3.5, 0.6), (4.4, 0.45), (1.0, 2.5))} == {0.5}


def test_free_cells_beyond_the_reach_do_not_count_but_walls_do() -> None:
    near = true_grid(maps.ROOM, unknown(), reach=0.5)
    assert at(near, 1.4, 1.0) == 0.0
    assert at(near, 1.6, 1.0) == 0.5
    assert at(near, 4.5, 0.0) == 1.0
    assert score_grid(near, maps.ROOM, reach=0.5).error == 0.0
    assert score_grid(near, maps.ROOM).free > 0.3


def test_a_face_along_the_border_of_cells_is_in_both_rows_and_one_through_their_middle_in_one() -> None:
    wide = OccupancyGrid(origin_xy=np.array([-0.5, -0.5]), resolution=RESOLUTION, values=np.full((40, 60), 0.5))
    thickness = [int((true_grid(maps.ROOM, grid).values[:12, 30] == 1.0).sum()) for grid in (unknown(), wide)]
    assert thickness == [1, 2]


@pytest.mark.parametrize("rise", [0.0, 0.3, 0.71, 1.0, 2.6])
def test_no_way_leads_from_cell_to_cell_through_a_wall(rise: float) -> None:
    across = np.array([[[-9.0, 1.5 - 11.6 * rise], [14.0, 1.5 + 11.4 * rise]]])
    slanted = Truth(walls_xy=across, walls_detected_by=np.array([1]))
    ways, count = label(true_grid(slanted, unknown()).values != 1.0)
    assert count == 2
    assert ways[0, -1] != ways[-1, 0]


def test_the_true_grid_scores_zero_an_unknown_one_half_and_the_opposite_one() -> None:
    wanted = true_grid(maps.ROOM, unknown()).values
    errors = [
        (score.occupied, score.free, score.error, score.balanced_error)
        for score in (
            score_grid(drawn(values), maps.ROOM) for values in (wanted, np.full_like(wanted, 0.5), 1 - wanted)
        )
    ]
    assert errors == [(0.0,) * 4, (0.5,) * 4, (1.0,) * 4]


def test_the_error_is_murphys_sum_over_the_cells_that_count() -> None:
    values = np.random.default_rng(0).random((41, 61))
    wanted = true_grid(maps.ROOM, unknown()).values
    counts = wanted != 0.5
    score = score_grid(drawn(values), maps.ROOM)
    assert score.occupied_cells + score.free_cells == counts.sum()
    assert score.error == pytest.approx(np.abs(wanted - values)[counts].mean())
    assert score.balanced_error == pytest.approx((score.occupied + score.free) / 2)


def test_cells_that_no_station_can_see_do_not_count() -> None:
    values = true_grid(maps.ROOM, unknown()).values.copy()
    values[values == 0.5] = 0.99
    assert score_grid(drawn(values), maps.ROOM).error == 0.0


def test_without_poses_nothing_is_known_to_be_free() -> None:
    blind = replace(maps.ROOM, poses=np.zeros((0, 3)), given=np.zeros((0, 3)))
    score = score_grid(unknown(0.9), blind)
    assert isnan(score.free)
    assert score.error == score.occupied == pytest.approx(0.1)
    assert isnan(score.balanced_error)


def test_a_grid_far_from_the_true_walls_has_no_information() -> None:
    for corner in ([50.0, 50.0], [-50.0, 0.0]):
        away = OccupancyGrid(origin_xy=np.array(corner), resolution=RESOLUTION, values=np.full((3, 4), 0.9))
        score = score_grid(away, maps.ROOM)
        assert (score.occupied, score.free) == (0.5, 0.5)
        assert score.free_cells > 500


@pytest.mark.parametrize("away", [0, 4, 40])
def test_how_far_a_grid_goes_beyond_the_room_changes_nothing(away: int) -> None:
    grid = drawn(np.random.default_rng(1).random((41, 61)))
    origin = grid.origin_xy - away * RESOLUTION
    wider = replace(grid, origin_xy=origin, values=np.pad(grid.values, away, constant_values=0.5))
    assert score_grid(wider, maps.ROOM) == score_grid(grid, maps.ROOM)


def test_walls_that_a_grid_lacks_count_as_unknown() -> None:
    right = true_grid(maps.ROOM, unknown())
    half = replace(right, values=right.values[:20])
    whole, part = score_grid(right, maps.ROOM), score_grid(half, maps.ROOM)
    assert (whole.error, whole.occupied_cells) == (0.0, part.occupied_cells)
    assert 0.1 < part.occupied < 0.5


def test_pooled_scores_are_those_of_all_cells_together() -> None:
    few = GridScore(occupied=0.2, free=0.4, occupied_cells=10, free_cells=30)
    many = GridScore(occupied=0.6, free=nan, occupied_cells=30, free_cells=0)
    pooled = pool_grid_scores([few, many])
    assert pooled.occupied == pytest.approx(0.5)
    assert pooled.free == pytest.approx(0.4)
    assert (pooled.occupied_cells, pooled.free_cells) == (40, 30)
    assert isnan(pool_grid_scores([]).error)


def test_a_truth_that_ends_far_away_is_refused() -> None:
    far = Truth(walls_xy=np.array([[[0.0, 0.0], [1e5, 1e5]]]), walls_detected_by=np.array([1]))
    with pytest.raises(InvalidValueError, match="check the truth or choose a greater resolution"):
        score_grid(unknown(), far)
