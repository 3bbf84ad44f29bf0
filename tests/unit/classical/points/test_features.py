import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.points import PointFeatures, PointFeatureSettings, features_of_points
from echoplan.errors import InvalidValueError
from echoplan.geometry import directions
from echoplan.model import CornerKind

# An oblong room that does not hold the origin in its middle, with a column off its axes.
CORNERS = np.array([[-1.0, 0.5], [2.0, 0.5], [2.0, 2.3], [-1.0, 2.3]])
COLUMN = (0.2, 1.1, 0.12)


def room(*, spacing: float = 0.05) -> FloatArray:
    faces = [face(start, end, spacing) for start, end in zip(CORNERS, np.roll(CORNERS, -1, axis=0), strict=True)]
    return np.concatenate([*faces, COLUMN[:2] + COLUMN[2] * directions(np.linspace(0, 6, 25))])


def face(start: FloatArray, end: FloatArray, spacing: float) -> FloatArray:
    shares = np.linspace(0.05, 0.95, round(float(np.hypot(*(end - start))) / spacing))[:, None]
    points: FloatArray = start + shares * (end - start)
    return points


def found(points: FloatArray, *, origins_xy: FloatArray | None = None) -> PointFeatures:
    return features_of_points(points, np.ones(len(points)), origins_xy=origins_xy)


def test_a_room_has_its_walls_corners_and_column() -> None:
    features = found(room())
    assert len(features.walls) == 4
    corners = sorted(tuple(corner.position_xy.round(6)) for corner in features.corners)
    assert corners == sorted(map(tuple, CORNERS))
    assert [corner.kind for corner in features.corners] == [CornerKind.CONCAVE] * 4
    (column,) = features.cylinders
    assert (*column.center_xy, column.radius) == pytest.approx(COLUMN)


def test_normals_point_away_from_where_one_stood() -> None:
    for wall in found(room()).walls:
        assert wall.normal_xy @ CORNERS.mean(axis=0) < wall.offset


def test_walls_end_in_their_corners() -> None:
    ends = np.concatenate([wall.endpoints_xy for wall in found(room()).walls])
    gaps = np.hypot(*(ends[:, None] - CORNERS[None]).transpose(2, 0, 1)).min(axis=1)
    assert gaps == pytest.approx(0.0, abs=1e-9)


def test_a_box_detected_from_outside_has_convex_corners() -> None:
    points = room()[:-25]
    outside = CORNERS.mean(axis=0) + 3 * (points - CORNERS.mean(axis=0))
    features = found(points, origins_xy=outside)
    assert [corner.kind for corner in features.corners] == [CornerKind.CONVEX] * 4


def test_a_map_turns_and_moves_with_its_points() -> None:
    turn = directions(0.5)
    rotation = np.array([[turn[0], -turn[1]], [turn[1], turn[0]]])
    moved = found(room() @ rotation.T + [3.0, -7.0])
    corners = sorted(tuple(corner.position_xy.round(5)) for corner in moved.corners)
    assert corners == sorted(map(tuple, (CORNERS @ rotation.T + [3.0, -7.0]).round(5)))
    assert len(moved.cylinders) == 1


def test_covariances_are_positive_definite() -> None:
    features = found(room())
    covariances = [wall.covariance for wall in features.walls]
    covariances += [corner.covariance for corner in features.corners]
    covariances += [column.covariance for column in features.cylinders]
    assert len(covariances) == 9
    assert all(np.linalg.eigvalsh(covariance).min() > 0 for covariance in covariances)


def test_noise_moves_little_and_adds_nothing() -> None:
    rng = np.random.default_rng(8)
    points = np.concatenate([room(spacing=0.02) + rng.normal(0, 0.008, (505, 2)), rng.uniform(-1, 2, size=(20, 2))])
    features = found(points)
    assert len(features.walls) == 4
    corners = np.array([corner.position_xy for corner in features.corners])
    gaps = np.hypot(*(corners[:, None] - CORNERS[None]).transpose(2, 0, 1)).min(axis=1)
    assert len(corners) == 4
    assert gaps.max() < 0.015


def test_points_without_weight_are_as_if_they_were_not() -> None:
    points = room()
    weights = np.append(np.ones(len(points)), np.zeros(30))
    stray = np.column_stack([np.linspace(0, 1, 30), np.linspace(1, 2, 30)])
    with_strays = features_of_points(np.concatenate([points, stray]), weights)
    assert len(with_strays.walls) == 4


def test_weights_count_like_points() -> None:
    points = room()
    twice = features_of_points(points, np.full(len(points), 2.0))
    again = found(np.concatenate([points, points]))
    assert [wall.offset for wall in twice.walls] == pytest.approx([wall.offset for wall in again.walls])
    for one, other in zip(twice.walls, again.walls, strict=True):
        assert one.covariance == pytest.approx(other.covariance)


def test_features_record_from_how_many_stations_they_were_detected() -> None:
    points = room()
    features = features_of_points(points, np.ones(len(points)), sweeps=np.arange(len(points)) % 5)
    assert [wall.stations for wall in features.walls] == [5] * 4
    assert [column.stations for column in features.cylinders] == [5]
    assert [wall.stations for wall in found(points).walls] == [0] * 4


def test_what_only_one_station_detected_is_no_feature() -> None:
    points = room()
    # Two walls and the column were detected in the first sweep only.
    sweeps = np.where((points[:, 1] > 0.51) & (points[:, 0] < 1.99), 0, np.arange(len(points)) % 2)
    features = features_of_points(points, np.ones(len(points)), sweeps=sweeps)
    assert len(features.walls) == 2
    assert features.cylinders == ()
    once = PointFeatureSettings(min_stations=1)
    assert len(features_of_points(points, np.ones(len(points)), once, sweeps=sweeps).walls) == 4


def test_points_in_another_order_show_the_same() -> None:
    points = room() + np.random.default_rng(9).normal(0, 0.005, (len(room()), 2))
    order = np.random.default_rng(10).permutation(len(points))
    one, other = found(points), found(points[order])
    for wall, same in zip(one.walls, other.walls, strict=True):
        assert (wall.normal_angle, wall.offset) == pytest.approx((same.normal_angle, same.offset))
    assert len(one.corners) == len(other.corners) == 4


def test_a_room_far_from_the_origin_and_a_point_far_from_the_room_cost_nothing() -> None:
    away = np.array([4.5e5, 5.2e6])
    points = np.concatenate([room() + away, [[0.0, 0.0]]])
    features = found(points)
    assert len(features.walls) == 4
    assert len(features.cylinders) == 1


def test_without_weighted_points_there_are_no_features() -> None:
    assert found(np.zeros((0, 2))) == PointFeatures()
    assert features_of_points(np.ones((3, 2)), np.zeros(3)) == PointFeatures()


def test_what_cannot_be_points_is_refused() -> None:
    with pytest.raises(InvalidValueError, match="points_xy must be finite"):
        found(np.array([[np.nan, 0.0]]))
    with pytest.raises(InvalidValueError, match="weights"):
        features_of_points(np.ones((2, 2)), np.ones(3))
    with pytest.raises(InvalidValueError, match="weights must be positive"):
        features_of_points(np.ones((2, 2)), np.array([1.0, -1.0]))
