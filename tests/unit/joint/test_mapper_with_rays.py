"""The method joint on ray cones, as robot simulators return them."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from echoplan.evaluation import evaluate, pool
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.methods import map_sweeps
from echoplan.model import CornerKind, FeatureClass, FeatureMap, Rig, Sweep, Truth
from echoplan.preprocessing.measurements import join_measurements, measurements_of
from echoplan.preprocessing.rays import are_rays
from echoplan.simulation import Simulation
from echoplan.sources import find_rig, find_route, find_world
from library import ray_cones

pytestmark = pytest.mark.slow

HALF_ANGLE = np.radians(15.0)


@cache
def simulated_cones(world: str, rig: str = "rotary-array") -> tuple[Rig, tuple[Sweep, ...], Truth]:
    """Return a rig with ray cones, its sweeps, and the ground truth."""
    simulation = Simulation(world=find_world(world), rig=find_rig(rig), route=find_route(world))
    using, rng = ray_cones.with_cones(simulation.rig, HALF_ANGLE), np.random.default_rng(0)
    sweeps = ray_cones.cast(list(simulation), simulation.world, using, rays=31, noise=0.002, rng=rng)
    return using, tuple(sweeps), simulation.truth


def calibration_of(found: FeatureMap) -> Mapping[str, Any]:
    numbers = found.parameters["found"]
    assert isinstance(numbers, Mapping)
    return numbers


@cache
def mapped(world: str, rig: str = "rotary-array", *, rays: bool | None = None) -> FeatureMap:
    using, sweeps, _ = simulated_cones(world, rig)
    return map_sweeps(JointMapper(replace(using, rays=rays)), sweeps)


def assert_is_square(found: FeatureMap) -> None:
    assert len(found.walls) == 4
    assert len(found.corners) == 4
    assert all(each.kind is CornerKind.CONCAVE for each in found.corners)
    assert found.cylinders == ()


def test_a_square_room_is_mapped_as_a_square() -> None:
    assert_is_square(mapped("square"))


def test_the_cone_is_reported_instead_of_the_beam() -> None:
    found = calibration_of(mapped("square"))
    assert found["cone"] == pytest.approx(HALF_ANGLE, abs=0.002)
    assert not {"walk_gain", "figure_of_merit", "ka"} & set(found)


def test_walls_are_known_to_a_millimetre() -> None:
    scores = pool([evaluate(mapped("square"), simulated_cones("square")[2])], rng=np.random.default_rng(0))
    assert scores.classes[FeatureClass.WALL].distance.mean.value < 0.001


def test_a_ring_that_reads_rays_is_mapped_if_the_rig_says_so() -> None:
    assert_is_square(mapped("square", "ring-16", rays=True))
    using, sweeps, _ = simulated_cones("square", "ring-16")
    # Its map as one of sound takes a minute: what decides is asked instead.
    assert not are_rays(join_measurements([measurements_of(sweep, using) for sweep in sweeps]))


def test_adding_sweeps_one_by_one_makes_the_same_map() -> None:
    using, sweeps, _ = simulated_cones("square")
    mapper = JointMapper(using, JointSettings())
    for sweep in sweeps:
        mapper.add(sweep)
        mapper.result()
    assert_is_square(mapper.result())
