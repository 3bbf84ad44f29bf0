from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import BoolArray, FloatArray
from echoplan.evaluation import evaluate
from echoplan.joint.mapper import JointMapper, JointSettings
from echoplan.joint.search.occlusion import Occlusion, hiding
from echoplan.joint.search.ray_paths import trace_paths
from echoplan.model import Pillar, Polyline, Route, World
from echoplan.simulation import Simulation
from echoplan.sources import find_rig
from helpers.expectations import corner, cylinder, likelihood, listening, pings_of, rescored, wall

pytestmark = pytest.mark.slow

STEP = np.radians(3.0)
NORTH = wall(np.pi / 2, 1.0)
# A row of stations along the wall; they detect landmarks beyond it where the wall returns no echo.
STATIONS = tuple((0.3 * number - 0.9, 0.1) for number in range(7))


def hidden_by(
    beyond: FloatArray, *, door: tuple[float, float] = (0.0, 0.0), llr: float = 1000.0, least: float = 40.0
) -> tuple[Occlusion, BoolArray]:
    """Return what a wall hides, with a door in it and another landmark beyond, and which pings detect the latter."""
    silent = listening(STATIONS, step=STEP)
    to_wall = pings_of(silent, [NORTH]).readings
    to_wall = np.where((silent.x > door[0]) & (silent.x < door[1]), np.inf, to_wall)
    aside = np.abs(np.degrees(np.arctan2(silent.uy, silent.ux)) - 90.0) > least
    to_other = np.where(aside, pings_of(silent, [beyond]).readings, np.inf)
    estimate = likelihood(silent._replace(readings=np.where(aside, to_other, to_wall)))
    north, other = rescored(estimate, [NORTH, beyond])
    features = [replace(north, llr=llr), replace(other, llr=50.0)]
    paths = trace_paths(estimate, features, step=STEP)
    found, own = hiding(paths, features, gap=0.4), paths.owners == 1
    assert own.sum() > 5
    assert not found.hidden[~own].any()
    assert not found.passed[:, ~own].any()
    return found, own


def share_hidden(
    beyond: FloatArray, *, door: tuple[float, float] = (0.0, 0.0), llr: float = 1000.0, least: float = 40.0
) -> float:
    """Return the share of the pings of the other landmark that are hidden."""
    found, own = hidden_by(beyond, door=door, llr=llr, least=least)
    return float(found.hidden[own].mean())


@pytest.mark.parametrize("beyond", [cylinder(0.0, 1.5, 0.15), corner(0.2, 1.4)], ids=["cylinder", "corner"])
def test_a_landmark_behind_a_wall_is_hidden(beyond: FloatArray) -> None:
    assert share_hidden(beyond) > 0.9


@pytest.mark.parametrize(
    ("detected", "least"),
    [(cylinder(0.0, 0.6, 0.1), 20.0), (corner(0.0, 1.03), 40.0), (cylinder(2.2, 1.5, 0.15), 40.0)],
    ids=["before it", "all but touching it", "past its end"],
)
def test_a_landmark_not_behind_a_wall_is_not_hidden(detected: FloatArray, least: float) -> None:
    assert share_hidden(detected, least=least) == 0.0


def test_a_landmark_behind_a_door_is_not_hidden() -> None:
    assert share_hidden(cylinder(0.0, 1.5, 0.15), door=(-0.8, 0.8)) < 0.5


def test_sound_passes_a_wall_of_a_smaller_ratio() -> None:
    found, own = hidden_by(cylinder(0.0, 1.5, 0.15), llr=40.0)
    assert not found.hidden.any()
    assert found.passed[0, own].mean() > 0.9


def test_images_of_pillars_are_not_on_the_map() -> None:
    outline = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    pillars = (Pillar(center_xy=np.array([2.0, 1.7]), radius=0.2), Pillar(center_xy=np.array([3.0, 1.0]), radius=0.15))
    rng, stations = np.random.default_rng(3), list[FloatArray]()
    while len(stations) < 60:
        place = rng.uniform([0.4, 0.4], [3.6, 2.6])
        if all(np.hypot(*(place - each.center_xy)) > each.radius + 0.35 for each in pillars):
            stations.append(np.append(place, rng.uniform(-3.0, 3.0)))
    simulation = Simulation(
        world=World(name="pillars", polylines=(Polyline(points_xy=outline, closed=True),), pillars=pillars),
        rig=find_rig("rotary-array"),
        route=Route(map_from_base=np.array(stations)),
        seed=3,
    )
    mapper = JointMapper(simulation.rig, JointSettings())
    for sweep in simulation:
        mapper.add(sweep)
    matches = evaluate(mapper.result(), simulation.truth).matches
    assert (matches.cylinders.tally.right, matches.cylinders.tally.spurious) == (2, 0)
    assert (matches.walls.tally.right, matches.walls.tally.spurious) == (4, 0)
