import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.geometry import compose, invert, wrap
from echoplan.io import builtin_rig
from echoplan.joint.localisation import localise
from echoplan.model import Cylinder, FeatureMap, Localisation, Pillar, Polyline, Route, Sweep, World
from echoplan.simulation import Simulation, SimulationSettings
from helpers import maps

RIG = builtin_rig("rotary-array")
SIDES = [[0.0, 0.0], [4.0, 0.0], [4.0, 2.8], [0.0, 2.8]]
# Covariance of walls [rad, m] and of cylinders [m] of a map.
OF_WALLS, OF_CYLINDERS = np.diag([1e-3, 1e-3]) ** 2, np.diag([1e-3, 1e-3, 1e-3]) ** 2
POSES = np.array([[1.0, 1.0, 0.3], [1.5, 1.3, 0.8], [2.0, 1.5, 0.5], [2.5, 1.2, -0.4], [3.0, 1.0, 0.2]])
FAR = np.array([[2.6, 2.3, -0.5], [2.4, 1.7, -0.3], [2.9, 1.5, 0.8], [3.3, 1.4, 1.5], [3.5, 1.7, 2.2]])

THERE = np.array([[2.1, 1.7, -2.7], [2.1, 1.8, -1.8], [1.6, 1.2, 2.1], [1.7, 0.9, -0.4], [2.1, 1.0, 0.8]])
THERE = np.concatenate([THERE, [[2.2, 1.1, -2.3], [2.5, 1.0, -1.9], [2.8, 0.9, 0.0]]])


def room_map(corners: Sequence[Sequence[float]], *discs: Cylinder) -> FeatureMap:
    pairs = zip(corners, [*corners[1:], corners[0]], strict=True)
    return maps.drawn(*(maps.wall(*pair, covariance=OF_WALLS) for pair in pairs), *discs)


PILLAR = Cylinder(center_xy=np.array([3.2, 2.2]), radius=0.15, covariance=OF_CYLINDERS)
ROOM, EMPTY = room_map(SIDES, PILLAR), room_map(SIDES)


def recorded(
    poses: FloatArray,
    *,
    sides: Sequence[Sequence[float]] = SIDES,
    pillar: bool = True,
    seed: int = 3,
    **settings: Any,
) -> list[Sweep]:
    """Sweeps of a room, with poses in the frame of the first one, as odometry measures them."""
    pillars = (Pillar(center_xy=PILLAR.center_xy, radius=PILLAR.radius),) if pillar else ()
    world = World(name="room", polylines=(Polyline(points_xy=np.array(sides), closed=True),), pillars=pillars)
    using, route = SimulationSettings.model_validate(settings), Route(map_from_base=poses)
    return in_own_frame(list(Simulation(world=world, rig=RIG, route=route, settings=using, seed=seed)))


def in_own_frame(sweeps: Sequence[Sweep]) -> list[Sweep]:
    away = invert(sweeps[0].station)
    return [replace(sweep, map_from_base=compose(away, sweep.map_from_base)) for sweep in sweeps]


@pytest.fixture(scope="module")
def sweeps() -> list[Sweep]:
    return recorded(POSES)


@pytest.fixture(scope="module")
def found(sweeps: list[Sweep]) -> Localisation:
    """The recording in the map of its room, from an unknown start."""
    return localise(sweeps, ROOM, rig=RIG)


def deaf(sweep: Sweep) -> Sweep:
    """The sweep without its echoes."""
    return replace(sweep, ranges=np.full(len(sweep), np.inf))


def distances(found: Localisation, true: FloatArray) -> FloatArray:
    apart: FloatArray = np.hypot(*(found.poses - true)[:, :2].T)
    return apart


def squared_mahalanobis_distances(found: Localisation, true: FloatArray) -> list[float]:
    errors = found.poses - true
    errors[:, 2] = wrap(errors[:, 2])
    pairs = zip(errors, found.covariances, strict=True)
    return [float(error @ np.linalg.solve(covariance, error)) for error, covariance in pairs]


