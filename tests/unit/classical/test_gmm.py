import numpy as np
import pytest

from echoplan.classical.gmm import GmmMapper
from helpers import scenes


def beside(*, wall: float = 2.0, stations: int = 9) -> GmmMapper:
    """A wall along x = 2, detected straight ahead from places along it."""
    mapper = GmmMapper(scenes.rig())
    for index in range(stations):
        ranges = np.full(360, np.inf)
        ranges[45] = wall - scenes.ARM
        mapper.add(scenes.sweep_of(ranges, index=index, pose=(0.0, 0.1 * index, 0.0)))
    return mapper


def test_echoes_beside_each_other_share_a_component() -> None:
    assert len(beside(stations=2).mixture) == 1
    assert len(beside(stations=9).mixture) < 9


def test_components_lie_on_the_wall_and_along_it() -> None:
    mapper = beside()
    assert mapper.points_xy[:, 0] == pytest.approx(2.0)
    for covariance in mapper.mixture.covariances[mapper.mixture.masses > 2]:
        assert covariance[1, 1] != pytest.approx(covariance[0, 0])


def test_components_in_a_row_are_a_wall() -> None:
    (wall,) = beside().result().walls
    assert (wall.normal_angle, wall.offset) == pytest.approx((0.0, 2.0), abs=1e-6)
    assert wall.length == pytest.approx(0.8, abs=0.35)


def test_an_echo_elsewhere_makes_another_component() -> None:
    mapper = beside()
    before = len(mapper.mixture)
    ranges = np.full(360, np.inf)
    ranges[225] = 2.0
    mapper.add(scenes.sweep_of(ranges, index=20))
    assert len(mapper.mixture) == before + 1
