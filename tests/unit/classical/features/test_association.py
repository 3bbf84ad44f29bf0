import numpy as np
import pytest

from echoplan.classical.features import AssociationSettings, absorb, group_lines, group_points
from helpers import scenes

GATES = AssociationSettings()
NORTH, EAST = (np.pi / 2, 3.0), (0.0, 4.0)
HUBS = [(0.5, 0.5), (1.5, 1.0), (3.0, 0.4)]


def test_each_line_gathers_its_observations() -> None:
    observations = [
        scenes.observed_wall(line, hub, sweep=sweep) for line in (NORTH, EAST) for sweep, hub in enumerate(HUBS)
    ]
    groups = group_lines(observations, GATES)
    assert sorted(group.stations for group in groups) == [3, 3]
    lines = sorted(tuple(group.fit.parameters) for group in groups)
    assert np.allclose(lines, [EAST, NORTH])


def test_parallel_walls_a_hand_apart_stay_two() -> None:
    near, far = (np.pi / 2, 3.0), (np.pi / 2, 3.1)
    observations = [scenes.observed_wall(line, hub, sweep=k) for line in (near, far) for k, hub in enumerate(HUBS)]
    assert len(group_lines(observations, GATES)) == 2


def test_both_sides_of_a_board_are_two_walls() -> None:
    board = [scenes.observed_wall((0.0, 2.0), (1.0, 0.0)), scenes.observed_wall((np.pi, -2.0), (3.0, 0.0), sweep=1)]
    assert len(group_lines(board, GATES)) == 2


def test_a_line_takes_what_lies_on_it_and_leaves_the_rest() -> None:
    groups = group_lines([scenes.observed_wall(NORTH, hub, sweep=k) for k, hub in enumerate(HUBS)], GATES)
    on_it = scenes.observed_wall(NORTH, (2.0, 2.0), sweep=5, degrees=(0.1, 0.8, 0.3))
    beside_it = scenes.observed_circle((2.0, 2.0, 0.1), (2.0, 1.0), sweep=5)
    assert absorb(groups, [on_it, beside_it], GATES) == [beside_it]
    assert groups[0].stations == 4
    assert groups[0].pings == 160
    assert groups[0].degrees == pytest.approx([0.1, 0.8, 3.3])


def test_points_of_one_object_are_put_together_by_their_middles() -> None:
    pillar, other = (1.5, 2.0, 0.2), (3.0, 2.0, 0.1)
    around = [(0.5, 2.0), (2.4, 2.0), (1.5, 0.9)]
    observations = [scenes.observed_circle(pillar, hub, sweep=k) for k, hub in enumerate(around)]
    observations.append(scenes.observed_circle(other, (4.0, 2.0), sweep=3))
    groups = group_points(observations, GATES, depth=0.2)
    assert sorted(len(group) for group in groups) == [1, 3]
    # By their faces alone the near and the far side would be two objects.
    assert len(group_points(observations, GATES)) > 2


def test_without_observations_there_are_no_groups() -> None:
    assert group_lines([], GATES) == []
    assert group_points([], GATES) == []
