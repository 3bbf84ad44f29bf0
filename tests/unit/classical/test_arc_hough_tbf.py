import numpy as np
import pytest

from echoplan.classical.arc_hough_tbf import ArcHoughTbfMapper
from echoplan.classical.rcd import RcdMapper
from echoplan.classical.tbf import TbfMapper
from echoplan.evaluation import Evaluation, evaluate
from echoplan.methods import map_sweeps
from echoplan.model import Polyline, World
from echoplan.simulation import Simulation
from helpers import simulated_worlds

OBLONG = World(
    name="oblong",
    polylines=(Polyline(points_xy=np.array([[0.0, 0.0], [3.2, 0.0], [3.2, 2.0], [0.0, 2.0]]), closed=True),),
)
POSES = [[0.7, 0.7, 0.0], [1.4, 1.3, 0.4], [2.0, 0.8, 1.0], [2.6, 1.2, 2.0]]


@pytest.fixture(scope="module")
def oblong() -> Simulation:
    return simulated_worlds.simulation(OBLONG, using=simulated_worlds.array(), poses=POSES)


def score(oblong: Simulation, mapper: ArcHoughTbfMapper | RcdMapper | TbfMapper) -> Evaluation:
    return evaluate(map_sweeps(mapper, oblong), oblong.truth)


def test_fused_walls_hold_fewer_phantoms_than_arcs_and_more_walls_than_points(oblong: Simulation) -> None:
    fused = score(oblong, ArcHoughTbfMapper(oblong.rig)).matches.walls.tally
    arcs = score(oblong, RcdMapper(oblong.rig)).matches.walls.tally
    points = score(oblong, TbfMapper(oblong.rig)).matches.walls.tally
    assert fused.spurious < arcs.spurious
    assert fused.found > points.found


def test_cylinders_are_those_of_the_arcs(oblong: Simulation) -> None:
    fused = map_sweeps(ArcHoughTbfMapper(oblong.rig), oblong)
    arcs = map_sweeps(RcdMapper(oblong.rig), oblong)
    assert [each.radius for each in fused.cylinders] == [each.radius for each in arcs.cylinders]


def test_its_points_are_the_triangulated_ones(oblong: Simulation) -> None:
    fused, points = ArcHoughTbfMapper(oblong.rig), TbfMapper(oblong.rig)
    for sweep in oblong:
        fused.add(sweep)
        points.add(sweep)
    np.testing.assert_array_equal(fused.points_xy, points.points_xy)
    assert len(fused.points_xy)
