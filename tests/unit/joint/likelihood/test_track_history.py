"""Landmarks with a track history of marginalised stations."""

from dataclasses import replace

import numpy as np
import pytest

from echoplan.joint.likelihood.hypothesis import Hypothesis
from echoplan.joint.likelihood.ping_likelihood import PingLikelihood
from echoplan.joint.likelihood.track_history import NO_HISTORY, TrackHistory
from helpers.expectations import ROOM, feature, likelihood, listening, pings_of, wall

EAST = wall(0.0, 2.0)


@pytest.fixture(scope="module")
def room() -> PingLikelihood:
    return likelihood(pings_of(listening(), ROOM))


def scored_with_history(estimate: PingLikelihood, reflector: np.ndarray, history: TrackHistory) -> Hypothesis:
    bare = np.full(len(estimate.measurements.readings), estimate.floor)
    return estimate.rescored(replace(estimate.score(reflector), history=history), bare, [])


def test_a_landmark_without_history_is_new() -> None:
    assert not feature(EAST).is_known
    assert NO_HISTORY.probabilities.wall == pytest.approx(1 / 3)


def test_the_ratio_includes_the_track_history(room: PingLikelihood) -> None:
    alone = scored_with_history(room, EAST, NO_HISTORY)
    known = scored_with_history(
        room, EAST, TrackHistory(number=1, llr=50.0, best_llr=30.0, supporting=2, extent=(-0.5, 0.5))
    )
    assert known.is_known
    assert known.llr == pytest.approx(alone.llr + 50.0)
    assert known.best_llr == max(alone.best_llr, 30.0)
    assert known.supporting(5.0) == alone.supporting(5.0) + 2


def test_the_extent_includes_the_track_history(room: PingLikelihood) -> None:
    alone = scored_with_history(room, EAST, NO_HISTORY)
    known = scored_with_history(room, EAST, TrackHistory(number=1, extent=(-1.4, -1.0)))
    assert known.extent == (-1.4, alone.extent[1])


def test_a_wall_out_of_range_keeps_its_extent(room: PingLikelihood) -> None:
    behind = wall(0.0, 40.0)
    assert scored_with_history(room, behind, TrackHistory(number=1, extent=(1.0, 2.0))).extent == (1.0, 2.0)


def test_stations_before_the_known_extent_of_a_wall_count() -> None:
    # Two stations do not detect the known part of a wall; two others detect a wall on the same line.
    stations = [(0.0, -2.0), (0.0, -1.5), (0.0, 1.5), (0.0, 2.0)]
    estimate = likelihood(pings_of(listening(stations), [wall(0.0, 2.0)]))
    readings = np.where(estimate.measurements.stations < 2, np.inf, estimate.measurements.readings)
    half = likelihood(estimate.measurements._replace(readings=readings))
    fresh = scored_with_history(half, EAST, NO_HISTORY)
    known = scored_with_history(half, EAST, TrackHistory(number=1, extent=(-2.1, -1.4)))
    assert (fresh.llr_by_station[:2] == 0.0).all()
    assert (known.llr_by_station[:2] < -5.0).all()
    assert known.llr < fresh.llr
