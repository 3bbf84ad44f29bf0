import numpy as np
import pytest

from echoplan.classical.point_plot import PointPlotMapper
from helpers import scenes

WALL = 2.0
HALF_BEAM = 30


def faced() -> PointPlotMapper:
    """A wall along x = 2 that a station reads at one range from 30 degrees to either side of its normal."""
    ranges = np.full(360, np.inf)
    ranges[45 - HALF_BEAM : 45 + HALF_BEAM + 1] = WALL - scenes.ARM
    mapper = PointPlotMapper(scenes.rig())
    mapper.add(scenes.sweep_of(ranges))
    return mapper


def test_a_wall_is_drawn_as_an_arc_about_the_station() -> None:
    points = faced().points_xy
    assert len(points) == 2 * HALF_BEAM + 1
    assert np.hypot(*points.T) == pytest.approx(WALL)
    assert points[:, 0].min() == pytest.approx(WALL * np.cos(np.radians(HALF_BEAM)))


def test_what_only_one_station_detected_is_drawn_and_is_no_wall() -> None:
    assert faced().result().walls == ()


def test_a_wall_that_many_stations_face_is_a_wall() -> None:
    mapper = PointPlotMapper(scenes.rig())
    for index in range(9):
        ranges = np.full(360, np.inf)
        ranges[45] = WALL - scenes.ARM
        mapper.add(scenes.sweep_of(ranges, index=index, pose=(0.0, 0.1 * index, 0.0)))
    (wall,) = mapper.result().walls
    assert (wall.normal_angle, wall.offset) == pytest.approx((0.0, WALL), abs=1e-6)
    assert wall.stations == 9
