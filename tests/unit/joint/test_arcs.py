from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from echoplan.arrays import BoolArray, FloatArray
from echoplan.geometry import wrap
from echoplan.joint.arcs import Arc, ArcSettings, arc_planes, find_arcs
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import ROOM, SONAR, cylinder, expected, listening, pings_of, wall

SETTINGS = ArcSettings()
DEGREE = np.radians(1.0)


def arcs_of(measurements: Measurements, *, resolution: float = 0.001, **settings: Any) -> list[Arc]:
    """Return the arcs at a resolution that is fine enough not to matter."""
    return find_arcs(measurements, resolution=resolution, settings=ArcSettings(**settings))


def single_landmark(reflector: FloatArray, *, step: float = DEGREE) -> Measurements:
    """Return the pings of one station at the origin, which detect one landmark."""
    return pings_of(listening([(0.0, 0.0)], step=step), [reflector])


def without_echoes(measurements: Measurements, pings: slice | BoolArray) -> Measurements:
    """Return the measurements without echoes in some pings."""
    readings = measurements.readings.copy()
    readings[pings] = np.inf
    return measurements._replace(readings=readings)


def test_two_walls_are_two_arcs_from_each_station() -> None:
    measurements, sonar = pings_of(listening(step=DEGREE), ROOM[[0, 2]]), SONAR.tabulated()
    arcs = arcs_of(measurements)
    assert [arc.station for arc in arcs] == [0, 0, 1, 1, 2, 2, 3, 3]
    assert all((measurements.stations[arc.pings] == arc.station).all() for arc in arcs)
    planes = arc_planes(arcs, measurements, sonar)
    assert sorted(np.round(np.abs(wrap(planes[:, 0])), 1)) == [0.0] * 4 + [3.1] * 4
    assert planes[:, 1] == pytest.approx(2.0, abs=0.01)


def test_an_arc_holds_all_echoes_of_its_reflector() -> None:
    measurements = single_landmark(cylinder(1.0, 0.5, 0.1))
    (arc,) = arcs_of(measurements)
    assert sorted(arc.pings) == np.flatnonzero(np.isfinite(measurements.readings)).tolist()


def test_an_arc_wraps_around_the_seam_of_the_circle() -> None:
    measurements = single_landmark(wall(np.pi, 1.0))
    (arc,) = arcs_of(measurements)
    assert {0, len(measurements.readings) - 1} <= set(arc.pings.tolist())


def arcs_at_a_corner(step: float) -> list[Arc]:
    """Return the arcs of two equally near walls, with a beam so wide that every ping detects one of them."""
    return arcs_of(pings_of(listening([(0.0, 0.0)], step=step), [wall(0.0, 0.5), wall(np.pi / 2, 0.52)]))


def test_arcs_of_two_equally_near_walls_are_split_at_the_range_maximum() -> None:
    arcs = arcs_at_a_corner(DEGREE)
    assert len(arcs) == 2
    detected = single_landmark(wall(0.0, 0.5)).bearings
    east, north = sorted(float(np.median(detected[each.pings])) for each in arcs)
    assert (east, north) == pytest.approx((0.0, np.pi / 2), abs=np.radians(5))


def test_arcs_of_sparse_pings_are_not_split_at_range_maxima() -> None:
    assert len(arcs_at_a_corner(np.radians(5.0))) == 1


@pytest.mark.parametrize("missing", [1, 2, 3])
def test_an_arc_survives_dropouts(missing: int) -> None:
    measurements = single_landmark(wall(0.0, 1.0))
    middle = int(np.argmin(np.abs(measurements.bearings)))
    assert len(arcs_of(without_echoes(measurements, slice(middle, middle + missing)))) == 1


def test_a_wider_gap_ends_an_arc() -> None:
    measurements = single_landmark(wall(0.0, 1.0))
    middle = int(np.argmin(np.abs(measurements.bearings)))
    assert len(arcs_of(without_echoes(measurements, slice(middle, middle + 6)))) == 2


def test_a_stray_echo_does_not_break_an_arc() -> None:
    measurements = single_landmark(wall(0.0, 1.0))
    detected = np.isfinite(measurements.readings).sum()
    readings = measurements.readings.copy()
    readings[np.argmin(np.abs(measurements.bearings))] = 0.4
    (arc,) = arcs_of(measurements._replace(readings=readings))
    assert len(arc.pings) == detected - 1


