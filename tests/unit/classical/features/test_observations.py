import numpy as np
import pytest

from echoplan.classical.features import Observation, Stack, shares, stations_of
from echoplan.errors import InvalidValueError
from helpers import scenes

HUB = (0.5, 0.2)


def test_a_stack_keeps_the_order_of_its_observations() -> None:
    observations = [
        scenes.observed(hub, bearing=bearing, distance=1.0 + bearing, degrees=(0.0, 0.0, 1.0))
        for hub, bearing in (((0.0, 0.0), 0.3), ((1.0, 2.0), -1.2))
    ]
    stack = Stack.of(observations)
    assert stack.hubs_xy.tolist() == [[0.0, 0.0], [1.0, 2.0]]
    assert stack.bearings.tolist() == [0.3, -1.2]
    assert stack.distances == pytest.approx([1.3, -0.2])
    assert stack.bearing_sigmas == pytest.approx([0.0035, 0.0035])


def test_what_sweeps_have_in_common_is_added_to_their_sigmas() -> None:
    stack = Stack.of([scenes.observed_wall((0.3, 4.0), HUB)], floor=(0.01, 0.004))
    assert stack.bearing_sigmas == pytest.approx([np.hypot(0.0035, 0.01)])
    assert stack.distance_sigmas == pytest.approx([np.hypot(0.001, 0.004)])


def test_an_observation_has_a_degree_for_each_of_three_classes() -> None:
    known = scenes.observed_wall((0.3, 4.0), HUB)
    with pytest.raises(InvalidValueError, match="degrees"):
        Observation(sweep=0, point=known.point, degrees=np.ones(2), pings=3)


def test_what_was_observed_cannot_be_changed() -> None:
    known = scenes.observed_wall((0.3, 4.0), HUB)
    with pytest.raises(ValueError, match="read-only"):
        known.degrees[0] = 1.0


def test_shares_sum_to_one_and_go_with_the_degrees() -> None:
    found = shares(np.array([0.5, 1.0, 2.5]))
    assert (found.corner, found.cylinder, found.wall) == pytest.approx((0.125, 0.25, 0.625))


def test_without_degrees_all_shares_are_equal() -> None:
    undecided = shares(np.array([-0.1, 0.0, -0.2]))
    assert (undecided.corner, undecided.cylinder, undecided.wall) == pytest.approx((1 / 3, 1 / 3, 1 / 3))


def test_two_observations_of_one_sweep_are_one_station() -> None:
    members = tuple(scenes.observed_wall((0.3, 4.0), HUB, sweep=sweep) for sweep in (2, 2, 5))
    assert stations_of(members) == 2
    assert stations_of(()) == 0
