from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.evaluation.matching import match_map
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import Sweep
from echoplan.simulation import Simulation, SimulationSettings
from echoplan.sources import find_rig, find_route, find_world

pytestmark = pytest.mark.slow

RIG = find_rig("rotary-array")
SQUARE = find_world("square")


def calibrated(sweeps: list[Sweep]) -> Mapping[str, Any]:
    found = map_sweeps(JointMapper(RIG), sweeps).parameters["found"]
    assert isinstance(found, Mapping)
    return found


@pytest.fixture(scope="module")
def turning() -> list[Sweep]:
    """Return sweeps of a servo that turns during the flight of the sound."""
    return list(Simulation(world=SQUARE, rig=RIG, route=find_route("square"), seed=1))


def angles_of_standing_servo(sweep: Sweep) -> FloatArray:
    """Return the angles that a servo records that stands during each ping: those of half the travel time."""
    rates = np.gradient(sweep.servo_angles[::4], 1e-9 * sweep.stamps_ns[::4]).repeat(4)
    ways: FloatArray = np.where(np.isfinite(sweep.ranges), sweep.ranges, 1.5)
    return sweep.servo_angles + rates * ways / 343.0


def test_the_servo_latency_is_right_whether_or_not_the_servo_turns_during_a_ping(turning: list[Sweep]) -> None:
    standing = [replace(sweep, servo_angles=angles_of_standing_servo(sweep)) for sweep in turning]
    assert np.unique(turning[0].stamps_ns[:4]).size == 1
    for sweeps in (turning, standing):
        lag = calibrated(sweeps)["servo_latency"]
        assert abs(lag["value"]) < 2.5 * lag["sigma"]
        assert 0.001 < lag["sigma"] < 0.005


def test_each_value_is_reported_with_its_sigma_and_that_of_the_prior(turning: list[Sweep]) -> None:
    found = calibrated(turning)
    for name in ("range_offset", "walk_gain", "range_scale", "servo_latency"):
        assert set(found[name]) == {"value", "sigma", "prior_sigma"}
        assert 0.0 < found[name]["sigma"] <= 1.05 * found[name]["prior_sigma"]


@pytest.mark.parametrize(("gain", "offset"), [(0.93, np.radians(6.0)), (1.05, np.radians(-4.0))])
def test_servo_gain_and_offset_are_calibrated(gain: float, offset: float) -> None:
    settings = SimulationSettings(servo_gain=gain, servo_offset=offset)
    rig = find_rig("hc-sr04-servo")
    simulation = Simulation(world=SQUARE, rig=rig, route=find_route("square"), settings=settings, seed=2)
    feature_map = map_sweeps(JointMapper(rig), simulation)
    found = feature_map.parameters["found"]
    assert isinstance(found, Mapping)
    for name, true in (("servo_gain", gain), ("servo_offset", offset)):
        assert abs(found[name]["value"] - true) < 3.0 * found[name]["sigma"]
        assert found[name]["sigma"] < 0.2 * found[name]["prior_sigma"]
    walls = match_map(feature_map, simulation.truth).walls
    assert len(walls.found) == len(walls.wanted)
    assert max(match.distance for match in walls.right) < 0.005


def test_a_servo_that_turns_as_recorded_is_not_calibrated(turning: list[Sweep]) -> None:
    assert not {"servo_gain", "servo_offset"} & set(calibrated(turning))


def test_the_temperature_is_reported(turning: list[Sweep]) -> None:
    found = calibrated([replace(sweep, temperature=20.0) for sweep in turning])
    assert found["range_scale"]["temperature"] == 20.0
