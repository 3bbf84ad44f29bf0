"""Grids of feature maps made by hand: what is occupied, what is free, and where a robot may plan."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import ArrayLike

from echoplan.errors import InvalidValueError
from echoplan.grids import MapGridSettings, grid_from_map
from echoplan.model import FeatureMap, OccupancyGrid, Opening, Rig, Sensor, Sweep, UnobservedStretch
from helpers.maps import corner, cylinder, drawn, wall
from helpers.planning import CLOSED, OUTSIDE, TWO_ROOMS, is_free, path_exists

RIG = Rig(name="one", sensors=(Sensor(sensor_id=0, half_aperture=0.3, min_range=0.03, max_range=4.0, resolution=0.01),))


def sweep(ranges: Sequence[float], *, index: int = 0, poses: ArrayLike = (0.0, 0.0, 0.0)) -> Sweep:
    """Pings of the one sensor, which looks ahead."""
    count = len(ranges)
    return Sweep(
        index=index,
        stamps_ns=np.arange(count),
        sensor_ids=np.zeros(count, dtype=np.int64),
        servo_angles=np.zeros(count),
        ranges=np.array(ranges),
        map_from_base=np.broadcast_to(poses, (count, 3)),
    )


def ahead(
    *walls: float, ranges: Sequence[float] = (2.0, 2.0), pose: Sequence[float] = (0.0, 0.0, 0.0)
) -> OccupancyGrid:
    """The grid of walls across the x axis, of pings from the origin, and of the corrected pose of their sweep."""
    feature_map = drawn(*(wall([x, -2], [x, 2]) for x in walls), poses=[pose])
    return grid_from_map(feature_map, rig=RIG, sweeps=[sweep(ranges)])


def count(grid: OccupancyGrid, value: float) -> int:
    return int((grid.values == value).sum())


def test_a_robot_finds_a_way_through_a_door_and_none_through_walls() -> None:
    grid = grid_from_map(TWO_ROOMS)
    assert path_exists(grid, [1.0, 1.0], [5.0, 3.0])
    # The door is 0.8 m wide.
    assert not path_exists(grid, [1.0, 1.0], [5.0, 3.0], radius=0.5)
    assert not path_exists(grid_from_map(CLOSED), [1.0, 1.0], [5.0, 3.0], radius=0.0)


@pytest.mark.parametrize("resolution", [0.02, 0.05, 0.11])
@pytest.mark.parametrize("turn", [0.0, 0.3, 1.0])
def test_nothing_outside_closed_walls_is_free_however_they_lie_on_the_cells(turn: float, resolution: float) -> None:
    cosine, sine = np.cos(turn), np.sin(turn)
    rotation = np.array([[cosine, -sine], [sine, cosine]])
    walls = [wall(*(each.endpoints_xy @ rotation.T)) for each in OUTSIDE]
    grid = grid_from_map(
        drawn(*walls, poses=[[*(rotation @ [3.0, 2.0]), 0.0]]), settings=MapGridSettings(resolution=resolution)
    )
    x, y = np.moveaxis(grid.centers_xy @ rotation, -1, 0)
    inside = (x > 0) & (x < 6) & (y > 0) & (y < 4)
    assert not (grid.values[~inside] == 0.0).any()
    deep = (x > 0.2) & (x < 5.8) & (y > 0.2) & (y < 3.8)
    # Rays reach 5 m, and the corners are 3.6 m away.
    assert (grid.values[deep] == 0.0).all()


def test_inferred_pieces_of_walls_are_occupied() -> None:
    inferred = replace(wall([2, -1], [2, 1]), inferred=np.array([0.9, 0.9]))
    assert count(grid_from_map(drawn(inferred)), 1.0) == count(grid_from_map(drawn(wall([2, -1], [2, 1]))), 1.0) == 41


def test_cylinders_are_discs_and_thin_poles_and_corners_a_cell() -> None:
    assert count(grid_from_map(drawn(cylinder([1.0, 1.0], 0.5))), 1.0) * 0.05**2 == pytest.approx(0.79, abs=0.15)
    assert count(grid_from_map(drawn(cylinder([1.02, 1.02], 0.005))), 1.0) == 1
    assert count(grid_from_map(drawn(corner([1.02, 1.02]))), 1.0) == 1


def test_an_opening_is_free_and_an_unobserved_stretch_is_unknown_and_ends_rays() -> None:
    gap = np.array([[2.0, -0.5], [2.0, 0.5]])
    pieces = [wall([2, -2], [2, -0.5]), wall([2, 0.5], [2, 2]), wall([3, -2], [3, 2])]
    plain = drawn(*pieces, poses=[[0.0, 0.0, 0.0]])
    opened = grid_from_map(replace(plain, openings=(Opening(endpoints_xy=gap, width_sigma=0.0, walls=(0, 1)),)))
    assert is_free(opened, [2.0, 0.0])
    assert is_free(opened, [2.5, 0.0])
    unseen = grid_from_map(replace(plain, unobserved=(UnobservedStretch(endpoints_xy=gap, walls=(0, 1)),)))
    assert is_free(unseen, [1.9, 0.0])
    assert not is_free(unseen, [2.0, 0.0])
    assert not is_free(unseen, [2.5, 0.0])


def test_what_lies_before_an_echo_is_free_and_what_lies_behind_it_or_beside_the_beam_is_unknown() -> None:
    grid = ahead(2.0)
    assert is_free(grid, [1.8, 0.0])
    assert not is_free(grid, [1.95, 0.0])
    assert not is_free(grid, [1.0, 0.4])
    assert not is_free(grid, [-0.5, 0.0])


def test_a_reading_beyond_a_wall_frees_nothing_behind_it() -> None:
    grid = ahead(2.0, 3.5, ranges=[3.5] * 9)
    assert is_free(grid, [1.9, 0.0])
    assert not is_free(grid, [2.5, 0.0])


def test_beams_in_which_the_map_has_nothing_free_nothing() -> None:
    assert not is_free(ahead(-1.0), [1.0, 0.0])
    # The sensor reaches 4 m.
    assert not is_free(ahead(4.5), [1.0, 0.0])


@pytest.mark.parametrize("ranges", [[np.inf] * 9, [4.0] * 9, [np.nan] * 9, [-np.inf] * 9, [0.01] * 9, [2.0]])
def test_pings_without_an_echo_and_a_single_ping_free_nothing(ranges: list[float]) -> None:
    assert not is_free(ahead(2.0, ranges=ranges), [1.0, 0.0])


def test_pings_clear_cells_from_the_corrected_pose_of_their_sweep() -> None:
    grid = ahead(2.0, pose=[2.5, 0.5, np.pi])
    assert not is_free(grid, [1.0, 0.0])
    grid = ahead(-2.0, ranges=[1.5, 1.5], pose=[0.0, 0.5, np.pi])
    assert is_free(grid, [-1.0, 0.5])


def test_sweeps_that_are_not_in_the_map_are_skipped() -> None:
    feature_map = drawn(wall([2, -2], [2, 2]), poses=[[0.0, 0.0, 0.0]])
    grid = grid_from_map(feature_map, rig=RIG, sweeps=[sweep([2.0, 2.0], index=7), sweep([])])
    assert not is_free(grid, [1.0, 0.0])


def test_the_path_of_the_robot_is_free_as_wide_as_the_robot_but_not_through_walls() -> None:
    way = drawn(wall([2, -2], [2, 2]), poses=[[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]])
    drive = [sweep([np.inf]), sweep([np.inf], index=1)]
    thin = grid_from_map(way, rig=RIG, sweeps=drive)
    assert is_free(thin, [1.0, 0.0])
    assert is_free(thin, [3.0, 0.0])
    assert not is_free(thin, [2.0, 0.0])
    assert not is_free(thin, [1.0, 0.2])
    wide = grid_from_map(way, rig=RIG, sweeps=drive, settings=MapGridSettings(robot_radius=0.25))
    assert is_free(wide, [1.0, 0.2])
    assert is_free(wide, [-0.2, 0.0])
    assert not is_free(wide, [1.0, 0.35])


def test_poses_within_a_sweep_are_part_of_the_path() -> None:
    bend = sweep([np.inf] * 3, poses=[[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]])
    grid = grid_from_map(drawn(poses=[[0.0, 1.0, 0.0]]), rig=RIG, sweeps=[bend])
    assert is_free(grid, [0.0, 0.5])
    assert is_free(grid, [0.5, 1.0])
    assert not is_free(grid, [0.5, 0.5])


def test_an_empty_map_is_one_unknown_cell() -> None:
    grid = grid_from_map(FeatureMap(method="none"))
    assert grid.values.tolist() == [[0.5]]
    assert grid_from_map(FeatureMap(method="none"), rig=RIG, sweeps=[]).values.tolist() == [[0.5]]


def test_the_grid_has_the_frame_of_the_map_an_unknown_border_and_cells_on_whole_numbers() -> None:
    grid = grid_from_map(replace(TWO_ROOMS, frame="odom"))
    assert grid.frame == "odom"
    assert (grid.values[:5] == 0.5).all()
    assert (grid.values[:, -5:] == 0.5).all()
    assert grid.origin_xy / grid.resolution == pytest.approx(np.round(grid.origin_xy / grid.resolution), abs=1e-6)


def test_a_map_in_utm_coordinates_has_the_same_cells_as_one_near_the_origin() -> None:
    far = np.array([500_000.0, 5_400_000.0])
    moved = [wall(*(each.endpoints_xy + far)) for each in OUTSIDE]
    grid = grid_from_map(drawn(*moved, poses=[[*(far + np.array([3.02, 2.03])), 0.0]]))
    near = grid_from_map(drawn(*OUTSIDE, poses=[[3.02, 2.03, 0.0]]))
    assert abs(count(grid, 0.0) - count(near, 0.0)) < 300
    assert is_free(grid, far + np.array([3.0, 2.0]))


def test_sweeps_without_a_rig_are_refused() -> None:
    with pytest.raises(InvalidValueError, match="sweeps need the rig that made them"):
        grid_from_map(TWO_ROOMS, sweeps=[])


def test_the_cells_of_a_map_with_a_far_wall_are_larger() -> None:
    grid = grid_from_map(drawn(wall([0, 0], [900, 900])))
    assert grid.resolution == 0.4
    assert grid.values.size <= MapGridSettings().max_cells
    row, column = grid.cells_of([450.0, 450.0])
    assert grid.values[row, column] == 1.0
