import numpy as np

from echoplan.classical.rcd import RcdMapper
from echoplan.evaluation import evaluate
from echoplan.io import builtin_rig, builtin_route, builtin_world
from echoplan.simulation import Simulation
from helpers import chamber, scenes


def test_regions_of_a_cylinder_and_of_a_corner_make_no_walls() -> None:
    simulation = Simulation(
        world=builtin_world("paper-room"), rig=builtin_rig("rotary-array"), route=builtin_route("paper-room"), seed=1
    )
    mapper = RcdMapper(simulation.rig)
    for sweep in simulation:
        mapper.add(sweep)
    matches = evaluate(mapper.result(), simulation.truth).matches
    assert len(matches.walls.found) == 8
    assert len(matches.walls.spurious) == len(matches.walls.duplicate) == 0
    assert len(matches.cylinders.found) == 1


def test_a_repeated_map_is_the_same() -> None:
    mapper = RcdMapper(scenes.rig())
    for number, hub in enumerate(chamber.HUBS):
        mapper.add(chamber.recorded(hub, index=number))
    first, second = mapper.result(), mapper.result()
    np.testing.assert_array_equal([each.offset for each in first.walls], [each.offset for each in second.walls])
    assert first.walls
