import numpy as np
import pytest

import scenes
from echoplan.geometry import intersections
from echoplan.mapping import (
    AssemblySettings,
    AssociationSettings,
    CylinderSettings,
    Grouped,
    Observation,
    WallSettings,
    assemble,
    crossing_covariance,
    cylinder_of,
    group_lines,
    heard_span,
)
from echoplan.model import CornerKind, FeatureMap, Wall

GATES = AssociationSettings()
SOUTH, EAST = (-np.pi / 2, 0.0), (0.0, 3.0)
HUBS = [(0.6, 1.0), (1.4, 0.7), (2.2, 1.3)]


def heard_walls() -> list[Observation]:
    return [scenes.observed_wall(line, hub, sweep=k) for line in (SOUTH, EAST) for k, hub in enumerate(HUBS)]


def mapped(
    heard: list[Observation] | None = None, corners: list[Observation] | None = None, **settings: float
) -> FeatureMap:
    grouped = Grouped(lines=group_lines(heard or heard_walls(), GATES), corners=corners or [])
    return assemble(grouped, [], AssemblySettings(walls=WallSettings(**settings)), method="test")


def test_walls_are_as_long_as_they_were_heard_and_end_where_they_meet() -> None:
    feature_map = mapped()
    south = next(wall for wall in feature_map.walls if abs(wall.normal_angle) > 1)
    zone = np.sqrt(0.0086 * 1.0 / 2)
    assert sorted(south.endpoints_xy[:, 0]) == pytest.approx([0.6 - zone, 3.0], abs=1e-6)
    assert south.stations == 3
    assert south.class_probabilities.wall == 1.0


def test_a_wall_heard_once_is_a_fresnel_zone_long() -> None:
    groups = group_lines([scenes.observed_wall(EAST, (1.0, 1.0))], GATES)
    span = heard_span(groups[0], WallSettings())
    assert span.high - span.low == pytest.approx(2 * np.sqrt(0.0086 * 2.0 / 2))


def test_corners_are_crossings_and_know_whether_they_were_heard() -> None:
    (silent,) = mapped().corners
    assert silent.position_xy == pytest.approx([3.0, 0.0], abs=1e-6)
    assert silent.kind is CornerKind.CONCAVE
    assert silent.pings == 0
    (corner,) = mapped(corners=[scenes.observed_circle((3.0, 0.0, 0.0), (1.4, 0.7), degrees=(0.9, 0.1, 0.0))]).corners
    assert corner.pings == 40
    assert corner.stations == 1
    assert corner.class_probabilities.corner == pytest.approx(0.9)


def test_walls_far_apart_meet_only_where_their_corner_was_heard() -> None:
    assert mapped(max_extension=0.1).corners == ()
    heard = [scenes.observed_circle((3.0, 0.0, 0.0), (1.4, 0.7), degrees=(0.9, 0.1, 0.0))]
    (corner,) = mapped(corners=heard, max_extension=0.1).corners
    assert corner.position_xy == pytest.approx([3.0, 0.0], abs=1e-6)
    assert mapped(corners=heard, max_extension=0.1, heard_extension=0.5).corners == ()


@pytest.mark.parametrize("elsewhere", [(1.5, 1.5), (2.9, 0.0), (3.4, 0.7)])
def test_what_is_heard_where_no_walls_meet_is_no_corner(elsewhere: tuple[float, float]) -> None:
    astray = [scenes.observed_circle((*elsewhere, 0.0), (1.4, 0.7))]
    assert [corner.pings for corner in mapped(corners=astray).corners] == [0]


def test_a_corner_may_be_heard_anywhere_in_its_window() -> None:
    distance = float(np.hypot(1.6, 0.7))
    beside = float(np.arctan2(-0.7, 1.6)) + 0.2
    vague = scenes.observed((1.4, 0.7), bearing=beside, distance=distance, degrees=(0.9, 0.1, 0.0), bearing_sigma=0.1)
    assert [corner.pings for corner in mapped(corners=[vague]).corners] == [40]


def test_the_covariance_of_a_crossing_is_that_of_repeated_trials() -> None:
    rng = np.random.default_rng(5)
    covariance = np.array([[1e-4, 2e-5], [2e-5, 4e-5]])
    lines = np.array([[0.4, 3.0], [1.7, 2.0]])
    first, second = (
        Wall(normal_angle=a, offset=r, endpoints_xy=np.array([[0.0, 0.0], [1.0, 1.0]]), covariance=covariance)
        for a, r in lines
    )
    noise = rng.multivariate_normal(np.zeros(2), covariance, size=(2, 4000))
    points = intersections(lines[0] + noise[0], lines[1] + noise[1])
    assert crossing_covariance(first, second) == pytest.approx(np.cov(points.T), rel=0.1, abs=2e-5)


def test_a_cylinder_has_the_radius_of_its_circle() -> None:
    members = tuple(scenes.observed_circle((1.5, 1.6, 0.12), hub, sweep=k) for k, hub in enumerate(HUBS))
    cylinder = cylinder_of(members, CylinderSettings(radius_sigma=10.0), association=GATES)
    assert cylinder is not None
    assert cylinder.center_xy == pytest.approx([1.5, 1.6], abs=1e-4)
    assert cylinder.radius == pytest.approx(0.12, abs=1e-4)
    assert cylinder.stations == 3


def test_what_only_a_hollow_circle_explains_is_no_cylinder() -> None:
    members = tuple(
        scenes.observed_circle((1.5, 1.6, -0.2), hub, sweep=k) for k, hub in enumerate([(0.5, 1.6), (2.5, 1.6)])
    )
    assert cylinder_of(members, CylinderSettings(), association=GATES) is None


def test_an_object_heard_from_one_station_is_left_out_unless_asked_for() -> None:
    grouped = Grouped(lines=group_lines([scenes.observed_wall(EAST, (1.0, 1.0))], GATES))
    sweeps = [scenes.sweep_of(np.ones(360), pose=(1.0, 1.0, 0.5))]
    assert assemble(grouped, sweeps, AssemblySettings(), method="test").walls == ()
    feature_map = assemble(grouped, sweeps, AssemblySettings(min_stations=1), method="test")
    assert len(feature_map.walls) == 1
    assert feature_map.poses.tolist() == [[1.0, 1.0, 0.5]]
