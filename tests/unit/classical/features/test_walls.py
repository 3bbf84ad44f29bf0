import numpy as np
import pytest

from echoplan.classical.features import (
    AssociationSettings,
    Group,
    Span,
    WallSettings,
    detected_span,
    group_lines,
    junctions,
    walls_of,
)
from echoplan.classical.features.walls import opened_by
from echoplan.model import Wall
from helpers import scenes

GATES = AssociationSettings()
SOUTH, EAST = (-np.pi / 2, 0.0), (0.0, 3.0)
HUBS = [(0.6, 1.0), (1.4, 0.7), (2.2, 1.3)]
WAVELENGTH = 0.0086


def group_of(line: tuple[float, float]) -> Group:
    """One line as three ideal sweeps would locate it."""
    (group,) = group_lines([scenes.observed_wall(line, hub, sweep=k) for k, hub in enumerate(HUBS)], GATES)
    return group


def test_a_wall_detected_once_is_a_fresnel_zone_long() -> None:
    (group,) = group_lines([scenes.observed_wall(EAST, (1.0, 1.0))], GATES)
    span = detected_span(group, WallSettings())
    assert span.high - span.low == pytest.approx(2 * np.sqrt(WAVELENGTH * 2.0 / 2))


def test_a_wall_is_as_long_as_it_was_detected_with_the_zone_of_each_echo() -> None:
    span = detected_span(group_of(SOUTH), WallSettings())
    zones = [np.sqrt(WAVELENGTH * depth / 2) for depth in (1.0, 1.3)]
    assert (span.low, span.high) == pytest.approx((0.6 - zones[0], 2.2 + zones[1]), abs=1e-6)


def test_longer_waves_make_longer_zones() -> None:
    short, long = (detected_span(group_of(SOUTH), WallSettings(wavelength=wave)) for wave in (0.0043, 0.0086))
    assert long.low < short.low < short.high < long.high


def test_a_wall_goes_on_to_where_it_meets_its_neighbour_and_no_farther_at_its_free_end() -> None:
    groups = [group_of(SOUTH), group_of(EAST)]
    spans = [detected_span(group, WallSettings()) for group in groups]
    south, east = walls_of(groups, spans, junctions(spans, max_extension=2.0))
    assert south.endpoints_xy == pytest.approx(np.array([spans[0].point_xy(spans[0].low), [3.0, 0.0]]), abs=1e-6)
    assert east.endpoints_xy == pytest.approx(np.array([[3.0, 0.0], spans[1].point_xy(spans[1].high)]), abs=1e-6)


def test_without_junctions_walls_end_where_they_were_last_detected() -> None:
    span = Span(line=np.array(SOUTH), low=0.2, high=1.7)
    (wall,) = walls_of([group_of(SOUTH)], [span], [])
    assert wall.endpoints_xy == pytest.approx(np.array([[0.2, 0.0], [1.7, 0.0]]), abs=1e-9)


def test_a_wall_records_its_pings_and_stations() -> None:
    group = group_of(SOUTH)
    (wall,) = walls_of([group], [detected_span(group, WallSettings())], [])
    assert (wall.stations, wall.pings) == (3, 120)
    assert wall.class_probabilities.wall == 1.0
    assert (wall.normal_angle, wall.offset) == pytest.approx(SOUTH, abs=1e-9)
    np.testing.assert_array_equal(wall.covariance, group.fit.covariance)


def test_a_wall_is_cut_where_the_robot_drove_through_it() -> None:
    wall = Wall(
        normal_angle=0.0,
        offset=1.0,
        endpoints_xy=np.array([[1.0, -1.0], [1.0, 1.0]]),
        covariance=np.eye(2) * 1e-6,
        pings=200,
    )
    path = np.array([[0.0, 0.5], [2.0, 0.5], [2.0, 3.0], [0.0, 3.0]])
    lower, upper = opened_by(path, [wall])
    np.testing.assert_allclose(lower.endpoints_xy, [[1.0, -1.0], [1.0, 0.4]])
    np.testing.assert_allclose(upper.endpoints_xy, [[1.0, 0.6], [1.0, 1.0]])
    assert (lower.pings, upper.pings) == (140, 40)
    assert opened_by(path[:1], [wall]) == (wall,)
    assert opened_by(path, [lower]) == (lower,)


def test_nothing_is_left_of_a_wall_that_is_hardly_wider_than_the_robot() -> None:
    wall = Wall(
        normal_angle=0.0, offset=1.0, endpoints_xy=np.array([[1.0, 0.0], [1.0, 0.3]]), covariance=np.eye(2) * 1e-6
    )
    assert opened_by(np.array([[0.0, 0.15], [2.0, 0.15]]), [wall]) == ()
