import numpy as np
import pytest

from echoplan.classical.loci import TriangulationSettings
from echoplan.classical.tbf import TbfMapper, TbfSettings
from echoplan.geometry import directions
from echoplan.model import Sweep
from helpers import scenes

POINT = np.array([2.0, 1.0])
STATIONS = [(0.8, 1.1), (0.9, 0.5), (1.2, 0.0), (1.9, -0.2)]


def sweep_at(station: tuple[float, float], *, index: int) -> Sweep:
    """A post detected by the one beam that looks straight at it."""
    ranges = np.full(360, np.inf)
    away = POINT - station
    degree = round(float(np.degrees(np.arctan2(away[1], away[0])))) + 45
    center = scenes.ARM * directions(np.radians(degree - 45.0))
    ranges[degree % 360] = np.hypot(*(away - center))
    return scenes.sweep_of(ranges, index=index, pose=(*station, 0.0))


def mapped(count: int, **settings: int) -> TbfMapper:
    mapper = TbfMapper(scenes.rig(), TbfSettings(triangulation=TriangulationSettings(**settings)))
    for index, station in enumerate(STATIONS[:count]):
        mapper.add(sweep_at(station, index=index))
    return mapper


def test_a_post_is_found_as_soon_as_enough_sweeps_agree() -> None:
    assert len(mapped(1).points_xy) == 0
    assert len(mapped(2).points_xy) == 0
    assert mapped(3).points_xy == pytest.approx(POINT[None], abs=1e-6)
    assert mapped(4).points_xy == pytest.approx(np.tile(POINT, (2, 1)), abs=1e-6)


def test_sweeps_that_left_the_window_are_forgotten() -> None:
    assert len(mapped(4, window=1).points_xy) == 0
    assert len(mapped(4, window=2).points_xy) == 2


def test_the_same_station_again_is_no_second_witness() -> None:
    mapper = TbfMapper(scenes.rig())
    for index in range(4):
        mapper.add(sweep_at(STATIONS[0], index=index))
    assert len(mapper.points_xy) == 0
