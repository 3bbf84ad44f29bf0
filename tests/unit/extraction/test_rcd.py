import numpy as np
import pytest

from echoplan.extraction import RcdSettings, region_of_constant_depth
from helpers import scenes


def test_the_region_is_the_longest_run_within_the_tolerance() -> None:
    bearings = scenes.around(0.0, np.radians(20))
    ranges = np.where(np.abs(bearings) < np.radians(12.5), 1.0, 1.025)
    region = region_of_constant_depth(scenes.cluster(bearings, ranges))
    assert region is not None
    assert region.depth == pytest.approx(1.0 + scenes.ARM)
    assert (region.bearing_min, region.bearing_max) == pytest.approx((-np.radians(12), np.radians(12)))
    assert region.pings == 25


def test_a_difference_of_just_the_tolerance_is_within() -> None:
    bearings = scenes.around(0.0, np.radians(3))
    ranges = np.array([1.0, 1.005, 1.01, 1.005, 1.0, 1.005, 1.01])
    region = region_of_constant_depth(scenes.cluster(bearings, ranges))
    assert region is not None
    assert region.pings == 7


def test_too_short_a_run_is_no_region() -> None:
    bearings = scenes.around(0.0, np.radians(3))
    steep = scenes.cluster(bearings, 1.0 + 0.02 * np.arange(7.0))
    assert region_of_constant_depth(steep) is None
    assert region_of_constant_depth(steep, RcdSettings(min_pings=1)) is not None


def test_the_middle_of_a_region_is_taken_for_the_normal() -> None:
    bearings = scenes.around(1.0, np.radians(20))
    region = region_of_constant_depth(scenes.cluster(bearings, np.ones(len(bearings))))
    assert region is not None
    point = region.located(resolution=0.005)
    assert point.bearing == pytest.approx(1.0)
    assert point.distance == pytest.approx(1.0 + scenes.ARM)
    # Half the tolerance of 10 mm and the rounding to 5 mm.
    assert np.sqrt(point.covariance[1, 1]) == pytest.approx(np.hypot(0.005, 0.005 / np.sqrt(12)))


def test_a_middle_is_less_sure_where_the_region_is_cut_off_or_does_not_fill_its_cluster() -> None:
    bearings = scenes.around(0.0, np.radians(20))
    even, steep = np.ones(len(bearings)), np.where(np.abs(bearings) < np.radians(12.5), 1.0, 1.015)
    clusters = [
        scenes.cluster(bearings, even),
        scenes.cluster(bearings, steep),
        scenes.cluster(bearings, even, right=0.8),
        scenes.cluster(bearings, even, right=0.8, left=0.8),
    ]
    regions = [region_of_constant_depth(each) for each in clusters]
    sigmas = [np.sqrt(each.located(resolution=0.005).covariance[0, 0]) for each in regions if each is not None]
    assert (np.diff(sigmas) > 0).all()
    assert sigmas[-1] == pytest.approx(np.radians(40) / np.sqrt(12))
