import numpy as np
import pytest

from echoplan.arrays import IntArray
from echoplan.simulation import Simulation
from helpers import simulated_worlds

POSES = [[0.9, 1.5, 0.3], [3.6, 1.9, 2.0], [2.3, 0.8, -1.2]]


def pings(simulation: Simulation) -> IntArray:
    return np.arange(len(simulation._schedule.sensors))


@pytest.mark.parametrize("superposition", ["coherent", "incoherent"])
def test_tracing_only_what_can_matter_gives_the_same_as_tracing_everything(superposition: str) -> None:
    simulation = simulated_worlds.simulation(
        simulated_worlds.room(), using=simulated_worlds.array(), poses=POSES, superposition=superposition
    )
    receivers, every = simulation._receivers, pings(simulation)
    patient = receivers._crossings(receivers.stage, every, receivers.stage.shots.deadlines)
    quick = receivers.instants(every)
    np.testing.assert_allclose(quick, patient, rtol=0, atol=1e-9)
    assert 0.5 < np.isfinite(quick).mean() < 1.0


def test_pings_can_be_asked_in_any_order() -> None:
    simulation = simulated_worlds.simulation(simulated_worlds.room(), using=simulated_worlds.array(), poses=POSES)
    every = pings(simulation)
    shuffled = np.random.default_rng(0).permutation(every)
    np.testing.assert_array_equal(
        simulation._receivers.instants(shuffled), simulation._receivers.instants(every)[shuffled]
    )


def test_no_pings_receive_nothing() -> None:
    simulation = simulated_worlds.simulation(simulated_worlds.room())
    assert len(simulation._receivers.instants(np.zeros(0, dtype=np.int64))) == 0


def test_only_what_answers_alone_is_counted() -> None:
    # A wall ahead, a post before it, a wall too far to the side, and one that is behind the one ahead.
    world = simulated_worlds.world(
        [[1.0, -2.0], [1.0, 2.0]], [[-9.0, 5.5], [9.0, 5.5]], [[1.5, -2.0], [1.5, 2.0]], pillars=[(0.7, 0.1, 0.05)]
    )
    rig = simulated_worlds.rig(servo=simulated_worlds.turning(-20, 90, 2))
    simulation = simulated_worlds.simulation(world, using=rig)
    assert simulation._receivers.detected_alone(pings(simulation)).tolist() == [0, 3]


def test_what_is_too_close_or_out_of_reach_is_not_counted() -> None:
    rig = simulated_worlds.rig(simulated_worlds.sensor(min_range=0.5, max_range=2.0))
    counted = [
        simulated_worlds.simulation(simulated_worlds.wall(distance), using=rig)
        ._receivers.detected_alone(np.array([0]))
        .tolist()
        for distance in (0.45, 0.55, 1.9, 2.1)
    ]
    assert counted == [[], [0], [0], []]
