from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.acoustics.predicted_echo import EchoModel, Kind
from echoplan.arrays import BoolArray, FloatArray
from echoplan.joint.arcs import ArcSettings, find_arcs
from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.search.search import Search, SearchSettings
from echoplan.preprocessing.measurements import Measurements, join_measurements, measurements_of, select_measurements
from echoplan.sources import open_source
from helpers.constants import settings_with
from helpers.expectations import (
    NOISE,
    ROOM,
    SONAR,
    STATIONS,
    corner,
    cylinder,
    expected,
    likelihood,
    listening,
    pings_of,
    wall,
)

HALF_APERTURE = 0.61
# East, north, west and south of the square of 3 x 3 m, as seen from within.
SQUARE = np.array([wall(0.0, 2.0), wall(np.pi / 2, 2.5), wall(np.pi, 1.0), wall(-np.pi / 2, 0.5)])


def search_in(
    measurements: Measurements, *, sonar: EchoModel = SONAR, noise: float = NOISE, **settings: float
) -> Search:
    arcs = find_arcs(measurements, resolution=0.005, settings=ArcSettings())
    estimate = likelihood(measurements, sonar=sonar, noise=noise)
    return Search(estimate, arcs, half_aperture=HALF_APERTURE, settings=settings_with(SearchSettings, **settings))


@cache
def square() -> Search:
    """Return the search in a simulated square, with the sonar model of the rig."""
    source = open_source("sim:square")
    assert source.rig.transducer
    measurements = join_measurements([measurements_of(sweep, source.rig) for sweep in source])
    return search_in(measurements, sonar=EchoModel.of(source.rig.transducer), noise=0.008)


@cache
def found() -> tuple[Hypothesis, ...]:
    """Return the result of the search."""
    return tuple(square().run())


def rows(features: Sequence[Hypothesis], kind: Kind = Kind.WALL) -> FloatArray:
    """Return the parameters of the landmarks of one class, in order."""
    return np.array(sorted(each.reflector.tolist() for each in features if each.kind is kind)).reshape(-1, 4)


def proposed(search: Search, *reflectors: FloatArray) -> list[Hypothesis]:
    return [search.likelihood.score(each) for each in reflectors]


def test_the_walls_of_a_simulated_square_are_found() -> None:
    walls = [each for each in found() if each.is_wall]
    assert len(walls) == 4
    for truth in SQUARE:
        (own,) = [each for each in walls if np.cos(each.line[0] - truth[1]) > 0.99]
        assert own.line[1] == pytest.approx(truth[2], abs=0.01)
        assert np.sin(own.line[0] - truth[1]) == pytest.approx(0.0, abs=0.01)
        assert (own.llr_by_station > 5.0).sum() >= 3


def test_only_corners_are_found_besides_the_walls() -> None:
    others = [each for each in found() if not each.is_wall]
    vertices = np.array([[x, y] for x in (-1.0, 2.0) for y in (-0.5, 2.5)])
    assert {each.kind for each in others} <= {Kind.CORNER}
    for each in others:
        assert np.hypot(*(vertices - each.reflector[1:3]).T).min() < 0.02


def test_the_landmarks_explain_nearly_all_echoes() -> None:
    estimate = square().likelihood
    detected = np.isfinite(estimate.measurements.readings)
    log_densities = estimate.log_densities(found())
    assert (log_densities[detected] > estimate.floor + np.log(20.0)).mean() > 0.95


def test_a_search_that_starts_from_its_result_keeps_it() -> None:
    again = square().run(found())
    assert rows(again) == pytest.approx(rows(found()))
    assert len(again) == len(found())


def test_a_search_is_reproducible() -> None:
    assert [each.key for each in square().run()] == [each.key for each in found()]


def test_false_initial_landmarks_are_removed() -> None:
    wrong = proposed(square(), wall(0.4, 1.2), cylinder(0.5, 0.9, 0.1))
    assert square().tested(wrong) == []
    assert rows(square().run(wrong)) == pytest.approx(rows(found()), abs=0.002)


def test_a_duplicate_of_a_wall_is_rejected() -> None:
    walls = [each for each in found() if each.is_wall]
    doubled = [*walls, *proposed(square(), walls[0].reflector + np.array([0.0, 0.002, 0.004, 0.0]))]
    assert rows(square().tested(doubled)) == pytest.approx(rows(walls))


def test_of_two_duplicates_one_is_kept() -> None:
    walls = [each for each in found() if each.is_wall]
    for doubled in ([*walls, walls[1]], [walls[1], *walls]):
        settled = square().settled([replace(each) for each in doubled])
        assert rows(settled) == pytest.approx(rows(walls))


