import math
from functools import cache

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import compose, wrap
from echoplan.joint.arcs import ArcSettings, find_arcs
from echoplan.joint.search.global_search import apart, find_poses, pose_grid
from echoplan.joint.search.scan_matching import LandmarkMap, LocalisationSettings, LocalScan, local_scans
from helpers.expectations import ROOM, SONAR, cylinder, landmark_map, listening, pings_of

SETTINGS = LocalisationSettings()
# A room of 4 x 3 m about the origin, with and without a column that makes it asymmetric.
COLUMN = cylinder(0.2, 0.9, 0.1)
HERE, OPPOSITE = np.array([0.43, -0.31, 0.5]), np.array([-0.43, 0.31, 0.5 - math.pi])
CORNERS = np.array([[-2.0, -1.5], [2.0, 1.5]])
NO_ARCS = LocalScan(np.zeros((0, 2)), np.zeros(0), np.zeros(0), np.zeros(0))


def room(*more: FloatArray) -> LandmarkMap:
    return landmark_map(np.array([*ROOM, *more]))


@cache
def scan_of(*, column: bool) -> LocalScan:
    """The arcs of a sonar that the model predicts at HERE."""
    x, y, _ = HERE.tolist()
    measurements = pings_of(listening([(x, y)], step=np.radians(1.0)), [*ROOM, COLUMN] if column else ROOM)
    arcs = find_arcs(measurements, resolution=0.001, settings=ArcSettings())
    return local_scans(arcs, measurements, SONAR.tabulated(), HERE)


def found(scan: LocalScan, landmark_map: LandmarkMap) -> tuple[FloatArray, FloatArray]:
    return find_poses(scan, landmark_map, grid=pose_grid(CORNERS), settings=SETTINGS)


def assert_same_pose(pose: FloatArray, true: FloatArray) -> None:
    assert pose[:2] == pytest.approx(true[:2], abs=0.012)
    assert abs(float(wrap(pose[2] - true[2]))) < np.radians(1.0)


@pytest.mark.parametrize("seed", range(5))
def test_every_pose_in_the_rectangle_has_a_near_one_in_the_grid(seed: int) -> None:
    low, high = np.array([-1.0, 2.0]), np.array([1.3, 2.9])
    grid = pose_grid(np.array([[1.3, 2.0], [-1.0, 2.4], [0.0, 2.9]]))
    x, y, yaw = np.random.default_rng(seed).uniform([*low, -math.pi], [*high, math.pi])
    away = np.column_stack([np.abs(grid[:, :2] - [x, y]), np.abs(wrap(grid[:, 2] - yaw))])
    # Half a step: 7.5 cm along each axis and 3 degrees.
    assert (away < [0.0751, 0.0751, np.radians(3.01)]).all(axis=1).any()


def test_the_grid_ends_with_the_rectangle_and_has_each_pose_once() -> None:
    grid = pose_grid(np.array([[0.0, 1.0], [0.5, 2.0]]))
    assert grid[:, :2].min(axis=0) == pytest.approx([0.0, 1.0])
    assert (grid[:, :2].max(axis=0) < [0.5 + 0.15, 2.0 + 0.15]).all()
    turned = np.column_stack([grid[:, :2], np.cos(grid[:, 2]), np.sin(grid[:, 2])])
    assert len(np.unique(turned.round(6), axis=0)) == len(grid)


def test_walls_on_one_line_have_a_grid_along_it() -> None:
    grid = pose_grid(np.array([[0.0, 1.0], [3.0, 1.0]]))
    assert np.unique(grid[:, 1].round(9)).tolist() == [1.0]
    assert np.ptp(grid[:, 0]) >= 3.0


def test_the_grid_of_a_map_that_is_too_large_is_empty() -> None:
    assert pose_grid(np.array([[0.0, 0.0], [35.0, 35.0]])).shape[0] > 1e6
    assert pose_grid(np.array([[0.0, 0.0], [60.0, 60.0]])).shape == (0, 3)


