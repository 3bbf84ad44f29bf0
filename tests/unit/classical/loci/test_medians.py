import pytest

from echoplan.classical.loci import Loci, MedianSettings, transversal_medians
from helpers import arcs

POINT = (3.0, 1.0)
STATIONS = [(1.0, 1.0), (3.1, -0.8), (2.6, 2.8), (3.8, 2.2)]


def test_the_median_is_on_the_point_however_far_the_axis_is_off() -> None:
    own = arcs.on_point(POINT, STATIONS[:1], turns=(0.3,))
    medians = transversal_medians(own, arcs.on_point(POINT, STATIONS[1:]), MedianSettings())
    assert medians.arcs.tolist() == [0]
    assert medians.turns == pytest.approx([-0.3])


def test_a_stray_arc_does_not_move_the_median() -> None:
    own = arcs.on_point(POINT, STATIONS[:1], turns=(0.3,))
    stray = arcs.on_point((2.99, 1.2), [(3.3, -0.9)])
    medians = transversal_medians(
        own, Loci.joined([arcs.on_point(POINT, STATIONS[1:]), stray]), MedianSettings(min_crossings=4)
    )
    assert medians.turns == pytest.approx([-0.3])


def test_of_an_even_number_the_median_lies_in_the_middle() -> None:
    own = arcs.on_point(POINT, STATIONS[:1])
    two = Loci.joined([arcs.on_point(POINT, STATIONS[1:2]), arcs.on_point((2.99, 1.2), [(3.3, -0.9)])])
    (turn,) = transversal_medians(own, two, MedianSettings(min_crossings=2)).turns
    assert 0.02 < turn < 0.08


def test_an_arc_that_is_seldom_crossed_has_no_median() -> None:
    own = arcs.on_point(POINT, STATIONS[:1])
    others = arcs.on_point(POINT, STATIONS[1:3])
    assert len(transversal_medians(own, others, MedianSettings()).arcs) == 0
    assert len(transversal_medians(own, others, MedianSettings(min_crossings=2)).arcs) == 1


def test_each_arc_has_a_median_of_its_own() -> None:
    loci = Loci.joined([arcs.on_point(POINT, STATIONS, turns=(0.2, -0.1)), arcs.on_point((9.0, 9.0), [(8.0, 9.0)])])
    medians = transversal_medians(loci, loci, MedianSettings())
    assert medians.arcs.tolist() == list(range(8))
    assert medians.turns == pytest.approx([-0.2, 0.1] * 4)
