import numpy as np
import pytest

from echoplan.classical.loci import Loci, Triangulated, TriangulationSettings, triangulate
from helpers import arcs

POINT = (3.0, 1.0)
STATIONS = [(1.0, 1.0), (1.4, 0.0), (2.0, -0.7), (3.1, -0.8)]
SETTINGS = TriangulationSettings()


def test_a_point_is_counted_once_for_each_sweep_that_detected_it() -> None:
    newest = arcs.on_point(POINT, STATIONS[:1], turns=(0.2,))
    found = triangulate(newest, arcs.on_point(POINT, STATIONS[1:], turns=(-0.1, 0.0, 0.1)), SETTINGS)
    assert found.counts.tolist() == [3]
    assert found.points_xy == pytest.approx(np.array([POINT]))
    assert found.origins_xy == pytest.approx(np.array(STATIONS[:1]))


def test_a_single_station_makes_no_point_however_often_it_pings() -> None:
    newest = arcs.on_point(POINT, STATIONS[:1])
    once = arcs.on_point(POINT, STATIONS[3:], turns=np.linspace(-0.3, 0.3, 60).tolist())
    assert len(triangulate(newest, once, SETTINGS).counts) == 0
    assert triangulate(newest, once, TriangulationSettings(min_sweeps=1)).counts.tolist() == [1]


def test_crossings_apart_do_not_agree() -> None:
    newest = arcs.on_point(POINT, STATIONS[:1])
    elsewhere = arcs.on_point((2.97, 1.35), STATIONS[2:3])
    earlier = Loci.joined([arcs.on_point(POINT, STATIONS[3:]), elsewhere])
    assert len(triangulate(newest, earlier, SETTINGS).counts) == 0


def test_the_fullest_stretch_of_an_arc_wins() -> None:
    newest = arcs.on_point(POINT, STATIONS[:1])
    elsewhere = arcs.on_point((2.97, 1.35), [(3.3, -0.9)])
    found = triangulate(newest, Loci.joined([elsewhere, arcs.on_point(POINT, STATIONS[1:])]), SETTINGS)
    assert found.points_xy == pytest.approx(np.array([POINT]))


def test_the_point_is_the_mean_of_what_agrees() -> None:
    newest = arcs.on_point(POINT, STATIONS[:1])
    beside = arcs.on_point((3.0, 1.01), STATIONS[2:3])
    beside = Loci(
        centers_xy=beside.centers_xy,
        ranges=beside.ranges,
        bearings=beside.bearings,
        half_apertures=beside.half_apertures,
        sweeps=np.array([7]),
    )
    (point,) = triangulate(newest, Loci.joined([arcs.on_point(POINT, STATIONS[3:]), beside]), SETTINGS).points_xy
    assert point == pytest.approx([3.0, 1.005], abs=2e-3)


def test_without_arcs_no_point_is_triangulated() -> None:
    one = arcs.on_point(POINT, STATIONS)
    for newest, earlier in ((one, arcs.nothing()), (arcs.nothing(), one), (arcs.nothing(), arcs.nothing())):
        assert triangulate(newest, earlier, SETTINGS).points_xy.shape == (0, 2)
    assert Triangulated.joined([]).points_xy.shape == (0, 2)
