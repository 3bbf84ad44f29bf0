from dataclasses import replace

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.geometry import directions
from echoplan.joint.search.ray_paths import Paths, trace_paths, unoccluded_stations
from echoplan.preprocessing.measurements import Measurements
from helpers.expectations import (
    ROOM,
    STATIONS,
    corner,
    cylinder,
    likelihood,
    listening,
    pings_of,
    rescored,
)

STEP = np.radians(3.0)
COLUMN = cylinder(0.2, 0.9, 0.1)


def traced() -> Paths:
    """Return the paths in a room with a column."""
    estimate = likelihood(pings_of(listening(step=STEP), [*ROOM, COLUMN]))
    return trace_paths(estimate, rescored(estimate, [*ROOM, COLUMN]), step=STEP)


def paths_between(
    *pairs: tuple[tuple[float, float], tuple[float, float]],
    owner: int = 1,
    sure: bool = True,
    stations: tuple[int, ...] | None = None,
) -> Paths:
    """Return paths of one landmark, by default each from a station of its own."""
    return Paths(
        starts_xy=np.array([start for start, _ in pairs]),
        ends_xy=np.array([end for _, end in pairs]),
        owners=np.full(len(pairs), owner),
        sure=np.full(len(pairs), sure),
        stations=np.arange(len(pairs)) if stations is None else np.array(stations),
    )


def test_paths_to_a_wall_are_perpendicular_to_it() -> None:
    paths = traced()
    own = paths.owners == 1
    assert own.sum() > 20
    assert paths.ends_xy[own, 1] == pytest.approx(np.full(own.sum(), 1.5))
    assert paths.ends_xy[own, 0] == pytest.approx(paths.starts_xy[own, 0])


def test_paths_to_a_cylinder_end_at_its_near_side() -> None:
    paths = traced()
    own = paths.owners == 4
    assert own.sum() > 10
    center = COLUMN[1:3]
    assert np.hypot(*(paths.ends_xy[own] - center).T) == pytest.approx(np.full(own.sum(), 0.1))
    longer = np.hypot(*(paths.starts_xy[own] - center).T) - np.hypot(*(paths.starts_xy[own] - paths.ends_xy[own]).T)
    assert longer == pytest.approx(np.full(own.sum(), 0.1))


def test_paths_to_a_corner_end_at_the_corner() -> None:
    vertex = corner(2.0, 1.5)
    estimate = likelihood(pings_of(listening(step=STEP), [vertex]))
    paths = trace_paths(estimate, rescored(estimate, [vertex]), step=STEP)
    assert paths.ends_xy[paths.owners == 0] == pytest.approx(np.tile([2.0, 1.5], ((paths.owners == 0).sum(), 1)))


def test_every_echo_is_associated_with_its_landmark() -> None:
    measurements = pings_of(listening(step=STEP), [*ROOM, COLUMN])
    estimate = likelihood(measurements)
    paths = trace_paths(estimate, rescored(estimate, [*ROOM, COLUMN]), step=STEP)
    depths = np.hypot(*(paths.ends_xy - paths.starts_xy).T)
    known = paths.owners >= 0
    walk = measurements.readings[known] - depths[known]
    assert known.sum() == np.isfinite(measurements.readings).sum()
    assert walk.min() > -0.01
    assert walk.max() < 0.04


def test_unexplained_pings_have_no_owner_and_no_end() -> None:
    measurements = pings_of(listening(step=STEP), ROOM)
    readings = measurements.readings.copy()
    strange = int(np.flatnonzero(np.isfinite(readings))[3])
    readings[strange] -= 0.3
    estimate = likelihood(measurements._replace(readings=readings))
    paths = trace_paths(estimate, rescored(estimate, ROOM), step=STEP)
    assert paths.owners[strange] == -1
    assert not paths.sure[strange]
    assert np.isnan(paths.ends_xy[strange]).all()


def test_without_features_nothing_is_explained() -> None:
    estimate = likelihood(pings_of(listening(step=STEP), ROOM))
    paths = trace_paths(estimate, [], step=STEP)
    assert (paths.owners == -1).all()
    assert not paths.sure.any()


def test_a_multipath_echo_belongs_to_no_landmark() -> None:
    off = corner(2.004, 1.504)
    measurements = pings_of(listening(step=STEP), [*ROOM[:2], corner(2.0, 1.5)])
    estimate = likelihood(measurements)
    alone = trace_paths(estimate, rescored(estimate, [off]), step=STEP)
    beside_walls = trace_paths(estimate, rescored(estimate, [*ROOM[:2], off]), step=STEP)
    detected = alone.owners == 0
    assert detected.sum() > 30
    assert not (beside_walls.owners == 2).any()
    assert (beside_walls.owners[detected] == -1).mean() > 0.9


@pytest.mark.parametrize(("count", "sure"), [(3, False), (4, True)])
def test_pings_that_span_less_than_twelve_degrees_are_not_certain(count: int, *, sure: bool) -> None:
    measurements = pings_of(listening([STATIONS[0]], step=STEP), ROOM[1:2])
    detected = np.flatnonzero(np.isfinite(measurements.readings))
    others = np.setdiff1d(np.arange(len(measurements.readings)), detected[:count])
    measurements.readings[others] = np.inf
    estimate = likelihood(measurements)
    known = replace(estimate.score(ROOM[1]), extent=(-2.0, 2.0))
    paths = trace_paths(estimate, [known], step=STEP)
    assert (paths.owners >= 0).sum() == count
    assert (paths.sure == ((paths.owners >= 0) & sure)).all()