def test_a_recording_is_found_anywhere_in_the_map(found: Localisation) -> None:
    assert found.sweeps.tolist() == [0, 1, 2, 3, 4]
    assert distances(found, POSES).max() < 0.005
    assert np.abs(wrap(found.poses[:, 2] - POSES[:, 2])).max() < math.radians(0.3)
    assert (found.is_ambiguous, found.kidnapped) == (False, ())
    assert found.inlier_ratio > 0.9


def test_the_covariances_hold_the_errors(found: Localisation) -> None:
    # The mean of five squared Mahalanobis distances in three dimensions exceeds this once in a thousand times.
    assert np.mean(squared_mahalanobis_distances(found, POSES)) < 7.5


def with_errors(feature_map: FeatureMap, rng: np.random.Generator) -> FeatureMap:
    """The map with walls that are off by as much as their covariances say."""
    pairs = ((wall, rng.multivariate_normal(np.zeros(2), wall.covariance)) for wall in feature_map.walls)
    walls = tuple(
        replace(wall, normal_angle=wall.normal_angle + float(error[0]), offset=wall.offset + float(error[1]))
        for wall, error in pairs
    )
    return replace(feature_map, walls=walls)


def test_the_covariances_hold_the_errors_of_drifting_odometry_and_of_the_map() -> None:
    # Odometry alone is off by 4 to 18 cm.
    noise = {"along": 0.03, "lateral": 0.02, "yaw_per_metre": math.radians(3.0)}
    squares = []
    for seed in range(4):
        rough, sweeps = with_errors(ROOM, np.random.default_rng(seed)), recorded(POSES, seed=seed, odometry=noise)
        found = localise(sweeps, rough, rig=RIG, start=POSES[0])
        assert distances(found, POSES).max() < 0.01
        squares.append(np.mean(squared_mahalanobis_distances(found, POSES)))
    # An error of the map moves all poses alike. The mean of four of these squares is hardly ever outside (chi-square).
    assert 0.5 < np.mean(squares) < 8.7


def test_a_start_nearby_leads_to_the_same_poses(found: Localisation, sweeps: list[Sweep]) -> None:
    # 0.29 m and 29 degrees off.
    near = localise(sweeps, ROOM, rig=RIG, start=POSES[0] + [-0.25, 0.15, -0.5])
    assert near.poses == pytest.approx(found.poses, abs=1e-3)
    assert [len(each.starts) for each in near.segments] == [1]


@pytest.mark.parametrize("off", [[0.2, 0.05, 0.1], [-0.2, 0.0, 0.1], [0.25, 0.0, -0.2]])
def test_later_stations_correct_a_start_that_is_off_along_the_only_wall_it_detects(off: list[float]) -> None:
    first, *others = recorded(POSES[1:])
    wall = (first.ranges > 1.2) & (first.ranges < 1.4)
    sweeps = [replace(first, ranges=np.where(wall, first.ranges, np.inf)), *others]
    found = localise(sweeps, ROOM, rig=RIG, start=POSES[1] + off)
    assert distances(found, POSES[1:]) == pytest.approx(np.zeros(4), abs=0.005)
    assert not found.is_ambiguous


@pytest.mark.parametrize("off", [0.0, 0.1])
def test_a_start_holds_where_echoes_leave_it_open(off: float) -> None:
    # A corridor of which no end is detected.
    sides = [[-10.0, 0.0], [14.0, 0.0], [14.0, 2.8], [-10.0, 2.8]]
    long = maps.drawn(*(maps.wall(*pair, covariance=OF_WALLS) for pair in (sides[:2], sides[2:])))
    sweeps = recorded(POSES, sides=sides, pillar=False)
    found = localise(sweeps, long, rig=RIG, start=POSES[0] + [off, 0.0, 0.05])
    assert distances(found, POSES) == pytest.approx(np.full(5, off), abs=0.03)
    assert not found.is_ambiguous


