import numpy as np
import pytest

from echoplan.classical.loci import Loci, find_crossings
from helpers import arcs

POINT = (3.0, 1.0)


def test_two_arcs_of_a_point_cross_in_it() -> None:
    first, second = arcs.on_point(POINT, [(0.0, 0.0)]), arcs.on_point(POINT, [(2.0, -1.5)])
    (crossing,) = find_crossings(first, second, min_angle=0.5).points_xy
    assert crossing == pytest.approx(POINT)


def test_flat_crossings_are_none() -> None:
    first, second = arcs.on_point(POINT, [(0.0, 0.0)]), arcs.on_point(POINT, [(0.5, -0.4)])
    angle = float(np.arctan2(1, 3) - np.arctan2(1.4, 2.5))
    assert len(find_crossings(first, second, min_angle=abs(angle) + 1e-6).first) == 0
    assert len(find_crossings(first, second, min_angle=abs(angle) - 1e-6).first) == 1


@pytest.mark.parametrize("turn", [-1.0, 1.0])
def test_what_lies_beside_a_beam_is_not_on_its_arc(turn: float) -> None:
    first = arcs.on_point(POINT, [(0.0, 0.0)])
    just = arcs.on_point(POINT, [(2.0, -1.5)], turns=(turn * (arcs.HALF_APERTURE - 1e-6),))
    beyond = arcs.on_point(POINT, [(2.0, -1.5)], turns=(turn * (arcs.HALF_APERTURE + 1e-6),))
    assert len(find_crossings(first, just, min_angle=0.5).first) == 1
    assert len(find_crossings(first, beyond, min_angle=0.5).first) == 0
    assert len(find_crossings(beyond, first, min_angle=0.5).first) == 0


def test_arcs_about_one_centre_and_arcs_apart_do_not_cross() -> None:
    one = arcs.on_point(POINT, [(0.0, 0.0)])
    assert len(find_crossings(one, one, min_angle=0.1).first) == 0
    far = arcs.on_point((30.0, 1.0), [(27.0, 0.0)])
    assert len(find_crossings(one, far, min_angle=0.1).first) == 0


def test_crossings_of_many_are_those_of_each_pair() -> None:
    rng = np.random.default_rng(1)
    loci = Loci(
        centers_xy=rng.uniform(0, 3, size=(300, 2)),
        ranges=rng.uniform(0.3, 3, size=300),
        bearings=rng.uniform(-4, 4, size=300),
        half_apertures=rng.uniform(0.1, 0.6, size=300),
        sweeps=np.arange(300),
    )
    crossings = find_crossings(loci, loci, min_angle=0.4)
    one, other = loci[crossings.first], loci[crossings.second]
    for arc in (one, other):
        assert np.hypot(*(crossings.points_xy - arc.centers_xy).T) == pytest.approx(arc.ranges)
        assert (np.abs(arc.turns(crossings.points_xy)) <= arc.half_apertures + 1e-9).all()
    pairs = set(zip(crossings.first.tolist(), crossings.second.tolist(), strict=True))
    assert pairs == {(b, a) for a, b in pairs}
    alone = find_crossings(loci[270:271], loci, min_angle=0.4)
    assert sorted(alone.second.tolist()) == sorted(crossings.second[crossings.first == 270].tolist())


def test_without_arcs_there_are_no_crossings() -> None:
    one = arcs.on_point(POINT, [(0.0, 0.0)])
    for first, second in ((arcs.nothing(), one), (one, arcs.nothing())):
        assert find_crossings(first, second, min_angle=0.5).points_xy.shape == (0, 2)
