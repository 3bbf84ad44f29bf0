from itertools import pairwise

import numpy as np
import pytest

from echoplan.extraction import arm_excess, cylinder_excess, flat_excess
from helpers import scenes

ANGLES = np.radians(np.arange(-35, 36, 5.0))


def test_flat_excess_is_what_geometry_says() -> None:
    ranges = scenes.wall_ranges(ANGLES, normal=0.0, distance=1.3)
    assert np.allclose(flat_excess(ANGLES, arm=scenes.ARM), ranges - ranges.min())


@pytest.mark.parametrize("radius", [0.0, 0.05, 0.3])
def test_cylinder_excess_is_what_geometry_says(radius: float) -> None:
    ranges = scenes.cylinder_ranges(ANGLES, normal=0.0, distance=1.3, radius=radius)
    excess = cylinder_excess(ANGLES, arm=scenes.ARM, depth=1.3 - scenes.ARM, radius=radius)
    assert np.allclose(excess, ranges - ranges.min())


def test_both_lines_of_equation_five_are_the_same_number() -> None:
    a, b, r, theta = 0.8, 0.07, 0.1, 0.5
    l1, l2 = b * np.sin(theta), a + r + b * (1 - np.cos(theta))
    beta = np.arctan(l1 / l2)
    first = l2 / np.cos(beta) - l2 + b * (1 - np.cos(theta))
    second = l2 / np.cos(np.arctan(l1 / l2)) - a - r
    assert first == pytest.approx(second, abs=1e-15)
    assert cylinder_excess(theta, arm=b, depth=a, radius=r) == pytest.approx(first, abs=1e-15)


def test_an_infinite_radius_is_a_flat_and_the_limit_of_great_ones() -> None:
    flat = arm_excess(ANGLES, arm=0.1, depth=1.0, radius=np.inf)
    assert np.array_equal(flat, flat_excess(ANGLES, arm=0.1))
    assert np.allclose(arm_excess(ANGLES, arm=0.1, depth=1.0, radius=1e6), flat, atol=1e-8)


def test_the_rounder_the_object_the_greater_the_excess() -> None:
    by_radius = [arm_excess(0.6, arm=0.1, depth=1.0, radius=radius) for radius in (0.0, 0.1, 1.0, np.inf)]
    assert all(more > less for more, less in pairwise(by_radius))