def test_a_start_elsewhere_is_refused(sweeps: list[Sweep]) -> None:
    with pytest.raises(InvalidValueError, match="does not begin there"):
        localise(sweeps, ROOM, rig=RIG, start=np.array([3.3, 0.5, -2.0]))


def test_poses_are_in_the_frame_of_the_map_however_far_its_origin(found: Localisation, sweeps: list[Sweep]) -> None:
    away = np.array([450_000.0, 5_400_000.0])
    points = [[point + away for point in np.array(pair)] for pair in zip(SIDES, SIDES[1:] + SIDES[:1], strict=True)]
    walls = [maps.wall(*pair, covariance=np.diag([1e-9, 1e-3]) ** 2) for pair in points]
    far = maps.drawn(*walls, replace(PILLAR, center_xy=PILLAR.center_xy + away))
    for start in (None, POSES[0] + [*away, 0.0]):
        there = localise(sweeps, far, rig=RIG, start=start)
        assert there.poses[:, :2] - away == pytest.approx(found.poses[:, :2], abs=2e-3)
        assert there.segments[0].starts[0].pose[:2] - away == pytest.approx(POSES[0, :2], abs=0.02)


def test_in_a_rectangle_two_opposite_poses_are_possible() -> None:
    found = localise(recorded(POSES, pillar=False), EMPTY, rig=RIG)
    assert found.is_ambiguous
    (segment,) = found.segments
    one, other = (each.pose for each in segment.starts[:2])
    assert np.hypot(*(one + other)[:2] - [4.0, 2.8]) < 0.05
    assert abs(float(wrap(one[2] - other[2]))) == pytest.approx(math.pi, abs=0.02)
    assert sum(each.weight for each in segment.starts) == pytest.approx(1.0)


def test_opposite_poses_are_equally_probable_in_warm_air() -> None:
    # Readings are 1.7 % too short, so scan matching is off by centimetres, and not by the same ones in both poses.
    sides = [[0.0, 0.0], [3.29, 0.0], [3.29, 3.88], [0.0, 3.88]]
    corners = [replace(maps.corner(place), pings=9, covariance=OF_WALLS) for place in sides]
    places = [[2.37, 2.07, 1.3], [2.55, 2.04, -2.8], [0.76, 1.82, -1.26], [0.86, 0.69, -1.17], [2.28, 2.39, -1.12]]
    noise = {"dropout": 0.02, "stray": 0.02, "air": {"temperature": 30.0}}
    sweeps = recorded(np.array(places), sides=sides, pillar=False, seed=2, **noise)
    starts = localise(sweeps, maps.drawn(*room_map(sides).walls, *corners), rig=RIG).segments[0].starts
    assert [each.weight for each in starts[:2]] == pytest.approx([0.5, 0.5], abs=0.05)


def test_a_pillar_that_was_not_detected_decides_between_two_opposite_poses() -> None:
    """All echoes fit both, but from one of them all stations would have missed a pillar beside them."""
    opposite = [4.0 - FAR[0, 0], 2.8 - FAR[0, 1], FAR[0, 2] + math.pi]
    first = localise(recorded(FAR, pillar=False), ROOM, rig=RIG).segments[0].starts[0]
    assert first.pose == pytest.approx(opposite, abs=0.02)
    assert first.weight > 0.95


def test_a_start_decides_between_two_opposite_poses() -> None:
    sweeps = recorded(POSES, pillar=False)
    for start in (POSES[0], [3.0, 1.8, 0.3 - math.pi]):
        found = localise(sweeps, EMPTY, rig=RIG, start=np.array(start))
        assert not found.is_ambiguous
        assert found.poses[0] == pytest.approx(start, abs=0.005)


