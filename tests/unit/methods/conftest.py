"""A room that every method maps, once for the tests of a file."""

import pytest

from echoplan.methods import METHODS, Mapper, Method, map_sweeps
from echoplan.model import FeatureMap, Sweep
from echoplan.simulation import Simulation
from helpers import simulated_worlds
from helpers.cell import CELL


@pytest.fixture(params=METHODS.values(), ids=list(METHODS), scope="module")
def method(request: pytest.FixtureRequest) -> Method:
    """Each method in turn."""
    chosen: Method = request.param
    return chosen


@pytest.fixture(scope="module")
def cell(request: pytest.FixtureRequest) -> Simulation:
    """A small room without a right angle, with a pillar, recorded from the ``POSES`` of the file."""
    using = simulated_worlds.array(resolution=0.005)
    return simulated_worlds.simulation(CELL, using=using, poses=request.module.POSES)


@pytest.fixture(scope="module")
def sweeps(cell: Simulation) -> list[Sweep]:
    return list(cell)


@pytest.fixture(scope="module")
def mapper(method: Method, cell: Simulation) -> Mapper:
    """What makes the map of the cell, in ``found``."""
    return method.build(cell.rig)


@pytest.fixture(scope="module")
def found(mapper: Mapper, sweeps: list[Sweep]) -> FeatureMap:
    return map_sweeps(mapper, sweeps)
