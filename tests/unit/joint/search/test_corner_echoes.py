import numpy as np
import pytest

from echoplan.joint.search.corner_echoes import CornerEcho, Echoes, corner_echoes, returns_sound
from helpers.expectations import ROOM, corner, cylinder, likelihood, listening, pings_of, rescored

STEP = np.radians(3.0)
ALL = 4
LANDMARKS = [*ROOM, corner(2.0, 1.5)]


def test_the_order_of_a_pair_of_walls_does_not_matter() -> None:
    echoes = Echoes(pairs={(1, 3): CornerEcho(pings=7)})
    assert echoes.between(1, 3) == echoes.between(3, 1) == CornerEcho(pings=7)
    assert echoes.between(1, 2) == CornerEcho()


def test_a_corner_is_detected_only_near_its_position() -> None:
    echoes = Echoes(corners_xy=np.array([[1.0, 1.0], [2.0, 0.0]]))
    assert echoes.is_detected_at(np.array([1.0, 1.02]), within=0.03)
    assert not echoes.is_detected_at(np.array([1.0, 1.04]), within=0.03)
    assert not Echoes().is_detected_at(np.array([0.0, 0.0]), within=9.0)


@pytest.mark.parametrize(("turn", "square"), [(90.0, True), (-90.9, True), (91.1, False), (88.9, False), (0.0, False)])
def test_only_a_right_angled_corner_returns_sound_to_its_source(turn: float, *, square: bool) -> None:
    assert returns_sound(np.array([0.3, 1.0]), np.array([0.3 + np.radians(turn), 2.0])) == square


def test_corner_echoes_are_counted_for_the_walls_that_make_the_corner() -> None:
    estimate = likelihood(pings_of(listening(step=STEP), LANDMARKS))
    known = rescored(estimate, LANDMARKS)
    detected = corner_echoes(estimate, known, ALL)
    assert detected[0, 1].pings > 10
    assert detected[0, 1].stations == ALL
    assert detected[0, 3].pings == detected[1, 2].pings == detected[2, 3].pings == 0
    assert Echoes.of(known, detected).corners_xy.tolist() == [[2.0, 1.5]]


def test_an_undetected_corner_is_missed() -> None:
    estimate = likelihood(pings_of(listening(step=STEP), LANDMARKS))
    detected = corner_echoes(estimate, rescored(estimate, ROOM), ALL)
    assert detected[0, 1].gain > 0.0
    assert max(detected[pair].gain for pair in ((0, 3), (1, 2), (2, 3))) < -20.0
    # Opposite walls have no corner.
    assert detected[0, 2].gain == detected[1, 3].gain == 0.0


def test_a_corner_out_of_range_is_not_missed() -> None:
    far = listening([(-1.4, -0.8)], step=STEP)
    estimate = likelihood(pings_of(far, ROOM))
    detected = corner_echoes(estimate, rescored(estimate, ROOM), 1)
    assert detected[0, 1].gain == 0.0
    assert detected[2, 3].gain < -3.0


def test_only_the_first_stations_count() -> None:
    estimate = likelihood(pings_of(listening(step=STEP), LANDMARKS))
    known = rescored(estimate, LANDMARKS)
    none, some, all_of_them = (corner_echoes(estimate, known, count) for count in (0, 2, ALL))
    assert set(none.values()) == {CornerEcho()}
    assert 0 < some[0, 1].pings < all_of_them[0, 1].pings
    assert (some[0, 1].stations, all_of_them[0, 1].stations) == (2, ALL)
    assert all_of_them[2, 3].gain < some[2, 3].gain < 0.0


def test_corner_echoes_add_up() -> None:
    some, more = CornerEcho(pings=3, stations=1, gain=-1.0), CornerEcho(pings=4, stations=2, detections=8.0, gain=5.0)
    assert some.joined(more) == CornerEcho(pings=7, stations=3, detections=8.0, gain=4.0)


def test_an_echo_that_a_cylinder_explains_is_not_of_a_corner() -> None:
    # From one station a column, whose weaker echo reads a little long, is like the corner.
    away = np.array([1.5, 1.2]) / np.hypot(1.5, 1.2)
    x, y = np.array([2.0, 1.5]) + 0.39 * away
    estimate = likelihood(pings_of(listening([(0.5, 0.3)], step=STEP), [*ROOM, cylinder(x, y, 0.4)]))
    plain, hidden = (corner_echoes(estimate, rescored(estimate, k), 1) for k in (ROOM, [*ROOM, cylinder(x, y, 0.4)]))
    assert plain[0, 1].pings > 1
    assert hidden[0, 1].pings == 0


def test_an_echo_is_associated_with_the_best_corner() -> None:
    estimate = likelihood(pings_of(listening(step=STEP), LANDMARKS))
    beside = [*ROOM, ROOM[0] + np.array([0.0, 0.0, 0.004, 0.0])]
    detected = corner_echoes(estimate, rescored(estimate, beside), ALL)
    assert detected[0, 1].pings > 10
    assert detected[1, 4].pings < 0.2 * detected[0, 1].pings
