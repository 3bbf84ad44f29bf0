from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.model import Rig, Sweep
from echoplan.preprocessing.measurements import Measurements, join_measurements, measurements_of, select_measurements
from echoplan.preprocessing.rays import share_of_ramps
from echoplan.simulation import Simulation
from echoplan.sources import find_rig, find_route, find_world
from library import ray_cones


@cache
def simulation_of(rig: str) -> Simulation:
    return Simulation(world=find_world("square"), rig=find_rig(rig), route=find_route("square"))


def measured(sweeps: list[Sweep], rig: Rig) -> Measurements:
    return join_measurements([measurements_of(sweep, rig) for sweep in sweeps])


def by_rays(degrees: float, *, noise: float = 0.002, rig: str = "rotary-array") -> Measurements:
    simulation, rng = simulation_of(rig), np.random.default_rng(0)
    using = ray_cones.with_cones(simulation.rig, np.radians(degrees))
    return measured(ray_cones.cast(list(simulation), simulation.world, using, rays=31, noise=noise, rng=rng), using)


@pytest.mark.parametrize("half_angle", [5.0, 15.0, 30.0])
def test_rays_show_ramps_along_walls(half_angle: float) -> None:
    assert share_of_ramps(by_rays(half_angle)) > 0.15


def test_rays_show_ramps_despite_a_centimetre_of_noise() -> None:
    assert share_of_ramps(by_rays(15.0, noise=0.01)) > 0.1


def test_steps_too_wide_to_show_a_ramp_are_taken_for_sound() -> None:
    every = by_rays(15.0)
    ahead = select_measurements(every, every.sensors == 0)
    assert share_of_ramps(select_measurements(ahead, np.arange(len(ahead.readings)) % 2 == 0)) > 0.15
    assert share_of_ramps(select_measurements(ahead, np.arange(len(ahead.readings)) % 4 == 0)) == 0.0


def test_rays_at_uneven_steps_are_taken_for_sound() -> None:
    every = by_rays(15.0)
    ahead = select_measurements(every, every.sensors == 0)
    in_turn = np.isin(np.arange(len(ahead.readings)) % 5, [0, 1])
    assert share_of_ramps(select_measurements(ahead, in_turn)) == 0.0


def test_readings_of_sound_show_no_ramps() -> None:
    simulation = simulation_of("rotary-array")
    assert share_of_ramps(measured(list(simulation), simulation.rig)) == 0.0


def test_a_fixed_ring_shows_no_ramps() -> None:
    assert share_of_ramps(by_rays(15.0, rig="ring-16")) == 0.0


def test_without_readings_there_are_no_ramps() -> None:
    silent = by_rays(15.0)
    assert share_of_ramps(silent._replace(readings=np.full(len(silent.readings), np.inf))) == 0.0


def test_readings_of_a_robot_that_drives_at_a_wall_while_its_sonar_turns_are_sound() -> None:
    # 0.8 m/s, and 40 degrees a second.
    simulation = simulation_of("rotary-array")
    sweep = next(iter(simulation))
    times = 1e-9 * (sweep.stamps_ns - sweep.stamps_ns[0])
    driven = 0.8 * times
    measurements = measurements_of(replace(sweep, ranges=2.9 - driven), simulation.rig)
    assert share_of_ramps(measurements) > 0.5
    assert share_of_ramps(measurements._replace(x=measurements.x + driven)) == 0.0
