import numpy as np
import pytest

from echoplan.classical.features import (
    AssemblySettings,
    AssociationSettings,
    Grouped,
    Observation,
    WallSettings,
    assemble,
    group_lines,
)
from echoplan.model import CornerKind, FeatureMap
from helpers import scenes

GATES = AssociationSettings()
SOUTH, EAST = (-np.pi / 2, 0.0), (0.0, 3.0)
HUBS = [(0.6, 1.0), (1.4, 0.7), (2.2, 1.3)]


def observed_walls(*lines: tuple[float, float]) -> list[Observation]:
    return [scenes.observed_wall(line, hub, sweep=k) for line in lines or (SOUTH, EAST) for k, hub in enumerate(HUBS)]


def mapped(
    walls: list[Observation] | None = None, corners: list[Observation] | None = None, **settings: float
) -> FeatureMap:
    grouped = Grouped(lines=group_lines(walls or observed_walls(), GATES), corners=corners or [])
    return assemble(grouped, [], AssemblySettings(walls=WallSettings(**settings)), method="test")


def test_walls_are_as_long_as_they_were_detected_and_end_where_they_meet() -> None:
    feature_map = mapped()
    south = next(wall for wall in feature_map.walls if abs(wall.normal_angle) > 1)
    zone = np.sqrt(0.0086 * 1.0 / 2)
    assert sorted(south.endpoints_xy[:, 0]) == pytest.approx([0.6 - zone, 3.0], abs=1e-6)


def test_corners_are_crossings_and_record_whether_they_were_detected() -> None:
    (inferred,) = mapped().corners
    assert inferred.position_xy == pytest.approx([3.0, 0.0], abs=1e-6)
    assert inferred.kind is CornerKind.CONCAVE
    assert inferred.pings == 0
    (corner,) = mapped(corners=[scenes.observed_circle((3.0, 0.0, 0.0), (1.4, 0.7), degrees=(0.9, 0.1, 0.0))]).corners
    assert (corner.pings, corner.stations) == (40, 1)
    assert corner.class_probabilities.corner == pytest.approx(0.9)


def test_walls_far_apart_meet_only_where_their_corner_was_detected() -> None:
    assert mapped(max_extension=0.1).corners == ()
    corners = [scenes.observed_circle((3.0, 0.0, 0.0), (1.4, 0.7), degrees=(0.9, 0.1, 0.0))]
    (corner,) = mapped(corners=corners, max_extension=0.1).corners
    assert corner.position_xy == pytest.approx([3.0, 0.0], abs=1e-6)
    assert mapped(corners=corners, max_extension=0.1, max_detected_extension=0.5).corners == ()


def test_a_detected_corner_is_preferred_to_a_nearer_one_that_was_not_detected() -> None:
    # A second wall to the east, 0.3 m behind the first: the southern one can end at either.
    behind = (0.0, 3.3)
    walls = observed_walls(SOUTH, EAST, behind)
    (inferred,) = mapped(walls).corners
    assert inferred.position_xy == pytest.approx([3.0, 0.0], abs=1e-6)
    echo = scenes.observed_circle((3.3, 0.0, 0.0), (1.4, 0.7), degrees=(0.9, 0.1, 0.0))
    (detected,) = mapped(walls, [echo]).corners
    assert detected.position_xy == pytest.approx([3.3, 0.0], abs=1e-6)


def test_an_object_detected_from_one_station_is_left_out_unless_requested() -> None:
    grouped = Grouped(lines=group_lines([scenes.observed_wall(EAST, (1.0, 1.0))], GATES))
    sweeps = [scenes.sweep_of(np.ones(360), pose=(1.0, 1.0, 0.5))]
    assert assemble(grouped, sweeps, AssemblySettings(), method="test").walls == ()
    feature_map = assemble(grouped, sweeps, AssemblySettings(min_stations=1), method="test")
    assert len(feature_map.walls) == 1
    assert feature_map.poses.tolist() == [[1.0, 1.0, 0.5]]


def test_what_two_stations_confirm_is_kept_and_corners_need_no_second_one() -> None:
    pillar = (1.5, 1.6, 0.12)
    twice = tuple(scenes.observed_circle(pillar, hub, sweep=k) for k, hub in enumerate(HUBS[:2]))
    once = (scenes.observed_circle((0.5, 2.5, 0.1), HUBS[0]),)
    corner = scenes.observed_circle((3.0, 0.0, 0.0), HUBS[0])
    sure = Grouped(corners=[corner], cylinders=[once, twice]).confirmed(2)
    assert (sure.corners, sure.cylinders) == ([corner], [twice])


def test_two_echoes_of_one_sweep_do_not_confirm_each_other() -> None:
    twice = tuple(scenes.observed_circle((1.5, 1.6, 0.12), HUBS[0], sweep=4) for _ in range(2))
    assert Grouped(cylinders=[twice]).confirmed(2).cylinders == []


def test_without_echoes_the_map_is_empty_and_records_how_it_was_made() -> None:
    found = assemble(Grouped(), [], AssemblySettings(), method="test", parameters={"a": 1})
    assert (found.walls, found.corners, found.cylinders) == ((), (), ())
    assert (found.method, dict(found.parameters), len(found.poses)) == ("test", {"a": 1}, 0)