def test_it_is_noticed_that_the_robot_was_carried_elsewhere() -> None:
    # The recording begins with sweep 20.
    sweeps = [replace(each, index=20 + each.index) for each in carried(POSES, FAR)]
    assert localise(sweeps, ROOM, rig=RIG, carried_until=4).kidnapped == ()
    found = localise(sweeps, ROOM, rig=RIG, carried_until=5)
    assert found.sweeps.tolist() == list(range(20, 30))
    assert found.kidnapped == (25,)
    assert distances(found, np.concatenate([POSES, FAR])).max() < 0.005
    for segment, pose in zip(found.segments, (POSES[0], FAR[0]), strict=True):
        assert segment.starts[0].pose == pytest.approx(pose, abs=0.03)


def test_a_carried_robot_is_noticed_although_half_of_the_echoes_are_missing() -> None:
    # What the few echoes after that fit by chance near the pose by odometry must not outweigh the true poses.
    found = localise(carried(POSES, THERE, dropout=0.5, stray=0.15), ROOM, rig=RIG)
    assert found.kidnapped == (5,)
    assert distances(found, np.concatenate([POSES, THERE])).max() < 0.03


def carried(before: FloatArray, after: FloatArray, **settings: Any) -> list[Sweep]:
    """Sweeps of a robot that was carried elsewhere, while its odometry counted 5 cm."""
    first, second = recorded(before, **settings), recorded(after, **settings)
    away, later = compose(first[-1].station, [0.05, 0.0, 0.0]), 10**9 + int(first[-1].stamps_ns[-1])
    moved = [
        replace(each, map_from_base=compose(away, each.map_from_base), stamps_ns=each.stamps_ns + later)
        for each in second
    ]
    return [replace(each, index=number) for number, each in enumerate([*first, *moved])]


def test_where_the_robot_was_carried_may_be_ambiguous() -> None:
    first, second = recorded(POSES, pillar=False), recorded(FAR, pillar=False)
    later = [
        replace(each, index=each.index + 5, stamps_ns=each.stamps_ns + 1 + int(first[-1].stamps_ns[-1]))
        for each in second
    ]
    found = localise([*first, *later], EMPTY, rig=RIG, start=POSES[0])
    assert found.kidnapped == (5,)
    assert not found.segments[0].is_ambiguous
    assert found.segments[1].is_ambiguous
    assert min(math.dist(each.pose, FAR[0]) for each in found.segments[1].starts) < 0.05


def test_a_robot_that_comes_back_from_a_room_that_is_not_in_the_map_was_not_carried() -> None:
    poses = np.concatenate([POSES, FAR, POSES[::-1]])
    other = recorded(FAR, sides=[[0.0, 0.0], [5.1, 0.0], [6.0, 3.5], [2.0, 4.4]], pillar=False)
    sweeps = recorded(poses)
    sweeps[5:10] = [replace(sweep, ranges=each.ranges) for sweep, each in zip(sweeps[5:10], other, strict=True)]
    found = localise(sweeps, ROOM, rig=RIG)
    assert found.kidnapped == ()
    assert distances(found, poses)[[*range(5), *range(10, 15)]].max() < 0.005


def test_warmer_air_than_when_the_map_was_made_moves_no_pose() -> None:
    # Readings are 0.7 % too short: 2 cm from the farthest wall.
    found = localise(recorded(POSES, air={"temperature": 24.0}), ROOM, rig=RIG)
    assert distances(found, POSES).max() < 0.005
    assert found.inlier_ratio > 0.9
    assert not found.is_ambiguous


def test_a_thermometer_makes_up_for_much_warmer_air() -> None:
    found = localise(recorded(POSES, air={"temperature": 30.0}, thermometer=0.3), ROOM, rig=RIG)
    assert distances(found, POSES).max() < 0.005
    assert found.inlier_ratio > 0.9


