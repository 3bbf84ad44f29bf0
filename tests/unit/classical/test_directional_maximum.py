import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.classical.directional_maximum import DirectionalMaximumMapper, DirectionalMaximumSettings
from echoplan.model import Rig
from helpers import scenes


def mapped(rig: Rig, **settings: int) -> DirectionalMaximumMapper:
    """A wall along x = 2, detected by an array that stands before it in many places."""
    mapper = DirectionalMaximumMapper(rig, DirectionalMaximumSettings.model_validate(settings))
    bearings = np.radians(np.arange(360) - 45.0)
    for index, y in enumerate(np.linspace(-0.6, 0.6, 13)):
        detected = np.abs(bearings) < 0.5
        ranges = scenes.wall_ranges(bearings, normal=0.0, distance=2.0)
        mapper.add(scenes.sweep_of(np.where(detected, ranges, np.inf), index=index, pose=(0.0, y, 0.0)))
    return mapper


def before(points_xy: FloatArray) -> FloatArray:
    """How far in front of the wall points lie, along the part that was passed [m]."""
    passed = points_xy[np.abs(points_xy[:, 1]) < 0.5]
    gaps: FloatArray = 2.0 - passed[:, 0]
    return gaps


def test_a_thick_bundle_of_arcs_is_thinned_towards_its_wall() -> None:
    mapper = mapped(scenes.rig())
    assert len(mapper.points_xy) < 0.2 * len(mapper.arcs.counts)
    assert np.median(before(mapper.points_xy)) < 0.02
    assert np.median(before(mapper.arcs.points_xy)) > 0.1


def test_more_directions_keep_more() -> None:
    assert len(mapped(scenes.rig(), directions=2).points_xy) < len(mapped(scenes.rig(), directions=30).points_xy)


def test_cells_of_few_arcs_are_no_maxima() -> None:
    mapper = mapped(scenes.rig(), min_arcs=60)
    assert 0 < len(mapper.points_xy) < len(mapped(scenes.rig()).points_xy)


def test_a_wall_is_found_among_what_is_left() -> None:
    wall = max(mapped(scenes.rig()).result().walls, key=lambda each: each.pings)
    assert (wall.normal_angle, wall.offset) == pytest.approx((0.0, 2.0), abs=0.02)
    assert wall.length > 1.2
