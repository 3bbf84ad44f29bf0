"""Stations that do not fit the others are named."""

import math
from dataclasses import replace

import numpy as np
import pytest

from echoplan.diagnosis import misplaced_stations
from echoplan.model import Sweep
from helpers.mistaken import RIG, many_sweeps, sound_sweeps

pytestmark = pytest.mark.slow


def moved(sweep: Sweep, x: float, turn: float) -> Sweep:
    return replace(sweep, map_from_base=sweep.map_from_base + np.array([x, 0.0, turn]))


def test_a_station_with_a_wrong_heading_is_named_with_the_turn_that_it_lacks() -> None:
    sweeps = list(sound_sweeps())
    sweeps[3] = moved(sweeps[3], 0.0, math.radians(15.0))
    worst = misplaced_stations(sweeps, RIG)[0]
    assert worst.sweep == 3
    assert math.degrees(worst.turn) == pytest.approx(-15.0, abs=3.0)


def test_a_station_at_a_wrong_place_is_named() -> None:
    sweeps = list(sound_sweeps())
    sweeps[1] = moved(sweeps[1], 0.2, 0.0)
    worst = misplaced_stations(sweeps, RIG)[0]
    assert worst.sweep == 1
    assert worst.distance == pytest.approx(0.2, abs=0.03)


def test_a_station_late_in_a_long_recording_is_named() -> None:
    sweeps = list(many_sweeps())
    sweeps[33] = moved(sweeps[33], 0.0, math.radians(15.0))
    assert [each.sweep for each in misplaced_stations(sweeps, RIG)] == [33]


def test_where_the_origin_is_does_not_matter() -> None:
    far = np.array([612_345.0, 5_432_101.5, 0.0])
    sweeps = [replace(sweep, map_from_base=sweep.map_from_base + far) for sweep in sound_sweeps()]
    assert misplaced_stations(sweeps, RIG) == ()


def test_stations_that_agree_are_left_alone() -> None:
    assert misplaced_stations(sound_sweeps(), RIG) == ()


def test_without_sweeps_no_station_is_apart() -> None:
    assert misplaced_stations((), RIG) == ()
    assert misplaced_stations([sweep[:0] for sweep in sound_sweeps()], RIG) == ()


def test_without_an_echo_no_station_is_apart() -> None:
    silent = [replace(sweep, ranges=np.full(len(sweep), np.inf)) for sweep in sound_sweeps()]
    assert misplaced_stations(silent, RIG) == ()