def test_what_stations_should_detect_and_do_not_lowers_the_jaccard_index(found: Localisation) -> None:
    # Four of the five stations miss the pillar; they have about nine arcs each.
    gone = localise(recorded(POSES, pillar=False), ROOM, rig=RIG, start=POSES[0])
    assert gone.inlier_ratio > 0.97
    assert gone.jaccard_index == pytest.approx(44 / 48, abs=0.03)
    assert found.jaccard_index > 0.97


def test_a_room_of_the_same_size_with_other_furniture_has_a_low_jaccard_index() -> None:
    places = [(3.2, 2.2), (0.9, 2.1), (2.2, 0.6), (3.4, 0.9)]
    furnished = room_map(SIDES, *(replace(PILLAR, center_xy=np.array(place)) for place in places))
    other = localise(recorded(POSES, pillar=False), furnished, rig=RIG, start=POSES[0])
    assert other.inlier_ratio > 0.9
    assert other.jaccard_index < 0.8


def test_odometry_carries_over_a_sweep_without_echoes(sweeps: list[Sweep]) -> None:
    found = localise([deaf(sweep) if sweep.index == 2 else sweep for sweep in sweeps], ROOM, rig=RIG)
    assert found.kidnapped == ()
    assert distances(found, POSES).max() < 0.02
    sigmas = np.sqrt(found.covariances[:, 0, 0])
    assert sigmas[2] > 2.0 * np.delete(sigmas, 2).max()


def turned(sweeps: Sequence[Sweep], by: float, *, at: int) -> list[Sweep]:
    """The sweeps by odometry that measured a wrong heading at one of them."""
    place = sweeps[at].station
    error = compose(compose(place, [0.0, 0.0, by]), invert(place))
    moved = [replace(sweep, map_from_base=compose(error, sweep.map_from_base)) for sweep in sweeps[at:]]
    return [*sweeps[:at], *moved]


def test_errors_of_odometry_add_up_where_a_sweep_has_no_echoes(sweeps: list[Sweep]) -> None:
    # Each error alone is within what a single step may be off.
    drifting = turned(turned(sweeps, 0.13, at=2), 0.13, at=3)
    found = localise([deaf(sweep) if sweep.index == 2 else sweep for sweep in drifting], ROOM, rig=RIG)
    assert found.kidnapped == ()
    assert distances(found, POSES).max() < 0.02


def test_a_recording_that_begins_without_echoes_needs_a_start(sweeps: list[Sweep]) -> None:
    late = [deaf(sweeps[0]), *sweeps[1:]]
    with pytest.raises(InvalidValueError, match="fit the map nowhere"):
        localise(late, ROOM, rig=RIG)
    found = localise(late, ROOM, rig=RIG, start=POSES[0] + [-0.25, 0.15, -0.5])
    assert (found.sweeps.tolist(), found.kidnapped) == ([0, 1, 2, 3, 4], ())
    assert distances(found, POSES)[1:].max() < 0.005


def test_the_map_of_another_room_explains_few_echoes(sweeps: list[Sweep]) -> None:
    other = room_map([[0.0, 0.0], [5.1, 0.0], [6.0, 3.5], [2.0, 4.4]])
    assert localise(sweeps[:3], other, rig=RIG).inlier_ratio < 0.7


def test_nothing_to_locate_is_refused(sweeps: list[Sweep]) -> None:
    with pytest.raises(InvalidValueError, match="no walls"):
        localise(sweeps, maps.drawn(), rig=RIG)
    with pytest.raises(InvalidValueError, match="no sweep"):
        localise([], ROOM, rig=RIG)


def test_a_map_too_large_to_search_needs_a_start(sweeps: list[Sweep]) -> None:
    large = maps.drawn(*ROOM.walls, PILLAR, maps.wall([300.0, 0.0], [300.0, 300.0], covariance=OF_WALLS))
    with pytest.raises(InvalidValueError, match="a start is needed"):
        localise(sweeps, large, rig=RIG)
    assert distances(localise(sweeps, large, rig=RIG, start=POSES[0]), POSES).max() < 0.005