def test_rescoring_keeps_all_landmarks() -> None:
    walls = [each for each in found() if each.is_wall]
    rescored = square().rescored([*walls, *proposed(square(), wall(0.4, 1.2))])
    assert len(rescored) == 5
    assert min(each.llr for each in rescored[:4]) > 100.0
    assert rescored[4].llr <= 0.0


@pytest.mark.parametrize("apart", [0.0, 0.002])
def test_of_two_coinciding_walls_one_has_nearly_the_whole_ratio(apart: float) -> None:
    walls = list(found())
    twice = proposed(square(), walls[0].reflector + np.array([0.0, 0.0, apart, 0.0]))
    rescored = square().rescored([*walls, *twice])
    llr_by_station = sorted(each.llr for each in (rescored[0], rescored[-1]))
    assert llr_by_station[1] > 0.9 * walls[0].llr > 90.0
    assert llr_by_station[0] < 0.1 * walls[0].llr


def test_a_cylinder_is_found() -> None:
    truth = [*ROOM, cylinder(0.2, 0.9, 0.1)]
    measurements = pings_of(listening(), truth, noise=NOISE, rng=np.random.default_rng(1))
    features = search_in(measurements).run()
    assert rows(features, Kind.CYLINDER) == pytest.approx(np.array([truth[4]]), abs=0.005)
    assert len(rows(features)) == 4


@pytest.mark.parametrize(("reading", "count"), [(np.inf, 0), (0.3, 1)], ids=["a free view", "hidden"])
def test_a_cylinder_that_most_stations_miss_is_rejected_unless_it_was_hidden(reading: float, count: int) -> None:
    post = cylinder(0.2, 0.9, 0.1)
    around = [*STATIONS, (-0.5, 0.6), (0.0, 0.0), (0.8, 0.8)]
    measurements = pings_of(listening(around), [post])
    deaf = measurements.stations >= 3
    search = search_in(measurements._replace(readings=np.where(deaf, reading, measurements.readings)))
    (rescored,) = search.rescored(proposed(search, post))
    assert rescored.llr > 100.0
    assert len(rows(search.tested([rescored]), Kind.CYLINDER)) == count


def test_a_corner_is_found() -> None:
    # Only the vertex returns echoes, as if both walls were of foam.
    measurements = pings_of(listening(), [corner(1.6, 1.2)], noise=NOISE, rng=np.random.default_rng(1))
    features = search_in(measurements).run()
    assert [each.kind for each in features] == [Kind.CORNER]
    assert features[0].reflector[1:3] == pytest.approx([1.6, 1.2], abs=0.003)


def detected_separately(measurements: Measurements, *truth: FloatArray) -> Measurements:
    """Return measurements in which each station detects a landmark of its own only."""
    readings = np.full(len(measurements.readings), np.inf)
    for station, reflector in enumerate(truth):
        excesses, expectations = expected(measurements, reflector)
        own = (measurements.stations == station) & (excesses > 0.0) & (expectations < measurements.max_range)
        readings[own] = expectations[own]
    return measurements._replace(readings=readings)


def test_a_cylinder_that_touches_two_walls_is_replaced_by_them() -> None:
    # Each station detects a wall of its own; a thick cylinder touches both.
    ball = cylinder(0.0, 1.8, 0.4)
    stations = np.array([[-0.8, 0.1], [0.8, 0.1]])
    walls = []
    for station in stations:
        away = (ball[1:3] - station) / np.hypot(*(ball[1:3] - station))
        angle = float(np.arctan2(away[1], away[0]))
        walls.append(wall(angle, float((ball[1:3] - 0.4 * away) @ away)))
    listened = listening([(-0.8, 0.1), (0.8, 0.1)], step=np.radians(2.0))
    search = search_in(detected_separately(listened, *walls))
    features = search.run(proposed(search, ball))
    assert rows(features, Kind.CYLINDER).size == 0
    assert rows(features) == pytest.approx(np.array(sorted(walls, key=list)), abs=0.01)


@pytest.mark.parametrize(("askew", "count"), [(0.0, 1), (3.0, 2)])
def test_a_wall_through_the_sides_of_two_boxes_is_replaced_by_them(askew: float, count: int) -> None:
    # Each station detects a side of its own; both touch the same line, one of them obliquely.
    foot = np.array([-0.6, 1.2])
    angle = np.pi / 2 + np.radians(askew)
    sides = [wall(angle, float(foot @ [np.cos(angle), np.sin(angle)])), wall(np.pi / 2, 1.2)]
    search = search_in(detected_separately(listening(APART, step=np.radians(2.0)), *sides))
    found = rows(search.run(proposed(search, sides[1])))
    assert len(found) == count
    for side in sides:
        assert np.abs(found[:, 1:3] - side[1:3]).max(axis=1).min() < 0.01


