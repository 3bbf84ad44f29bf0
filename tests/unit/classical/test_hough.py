import numpy as np
import pytest

from echoplan.classical.hough import HoughMapper
from echoplan.classical.loci import Loci, find_reflectors
from echoplan.geometry import directions
from echoplan.model import CornerKind
from helpers import scenes

pytestmark = pytest.mark.slow

STATIONS = [(0.6, 0.5), (1.4, 0.7), (1.0, 1.2), (0.7, 1.4)]
BEARINGS = np.radians(np.arange(360) - 45.0)


def room_corner() -> HoughMapper:
    """Two walls, x = 2.4 and y = 2.2, each detected over half a radian to either side of its normal."""
    mapper = HoughMapper(scenes.rig())
    for index, (x, y) in enumerate(STATIONS):
        ranges = np.full(360, np.inf)
        for normal, distance in ((0.0, 2.4 - x), (np.pi / 2, 2.2 - y)):
            detected = np.cos(BEARINGS - normal) > np.cos(0.5)
            ranges[detected] = scenes.wall_ranges(BEARINGS, normal=normal, distance=distance)[detected]
        mapper.add(scenes.sweep_of(ranges, index=index, pose=(x, y, 0.0)))
    return mapper


def pillar(radius: float, stations: list[tuple[float, float]]) -> HoughMapper:
    """A pillar at (1.5, 1.5), detected from around."""
    mapper = HoughMapper(scenes.rig())
    for index, station in enumerate(stations):
        away = np.array([1.5, 1.5]) - station - scenes.ARM * directions(BEARINGS)
        detected = np.cos(np.arctan2(away[:, 1], away[:, 0]) - BEARINGS) > np.cos(0.4)
        ranges = np.where(detected, np.hypot(*away.T) - radius, np.inf)
        mapper.add(scenes.sweep_of(ranges, index=index, pose=(*station, 0.0)))
    return mapper


AROUND = [(0.5, 1.5), (1.5, 0.4), (2.6, 1.6), (1.3, 2.7)]


def test_tangents_of_two_walls_are_two_walls_that_meet() -> None:
    found = room_corner().result()
    lines = sorted((wall.normal_angle, wall.offset) for wall in found.walls)
    assert np.array(lines) == pytest.approx(np.array([(0.0, 2.4), (np.pi / 2, 2.2)]), abs=2e-3)
    (corner,) = found.corners
    assert corner.kind is CornerKind.CONCAVE
    assert corner.position_xy == pytest.approx([2.4, 2.2], abs=5e-3)


def test_a_wall_knows_its_stations_and_pings() -> None:
    for wall in room_corner().result().walls:
        assert wall.stations == 4
        assert wall.pings == pytest.approx(4 * 57, abs=16)


@pytest.mark.parametrize("seed", [0, 1])
def test_random_ranges_are_no_walls(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mapper = HoughMapper(scenes.rig())
    for index in range(10):
        pose = (*rng.uniform(0.0, 4.0, 2).tolist(), 0.0)
        mapper.add(scenes.sweep_of(rng.uniform(0.1, 3.0, len(BEARINGS)), index=index, pose=pose))
    assert mapper.result().is_empty
    assert len(mapper.points_xy) == 0


def test_echoes_are_drawn_where_they_come_from() -> None:
    points = room_corner().points_xy
    on_walls = np.minimum(np.abs(points[:, 0] - 2.4), np.abs(points[:, 1] - 2.2))
    assert np.quantile(on_walls, 0.95) < 0.005


def test_a_pillar_is_round_and_a_post_is_not() -> None:
    (cylinder,) = pillar(0.02, AROUND[:3]).result().cylinders or (None,)
    assert cylinder is None
    post = pillar(0.0, AROUND)
    loci = Loci.joined(post._loci)
    grouped = post.group(find_reflectors(loci, post.settings.votes), loci)
    assert grouped.cylinders == []
    assert {each.sweep for each in grouped.corners} == {0, 1, 2, 3}
