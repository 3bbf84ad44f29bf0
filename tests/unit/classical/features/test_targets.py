from dataclasses import replace

import numpy as np
import pytest

from echoplan.classical.features import AssociationSettings, CylinderSettings, Observation, TargetKind, find_targets
from helpers import scenes

GATES, CYLINDERS = AssociationSettings(), CylinderSettings()
HUBS = [(0.5, 0.5), (1.3, 0.6), (2.4, 0.7)]
NORTH, CORNER, PILLAR = (np.pi / 2, 3.0), (1.5, 2.6, 0.0), (1.5, 2.6, 0.15)


def kinds(observations: list[Observation]) -> list[tuple[TargetKind, int]]:
    return [(each.kind, each.group.stations) for each in find_targets(observations, GATES, CYLINDERS)]


def test_three_views_distinguish_a_plane_a_corner_and_a_cylinder() -> None:
    views = enumerate(HUBS)
    assert kinds([scenes.observed_wall(NORTH, hub, sweep=k) for k, hub in views]) == [(TargetKind.LINE, 3)]
    for circle, kind in ((CORNER, TargetKind.POINT), (PILLAR, TargetKind.CIRCLE)):
        seen = [scenes.observed_circle(circle, hub, sweep=k) for k, hub in enumerate(HUBS)]
        assert kinds(seen) == [(kind, 3)]


def test_one_view_is_no_target() -> None:
    assert kinds([scenes.observed_wall(NORTH, HUBS[0])]) == []
    assert kinds([]) == []


def test_views_of_a_cylinder_that_share_tangents_by_twos_stay_one_cylinder() -> None:
    # Two stations in line with the pillar see it as they would a wall across that line.
    hubs = [(0.2, 2.6), (0.6, 2.6), (1.5, 1.0), (1.5, 1.3)]
    seen = [scenes.observed_circle((1.5, 2.6, 0.1), hub, sweep=k) for k, hub in enumerate(hubs)]
    assert kinds(seen[:2]) == [(TargetKind.LINE, 2)]
    assert kinds(seen) == [(TargetKind.CIRCLE, 4)]


def test_an_observation_goes_to_one_target_only() -> None:
    walls = [scenes.observed_wall(NORTH, hub, sweep=k) for k, hub in enumerate(HUBS)]
    corners = [scenes.observed_circle((2.8, 2.2, 0.0), hub, sweep=k) for k, hub in enumerate(HUBS)]
    targets = find_targets([*walls, *corners], GATES, CYLINDERS)
    members = [id(member) for target in targets for member in target.group.members]
    assert len(members) == len(set(members)) == 6
    assert {each.kind for each in targets} == {TargetKind.LINE, TargetKind.POINT}


def test_an_observation_costs_a_target_no_more_than_an_object_of_its_own() -> None:
    (target,) = find_targets(
        [scenes.observed_wall(NORTH, hub, sweep=k) for k, hub in enumerate(HUBS)], GATES, CYLINDERS
    )
    assert target.gain == pytest.approx(3 * 4 - 2 * 2)
    assert replace(target, chi_squares=np.array([0.0, 0.0, 99.0])).gain == pytest.approx(2 * 4 - 2 * 2)
