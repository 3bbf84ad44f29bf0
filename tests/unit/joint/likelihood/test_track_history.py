"""Features that are known from stations whose pings are no longer at hand."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import Explanation
from echoplan.joint.likelihood.track_history import NO_PAST, Past
from helpers.expectations import ROOM, explanation, feature, hearing, listening, wall

EAST = wall(0.0, 2.0)


@pytest.fixture(scope="module")
def room() -> Explanation:
    return explanation(hearing(listening(), ROOM))


def beside(account: Explanation, reflector: np.ndarray, past: Past) -> Hypothesis:
    bare = np.full(len(account.soundings.readings), account.floor)
    return account.judged(replace(account.propose(reflector), past=past), bare, [])


def test_without_a_past_nothing_is_known() -> None:
    assert not feature(EAST).is_known
    assert NO_PAST.probabilities.wall == pytest.approx(1 / 3)


def test_the_past_counts_in_the_total(room: Explanation) -> None:
    alone = beside(room, EAST, NO_PAST)
    known = beside(room, EAST, Past(number=1, total=50.0, best=30.0, speaking=2, extent=(-0.5, 0.5)))
    assert known.is_known
    assert known.total == pytest.approx(alone.total + 50.0)
    assert known.best == max(alone.best, 30.0)
    assert known.speaking(5.0) == alone.speaking(5.0) + 2


def test_the_extent_takes_in_what_was_heard_before(room: Explanation) -> None:
    alone = beside(room, EAST, NO_PAST)
    known = beside(room, EAST, Past(number=1, extent=(-1.4, -1.0)))
    assert known.extent == (-1.4, alone.extent[1])


def test_a_wall_that_nobody_at_hand_hears_is_as_long_as_it_was(room: Explanation) -> None:
    behind = wall(0.0, 40.0)
    assert beside(room, behind, Past(number=1, extent=(1.0, 2.0))).extent == (1.0, 2.0)


def test_whoever_faces_the_known_part_of_a_wall_is_heard_of_it() -> None:
    # A wall is known where two stations look through it; two others, farther on, hear one on the same line.
    stations = [(0.0, -2.0), (0.0, -1.5), (0.0, 1.5), (0.0, 2.0)]
    account = explanation(hearing(listening(stations), [wall(0.0, 2.0)]))
    readings = np.where(account.soundings.stations < 2, np.inf, account.soundings.readings)
    half = explanation(account.soundings._replace(readings=readings))
    fresh = beside(half, EAST, NO_PAST)
    known = beside(half, EAST, Past(number=1, extent=(-2.1, -1.4)))
    assert (fresh.gains[:2] == 0.0).all()
    assert (known.gains[:2] < -5.0).all()
    assert known.total < fresh.total