def posts(*, radius: float) -> list[FloatArray]:
    """Return two posts that touch the wall y = 1.2, each straight before a station."""
    return [cylinder(x, 1.2 + radius, radius) for x in (-0.6, 0.6)]


APART = ((-0.6, 0.0), (0.6, 0.0))


def test_a_wall_detected_in_part_by_two_stations_is_rejected() -> None:
    # Thin posts are detected over a narrow angle, a wall over a wide one.
    search = search_in(detected_separately(listening(APART, step=np.radians(2.0)), *posts(radius=0.003)))
    false = proposed(search, wall(np.pi / 2, 1.2))
    assert search.tested(false) == []
    assert not rows(search.run()).size


def test_a_wall_detected_by_two_stations_is_accepted() -> None:
    truth = wall(np.pi / 2, 1.2)
    search = search_in(pings_of(listening(APART, step=np.radians(2.0)), [truth]))
    assert rows(search.run()) == pytest.approx(truth[None], abs=0.002)


@pytest.mark.parametrize(("share", "count"), [(0.4, 0), (0.05, 1)])
def test_a_wall_of_two_stations_needs_a_share_of_detections(share: float, count: int) -> None:
    # All but the middle of each arc is masked, so that it neither supports nor contradicts a wall.
    truth = wall(np.pi / 2, 1.2)
    measurements = pings_of(listening(APART, step=np.radians(2.0)), [truth])
    middle = measurements.uy > np.cos(np.radians(9.0))
    search = search_in(
        measurements._replace(readings=np.where(middle, measurements.readings, 0.3)),
        min_two_station_detection_rate=share,
    )
    assert len(search.tested(proposed(search, truth))) == count


def test_half_of_the_required_ratio_must_remain_without_the_best_station() -> None:
    acceptance = square().acceptance
    assert 2.0 * acceptance.settings.min_llr_without_best_station == acceptance.settings.min_log_likelihood_ratio
    less, more = (
        replace(found()[0], llr_by_station=np.array([30.0, 5.5, rest]), llr=35.5 + rest) for rest in (0.4, 0.6)
    )
    assert acceptance.has_single_station(less)
    assert not acceptance.has_single_station(more)


def test_pings_that_known_landmarks_mask_do_not_count_against_a_wall() -> None:
    truth = wall(np.pi / 2, 1.2)
    measurements = pings_of(listening(APART, step=np.radians(2.0)), [truth])
    middle = measurements.uy > np.cos(np.radians(9.0))
    search = search_in(
        measurements._replace(readings=np.where(middle, measurements.readings, 0.3)), min_two_station_detection_rate=0.4
    )
    (seeming,), bare = search.rescored(proposed(search, truth)), np.full(len(middle), search.likelihood.floor)
    assert not search.acceptance.is_accepted(seeming, bare)
    assert search.acceptance.is_accepted(seeming, np.where(middle, bare, 5.0))


def half_of_a_wall() -> Measurements:
    """Return the pings of one station that detects a wall to the left of its normal only."""
    measurements = pings_of(listening(APART[:1], step=np.radians(2.0)), [wall(np.pi / 2, 1.2)])
    return measurements._replace(readings=np.where(measurements.ux < 0.0, measurements.readings, np.inf))


def test_a_wall_of_one_station_must_be_detected_over_the_whole_beam() -> None:
    truth = wall(np.pi / 2, 1.2)
    whole = search_in(pings_of(listening(APART[:1], step=np.radians(2.0)), [truth]))
    half = search_in(half_of_a_wall())
    assert rows(whole.tested(proposed(whole, truth)))[:, 2] == pytest.approx([1.2])
    assert half.tested(proposed(half, truth)) == []


def test_a_cylinder_or_a_corner_of_a_single_station_is_rejected() -> None:
    truth = [cylinder(-0.6, 1.0, 0.1), corner(0.8, -0.9)]
    search = search_in(pings_of(listening(APART[:1], step=np.radians(2.0)), truth))
    assert search.tested(proposed(search, *truth)) == []


@pytest.mark.parametrize(("silent", "count"), [([], 1), ([0], 0), ([1], 0)])
def test_a_wall_of_one_station_of_a_ring_needs_three_sensors(silent: list[int], count: int) -> None:
    # Two readings always have a common tangent.
    truth = wall(np.pi / 2, 1.2)
    measurements = pings_of(listening(APART[:1], step=np.radians(22.5)), [truth])
    detected = np.flatnonzero(np.isfinite(measurements.readings))
    assert len(detected) == 3
    search = search_in(select_measurements(measurements, ~kept_of(measurements, detected[silent].tolist())))
    assert len(search.tested(proposed(search, truth))) == count


