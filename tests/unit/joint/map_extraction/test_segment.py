import numpy as np
import pytest

from echoplan.joint.map_extraction.segment import CELL, End
from helpers.outlines import segment

UNIFORM = End(np.arange(0.0, 1.001, CELL), np.full(51, 0.4))


def test_the_interval_of_a_uniform_end_holds_95_percent() -> None:
    # Each place stands for the width of a cell about it: from -0.01 to 1.01.
    assert UNIFORM.interval == pytest.approx([-0.01 + 0.025 * 1.02, 0.5, 1.01 - 0.025 * 1.02])
    assert UNIFORM.place == pytest.approx(0.5)
    assert UNIFORM.sigma == pytest.approx(0.95 * 1.02 / (2 * 1.96))


def test_the_interval_of_a_normal_end_is_1_96_sigmas_to_each_side() -> None:
    end = End.normal(2.0, 0.05)
    assert end.interval == pytest.approx([2.0 - 1.96 * 0.05, 2.0, 2.0 + 1.96 * 0.05], abs=0.002)
    assert end.sigma == pytest.approx(0.05, rel=0.02)


def test_an_end_at_one_border_has_the_width_of_a_cell() -> None:
    end = End(np.array([0.3]), np.array([0.9]))
    assert end.interval == pytest.approx([0.3 - 0.475 * CELL, 0.3, 0.3 + 0.475 * CELL])


def test_the_place_of_a_skewed_end_is_its_median() -> None:
    end = End(np.array([0.0, 0.1, 0.2, 0.3]), np.array([3.0, 1.0, 1.0, 1.0]))
    assert end.place == pytest.approx(0.05)


def test_a_reversed_end_has_the_negated_interval() -> None:
    end = End(np.array([0.0, 0.1, 0.2, 0.3]), np.array([3.0, 1.0, 1.0, 1.0]))
    assert end.reversed().interval == pytest.approx(-end.interval[::-1])
    assert end.reversed().sigma == pytest.approx(end.sigma)


def test_two_consistent_ends_have_a_smaller_sigma_together() -> None:
    one, other = End.normal(1.0, 0.03), End.normal(1.02, 0.04)
    joined = one.joined(other)
    # Precisions add, and the mean is nearer to the narrower distribution.
    assert joined.sigma == pytest.approx(0.024, rel=0.03)
    assert joined.place == pytest.approx(1.0 + 0.02 * 9 / 25, abs=0.001)
    assert other.joined(one).interval == pytest.approx(joined.interval)


def test_of_two_inconsistent_ends_the_narrower_is_used() -> None:
    one, other = End.normal(1.0, 0.02), End.normal(1.5, 0.06)
    for joined in (one.joined(other), other.joined(one)):
        assert joined.interval == pytest.approx(one.interval)


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_the_consistency_of_ends_does_not_depend_on_their_normalisation(factor: float) -> None:
    one = End.normal(1.0, 0.01)
    scaled = End(one.places, factor * one.chances)
    for apart in (0.0, 0.1, 0.15, 0.2, 0.5):
        other = End.normal(1.0 + apart, 0.06)
        assert scaled.joined(other).interval == pytest.approx(one.joined(other).interval)


def test_places_along_a_segment_are_points_on_its_line() -> None:
    slanted = segment(0.7, 1.2, (0.2, 0.8))
    normal = np.array([np.cos(0.7), np.sin(0.7)])
    assert slanted.point(0.2) @ normal == pytest.approx(1.2)
    assert slanted.point(0.2) @ slanted.along == pytest.approx(0.2)
    assert slanted.middle_xy == pytest.approx(0.5 * (slanted.point(0.2) + slanted.point(0.8)))


def test_a_stretch_is_free_if_one_of_its_cells_is_certainly_no_wall() -> None:
    doubtful, free = (segment(0.0, 1.0, (-0.8, 0.4), free=0.61, chance=chance) for chance in (0.06, 0.04))
    assert free.is_free(0.4, 0.8)
    assert free.is_open_toward(np.array([1.0, 0.8]))
    for each, low, high in ((doubtful, 0.4, 0.8), (free, 0.4, 0.58), (free, 0.64, 0.8), (free, 0.61, 0.61)):
        assert not each.is_free(low, high)
    # A free cell next to the corner does not count.
    assert not free.is_open_toward(np.array([1.0, 0.62]))


def test_the_probability_up_to_a_point_is_that_of_the_weakest_cell() -> None:
    weak = segment(0.0, 1.0, (-0.8, 0.4), free=0.61, chance=0.3)
    assert weak.chance_up_to(np.array([1.0, 0.9])) == pytest.approx(0.3)
    assert weak.chance_up_to(np.array([1.0, 0.55])) == pytest.approx(0.9)
    assert weak.chance_up_to(np.array([1.0, -1.5])) == pytest.approx(0.9)
    assert weak.chance_up_to(np.array([1.0, 0.4])) == 1.0
