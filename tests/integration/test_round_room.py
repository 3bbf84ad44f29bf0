"""A round room, mapped from exact poses, by odometry, and gone on from."""

import numpy as np
import pytest

from echoplan.evaluation import evaluate
from echoplan.geometry import directions
from echoplan.io import builtin_rig
from echoplan.joint.mapper import JointMapper
from echoplan.methods import map_sweeps
from echoplan.model import FeatureMap, Polyline, Route, World
from echoplan.simulation import Simulation, SimulationSettings

pytestmark = pytest.mark.slow

RADIUS, CENTER_XY = 2.1, np.array([0.4, -0.3])


@pytest.fixture(scope="module")
def room() -> Simulation:
    rng = np.random.default_rng(8)
    outline = CENTER_XY + RADIUS * directions(np.radians(np.arange(0.0, 360.0, 5.0)))
    places = CENTER_XY + 0.75 * RADIUS * np.sqrt(rng.uniform(size=(14, 1))) * directions(rng.uniform(-np.pi, np.pi, 14))
    return Simulation(
        world=World(name="round", polylines=(Polyline(points_xy=outline, closed=True),)),
        rig=builtin_rig("rotary-array"),
        route=Route(map_from_base=np.column_stack([places, rng.uniform(-np.pi, np.pi, 14)])),
        settings=SimulationSettings(),
        seed=3,
    )


@pytest.fixture(scope="module")
def found(room: Simulation) -> FeatureMap:
    return map_sweeps(JointMapper(room.rig), tuple(room))


def test_the_wall_is_closed_and_nothing_else_is_drawn(room: Simulation, found: FeatureMap) -> None:
    assert len(found.walls) == 24
    assert not found.corners
    assert not found.cylinders
    lengths = evaluate(found, room.truth).floor_plan.lengths
    assert lengths.recall > 0.99
    assert lengths.precision > 0.99


def test_its_chords_are_where_the_wall_is(found: FeatureMap) -> None:
    middles = np.array([each.endpoints_xy.mean(axis=0) for each in found.walls])
    away = np.hypot(*(middles - CENTER_XY).T)
    # In its middle a chord is nearer to the centre than the wall, by a third of its sagitta.
    assert away + 0.0029 * RADIUS == pytest.approx([RADIUS] * 24, abs=0.01)