def test_of_poses_side_by_side_the_best_is_kept() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [0.03, 0.0, 0.05], [1.0, 0.0, 0.0], [1.0, 0.04, -0.05]])
    assert apart(poses, np.array([1.0, 2.0, 4.0, 3.0]), most=9) == [2, 1]


def test_poses_as_far_apart_as_a_partition_is_thick_are_kept() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0]])
    assert apart(poses, np.array([1.0, 2.0]), most=9) == [1, 0]


def test_poses_in_one_place_are_kept_if_their_directions_differ() -> None:
    poses = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, np.radians(8.0)], [0.0, 0.0, np.radians(4.0)]])
    assert apart(poses, np.array([3.0, 2.0, 1.0]), most=9) == [0, 1]


def test_directions_on_both_sides_of_half_a_turn_are_near() -> None:
    poses = np.array([[0.0, 0.0, np.radians(178.0)], [0.0, 0.0, np.radians(-178.0)]])
    assert apart(poses, np.array([1.0, 2.0]), most=9) == [1]


def test_no_more_poses_are_kept_than_are_wanted() -> None:
    poses = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])
    assert apart(poses, np.array([1.0, 5.0, 3.0, 4.0, 2.0]), most=3) == [1, 3, 2]


def test_of_no_poses_none_is_kept() -> None:
    assert apart(np.zeros((0, 3)), np.zeros(0), most=3) == []


def test_the_true_pose_fits_best_in_an_asymmetric_room() -> None:
    poses, scores = found(scan_of(column=True), room(COLUMN))
    assert_same_pose(poses[0], HERE)
    # All five arcs fit here; one of them, the column, does not after half a turn.
    assert scores[0] - scores[1] > 2.0


def test_both_poses_in_a_rectangle_fit_equally_well() -> None:
    poses, scores = found(scan_of(column=False), room())
    one, other = sorted(poses[:2], key=lambda pose: float(-pose[0]))
    assert_same_pose(one, HERE)
    assert_same_pose(other, OPPOSITE)
    assert scores[1] == pytest.approx(scores[0], abs=1.0)
    assert scores[0] - scores[2:].max() > 2.0


def test_the_map_may_be_anywhere() -> None:
    # The same room in a frame that is turned by 90 degrees and 30 m away.
    moved = np.array([30.0, -20.0, math.pi / 2])
    reflectors = room(COLUMN).reflectors.copy()
    reflectors[:4, 1] += moved[2]
    normals = np.column_stack([np.cos(reflectors[:4, 1]), np.sin(reflectors[:4, 1])])
    reflectors[:4, 2] += normals @ moved[:2]
    reflectors[4, 1:3] = compose(moved, [*COLUMN[1:3], 0.0])[:2]
    far = room(COLUMN)._replace(reflectors=reflectors, extents=np.tile([-60.0, 60.0], (5, 1)))
    grid = pose_grid(np.array([[28.5, -22.0], [31.5, -18.0]]))
    poses, _ = find_poses(scan_of(column=True), far, grid=grid, settings=SETTINGS)
    assert_same_pose(poses[0], compose(moved, HERE))


def test_poses_are_apart_and_the_best_come_first() -> None:
    poses, scores = found(scan_of(column=True), room(COLUMN))
    assert len(poses) == len(scores) > 1
    assert (np.diff(scores) <= 0.0).all()
    assert apart(poses, scores, most=len(poses)) == list(range(len(poses)))


def test_without_arcs_no_pose_fits() -> None:
    poses, scores = found(NO_ARCS, room(COLUMN))
    assert (poses.shape, scores.shape) == ((0, 3), (0,))


def test_in_an_empty_grid_no_pose_fits() -> None:
    poses, scores = find_poses(scan_of(column=True), room(COLUMN), grid=np.zeros((0, 3)), settings=SETTINGS)
    assert (poses.shape, scores.shape) == ((0, 3), (0,))


def test_beside_the_ends_of_all_walls_no_pose_fits() -> None:
    beside = room()._replace(extents=np.tile([5.0, 6.0], (4, 1)))
    poses, _ = found(scan_of(column=False), beside)
    assert len(poses) == 0