@pytest.mark.parametrize("towards", [0.5 * np.pi, np.pi])
@pytest.mark.parametrize(("sensors", "count"), [(2, 0), (3, 1)])
def test_repeated_readings_of_two_sensors_of_a_ring_count_once(sensors: int, count: int, towards: float) -> None:
    truth, ring = wall(towards, 1.2), listening(APART[:1], step=np.radians(22.5))
    sweeps = [detected_by_first(sensors, turned(ring, np.radians(degrees)), truth) for degrees in (-1.5, 0.5)]
    twice = join_measurements(sweeps)
    search = search_in(twice._replace(stations=0 * twice.stations, centers=ring.centers))
    assert len(search.tested(proposed(search, truth))) == count


def turned(measurements: Measurements, angle: float) -> Measurements:
    """Return the pings of the same sensors with rotated axes."""
    axes = np.exp(1j * angle) * (measurements.ux + 1j * measurements.uy)
    return measurements._replace(ux=axes.real.copy(), uy=axes.imag.copy())


def detected_by_first(sensors: int, ring: Measurements, truth: FloatArray) -> Measurements:
    """Return pings of a ring in which only the first few sensors detect a wall."""
    measurements = pings_of(ring, [truth])
    far = np.flatnonzero(np.isfinite(measurements.readings))[sensors:]
    return select_measurements(measurements, ~kept_of(measurements, far.tolist()))


def kept_of(measurements: Measurements, pings: Sequence[int]) -> BoolArray:
    """Return a mask of some pings."""
    return np.isin(np.arange(len(measurements.readings)), pings)


def test_a_ring_finds_a_wall_from_several_stations() -> None:
    truth = wall(np.pi / 2, 1.2)
    around = [(-0.9, 0.0), (-0.3, 0.2), (0.3, 0.1), (0.9, 0.3)]
    search = search_in(pings_of(listening(around, step=np.radians(22.5)), [truth]))
    assert rows(search.run()) == pytest.approx(truth[None], abs=0.01)


def test_three_readings_do_not_support_a_cylinder() -> None:
    stations, post = [(-0.9, 0.0), (0.0, 0.1), (0.9, 0.0)], cylinder(0.0, 1.0, 0.1)
    measurements = pings_of(listening(stations, step=np.radians(22.5)), [post])
    detected = np.flatnonzero(np.isfinite(measurements.readings))
    ahead = [detected[measurements.stations[detected] == k][0] for k in range(3)]
    search = search_in(select_measurements(measurements, np.isin(np.arange(len(measurements.readings)), ahead)))
    assert search.tested(proposed(search, post)) == []
    everywhere = search_in(measurements)
    assert rows(everywhere.tested(proposed(everywhere, post)), Kind.CYLINDER) == pytest.approx(post[None])


def test_the_step_is_that_of_the_pings() -> None:
    assert search_in(listening(step=np.radians(2.0))).acceptance.step == pytest.approx(np.radians(2.0))


def test_without_echoes_nothing_is_found() -> None:
    assert search_in(listening()).run() == []


def test_without_pings_nothing_is_found() -> None:
    measurements = listening()
    nothing = select_measurements(measurements, np.zeros(len(measurements.readings), dtype=bool))
    assert search_in(nothing).run() == []
    assert search_in(nothing).run(proposed(search_in(nothing), wall(0.0, 1.0))) == []


@pytest.mark.parametrize(("accept", "count"), [(12.0, 4), (1e6, 0)])
def test_the_settings_determine_the_acceptance(accept: float, count: int) -> None:
    measurements = pings_of(listening(), ROOM)
    assert len(search_in(measurements, min_log_likelihood_ratio=accept).run()) == count


def test_the_search_ends_if_landmarks_displace_each_other(monkeypatch: pytest.MonkeyPatch) -> None:
    search, walls, asked = square(), [each for each in found() if each.is_wall], list[int]()

    def always_the_same(contenders: Sequence[Hypothesis], *_: object) -> Hypothesis:
        asked.append(len(contenders))
        assert len(asked) < 50
        return walls[0]

    monkeypatch.setattr(search, "_best", always_the_same)
    monkeypatch.setattr(search, "tested", lambda features: features[:-1])
    assert search._grown([], [replace(each) for each in walls[1:]]) == []
    assert len(asked) > 1


def test_the_search_can_be_restricted_to_some_classes() -> None:
    search = square()
    walls = [each for each in found() if each.is_wall]
    assert rows(search.more([], (Kind.WALL,))) == pytest.approx(rows(walls), abs=0.01)
    assert rows(search.more(walls[:2], (Kind.CYLINDER,))) == pytest.approx(rows(walls[:2]), abs=0.01)
