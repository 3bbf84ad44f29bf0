from dataclasses import replace

import numpy as np
import pytest

from echoplan.classical.features.fusion import FusionSettings, fuse_walls, segment_of_wall
from echoplan.model import Wall
from helpers import maps

SETTINGS = FusionSettings()


def wall_of(stations: int, *, height: float = 2.0) -> Wall:
    return replace(maps.wall([0.0, height], [3.0, height]), stations=stations)


def test_a_tangent_and_a_line_that_agree_become_one_surer_wall() -> None:
    (fused,) = fuse_walls([wall_of(2)], [wall_of(0, height=2.02)], SETTINGS)
    assert abs(fused.line[1]) == pytest.approx(2.01)
    assert np.linalg.eigvalsh(wall_of(2).covariance - fused.covariance).min() > 0


def test_of_several_lines_the_one_that_fits_best_is_the_witness() -> None:
    (fused,) = fuse_walls([wall_of(2)], [wall_of(0, height=2.03), wall_of(0, height=2.01)], SETTINGS)
    assert abs(fused.line[1]) == pytest.approx(2.005)


@pytest.mark.parametrize("lines", [[], [wall_of(0, height=2.5)]])
def test_a_tangent_without_a_witness_needs_a_third_station(lines: list[Wall]) -> None:
    assert fuse_walls([wall_of(2)], lines, SETTINGS) == []
    (alone,) = fuse_walls([wall_of(3)], lines, SETTINGS)
    assert alone.covariance == pytest.approx(wall_of(3).covariance)


def test_a_line_that_no_arc_touches_is_no_wall() -> None:
    assert fuse_walls([], [wall_of(0)], SETTINGS) == []


def test_a_wall_and_its_segment_have_the_same_ends() -> None:
    wall = maps.wall([1.0, 2.0], [3.0, 5.0])
    ends = segment_of_wall(wall).ends_xy
    assert sorted(map(tuple, ends.round(9))) == [(1.0, 2.0), (3.0, 5.0)]
