import numpy as np
import pytest

from echoplan.acoustics import Air
from echoplan.model import Transducer
from echoplan.simulation import Simulation
from echoplan.simulation.shots import Shots, memory_of
from helpers import simulated_worlds


def shots(simulation: Simulation) -> Shots:
    return simulation._receivers.stage.shots


def bursts_of(found: Shots, ping: int) -> list[int]:
    return list(range(int(found.first_burst[ping]), int(found.last_burst[ping])))


def test_sound_is_remembered_as_long_as_an_aimed_plane_returns_it() -> None:
    assert memory_of(Transducer(), Air()) == pytest.approx(2 * 4.27 / 344.0, rel=0.01)
    assert memory_of(Transducer(figure_of_merit=40.0), Air()) > memory_of(Transducer(), Air())


def test_slow_firing_receives_its_own_round_only() -> None:
    found = shots(
        simulated_worlds.simulation(simulated_worlds.room(), using=simulated_worlds.array(), second_time_around=False)
    )
    assert bursts_of(found, 0) == [0, 1, 2, 3]
    assert bursts_of(found, 9) == [8, 9, 10, 11]


def test_fast_firing_receives_the_rounds_before_and_after_too() -> None:
    fast = simulated_worlds.rig(servo=simulated_worlds.turning(0, 10, 1), period=0.015)
    found = shots(simulated_worlds.simulation(simulated_worlds.room(), using=fast))
    # 25 ms of memory reach one round back, 35 ms of listening two rounds on.
    assert bursts_of(found, 5) == [4, 5, 6, 7]
    assert bursts_of(found, 0) == [0, 1, 2]


def test_nothing_is_received_from_another_station() -> None:
    found = shots(simulated_worlds.simulation(simulated_worlds.room(), poses=np.zeros((3, 3))))
    assert [bursts_of(found, ping) for ping in range(3)] == [[0], [1], [2]]


def test_places_and_directions_are_complex_numbers() -> None:
    simulation = simulated_worlds.simulation(simulated_worlds.room(), poses=[[1.0, 2.0, np.pi / 2]])
    found = shots(simulation)
    assert found.places[0] == pytest.approx(1.0 + 2.0j)
    assert found.axes[0] == pytest.approx(1.0j)