LINE = np.array([0.0, 1.0])


def test_the_feet_of_a_wall_are_the_projections_of_the_sensors() -> None:
    paths = paths_between(((0.0, 0.7), (1.0, 0.7)), ((0.0, -0.2), (1.0, -0.2)), ((0.3, 0.1), (1.0, 0.1)), owner=0)
    assert paths.feet(0, LINE) == pytest.approx([-0.2, 0.1, 0.7])
    assert len(paths.feet(1, LINE)) == 0


def test_paths_to_other_landmarks_cross_the_line_of_a_wall() -> None:
    through = paths_between(((0.0, 0.0), (2.0, 1.0)), ((0.5, -0.2), (1.5, -0.4)))
    assert sorted(through.crossings(0, LINE)) == pytest.approx([-0.3, 0.5])


def test_crossings_of_one_station_to_one_landmark_are_averaged() -> None:
    pairs = ((0.0, 0.0), (2.0, 0.4)), ((0.0, 0.0), (2.0, 0.8)), ((0.0, 0.0), (2.0, -0.4))
    assert paths_between(*pairs, stations=(4, 4, 7)).crossings(0, LINE) == pytest.approx([0.3, -0.2])
    two = paths_between(*pairs, stations=(4, 4, 4))
    apart = Paths(
        starts_xy=two.starts_xy,
        ends_xy=two.ends_xy,
        owners=np.array([1, 2, 2]),
        sure=two.sure,
        stations=two.stations,
    )
    assert apart.crossings(0, LINE) == pytest.approx([0.2, 0.1])


def test_a_crossing_in_the_opposite_direction_counts() -> None:
    assert paths_between(((2.0, 1.0), (0.0, 0.0))).crossings(0, LINE) == pytest.approx([0.5])


@pytest.mark.parametrize(
    "paths",
    [
        paths_between(((0.0, 0.0), (0.9, 1.0))),
        paths_between(((0.0, 0.0), (1.04, 0.0))),
        paths_between(((0.99, 0.0), (2.0, 0.0))),
        paths_between(((0.0, 0.0), (2.0, 1.0)), owner=0),
        paths_between(((0.0, 0.0), (2.0, 1.0)), owner=-1),
        paths_between(((0.0, 0.0), (2.0, 1.0)), sure=False),
    ],
    ids=["ends before", "just touches", "just starts", "its own", "of nobody", "unsure"],
)
def test_uncertain_paths_do_not_cross_a_wall(paths: Paths) -> None:
    assert len(paths.crossings(0, LINE)) == 0


def test_crossings_of_an_oblique_line_lie_on_the_path() -> None:
    line = np.array([0.7, 1.2])
    start, end = np.array([0.1, -0.2]), np.array([2.0, 1.4])
    place = float(paths_between(((0.1, -0.2), (2.0, 1.4))).crossings(0, line)[0])
    point = 1.2 * directions(0.7) + place * directions(0.7 + np.pi / 2)
    share = (point - start) / (end - start)
    assert share[0] == pytest.approx(share[1])
    assert 0.0 < share[0] < 1.0


def visible_from(
    reflector: FloatArray, measurements: Measurements, extent: tuple[float, float] = (-9.0, 9.0)
) -> list[bool]:
    """Return which stations have a free view of a landmark of an extent."""
    (feature,) = rescored(likelihood(measurements), [reflector])
    free: list[bool] = unoccluded_stations(replace(feature, extent=extent), measurements, step=STEP).tolist()
    return free


def test_a_view_is_free_without_nearer_echoes() -> None:
    post = cylinder(0.2, 0.9, 0.1)
    measurements = pings_of(listening(step=STEP), [post])
    nothing = measurements._replace(readings=np.full(len(measurements.readings), np.inf))
    assert visible_from(post, measurements) == visible_from(post, nothing) == [True] * 4
    nearer = np.where(measurements.stations == 2, 0.2, np.inf)
    assert visible_from(post, measurements._replace(readings=nearer)) == [True, True, False, True]


def test_a_wall_is_visible_only_from_stations_before_its_extent() -> None:
    measurements = pings_of(listening(step=STEP), ROOM)
    between = STATIONS[0][1], STATIONS[2][1]
    assert visible_from(ROOM[0], measurements) == [True] * 4
    assert visible_from(ROOM[0], measurements, extent=(between[0] - 0.1, between[1] + 0.1)) == [
        True,
        False,
        True,
        False,
    ]


def test_a_station_before_a_gap_in_a_wall_has_no_view_of_it() -> None:
    # Two stations detect the wall at its ends; the others are before its middle and detect nothing.
    measurements = pings_of(listening([(0.5, y) for y in (-1.0, -0.15, 0.15, 1.0)], step=STEP), ROOM)
    inner = np.isin(measurements.stations, (1, 2))
    (wide,) = rescored(
        likelihood(measurements._replace(readings=np.where(inner, np.inf, measurements.readings))), ROOM[:1]
    )
    assert unoccluded_stations(wide, measurements, step=STEP).tolist() == [True, False, False, True]
    near = pings_of(listening([(0.5, y) for y in (-0.3, -0.1, 0.1, 0.3)], step=STEP), ROOM)
    (narrow,) = rescored(likelihood(near._replace(readings=np.where(inner, np.inf, near.readings))), ROOM[:1])
    assert unoccluded_stations(narrow, near, step=STEP).tolist() == [True] * 4


def test_a_landmark_out_of_range_is_not_visible() -> None:
    assert visible_from(cylinder(9.0, 0.0, 0.1), listening(step=STEP)) == [False] * 4