def test_a_jump_in_range_ends_an_arc() -> None:
    measurements = single_landmark(wall(0.0, 1.0))
    readings = np.where(measurements.bearings > 0.0, measurements.readings + 0.03, measurements.readings)
    assert len(arcs_of(measurements._replace(readings=readings))) == 2


def test_coarse_readings_jump_by_their_steps_without_ending_an_arc() -> None:
    measurements = single_landmark(wall(0.0, 1.0))
    readings = np.where(measurements.bearings > 0.0, measurements.readings + 0.03, measurements.readings)
    assert len(arcs_of(measurements._replace(readings=readings), resolution=0.03)) == 1


@pytest.mark.parametrize(("degrees", "least"), [(1.0, 3), (5.0, 2), (22.5, 1)])
def test_sparser_pings_need_fewer_echoes_for_an_arc(degrees: float, least: int) -> None:
    silent = listening([(0.0, 0.0)], step=np.radians(degrees))
    for count in (1, 2, 3):
        readings = silent.readings.copy()
        readings[3 : 3 + count] = 1.0
        assert bool(arcs_of(silent._replace(readings=readings))) == (count >= least)


def test_pings_without_echoes_give_no_arcs() -> None:
    assert arcs_of(listening()) == []


def test_arcs_never_join_pings_of_two_stations() -> None:
    measurements = pings_of(listening([(0.0, 0.0), (0.0, 0.001)], step=DEGREE), [wall(0.0, 1.0)])
    assert [arc.station for arc in arcs_of(measurements)] == [0, 1]


@pytest.mark.parametrize("normal", [-3.1, -1.0, 0.2, 2.5])
@pytest.mark.parametrize("offset", [0.4, 1.2, 2.6])
def test_the_plane_of_an_arc_is_the_wall_within_a_degree(normal: float, offset: float) -> None:
    measurements = single_landmark(wall(normal, offset))
    ((angle, found),) = arc_planes(arcs_of(measurements), measurements, SONAR.tabulated())
    assert abs(np.degrees(wrap(angle - normal))) < 1.0
    assert found == pytest.approx(offset, abs=0.001)


def test_planes_keep_the_order_of_their_arcs() -> None:
    measurements = pings_of(listening([(0.3, 0.1)], step=DEGREE), ROOM)
    arcs, sonar = arcs_of(measurements), SONAR.tabulated()
    together = arc_planes(arcs, measurements, sonar)
    for arc, plane in zip(arcs, together, strict=True):
        assert arc_planes([arc], measurements, sonar)[0] == pytest.approx(plane)


def test_the_plane_of_half_an_arc_is_near_the_wall() -> None:
    measurements = single_landmark(wall(0.0, 1.0))
    half = without_echoes(measurements, measurements.bearings < 0.0)
    ((angle, offset),) = arc_planes(arcs_of(half), half, SONAR.tabulated())
    middle = float(np.mean(half.bearings[np.isfinite(half.readings)]))
    # The range walk shows on which side of an arc the perpendicular is: weak echoes are far from it.
    assert abs(angle) < 0.5 * middle
    assert offset == pytest.approx(1.0, abs=0.01)


def test_a_few_outliers_in_an_arc_do_not_move_its_plane() -> None:
    measurements = single_landmark(wall(0.0, 1.0))
    (arc,) = arcs_of(measurements)
    readings = measurements.readings.copy()
    readings[arc.pings[::9]] += 0.3
    ((angle, offset),) = arc_planes([arc], measurements._replace(readings=readings), SONAR.tabulated())
    assert abs(np.degrees(angle)) < 3.0
    assert offset == pytest.approx(1.0, abs=0.003)


def test_short_readings_are_scaled_before_planes_are_fitted() -> None:
    warm = replace(SONAR, range_scale=0.05)
    silent = listening([(0.0, 0.0)], step=DEGREE)
    measurements = pings_of(silent, [wall(0.4, 2.0)], sonar=warm)
    assert expected(silent, wall(0.4, 2.0), warm)[1].min() < 1.95
    ((_, offset),) = arc_planes(arcs_of(measurements), measurements, warm.tabulated())
    assert offset == pytest.approx(2.0, abs=0.002)


def test_an_arc_returns_the_share_of_its_pings_in_a_mask() -> None:
    chosen = np.array([True, False, True, True, True])
    assert Arc(station=0, pings=np.array([0, 1, 3])).share_of(chosen) == pytest.approx(2 / 3)
