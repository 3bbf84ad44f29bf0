"""Consistency: the sensor whose echoes do not fit those of the others."""

from dataclasses import replace

import numpy as np
import pytest

import echoplan
from echoplan.diagnosis.consistency import CONSISTENT, Consistency

pytestmark = pytest.mark.slow


def of_sensors(*counts: tuple[int, int]) -> Consistency:
    """Explained and grouped independent echoes, sensor by sensor."""
    both = np.array(counts)
    return Consistency(both[:, 0], both[:, 1], 0.0, both.astype(np.float64))


@pytest.mark.parametrize("strange", [(0, 16), (3, 40), (0, 100)])
def test_a_sensor_of_which_far_fewer_echoes_are_explained_is_odd(strange: tuple[int, int]) -> None:
    found = of_sensors(*[(14, 16)] * 9, strange)
    assert found.has_odd_sensor
    assert found.strangest == 9


@pytest.mark.parametrize("ordinary", [(14, 16), (5, 8), (10, 20), (0, 4), (0, 0), (16, 16)])
def test_chance_makes_no_sensor_odd(ordinary: tuple[int, int]) -> None:
    assert not of_sensors(*[(14, 16)] * 9, ordinary).has_odd_sensor


def test_nothing_detected_and_a_single_sensor_are_not_odd() -> None:
    assert not of_sensors((0, 0), (0, 0)).has_odd_sensor
    assert not of_sensors((1, 20)).has_odd_sensor


def test_one_backward_sensor_of_a_ring_is_named_although_most_echoes_fit() -> None:
    recording = echoplan.simulate("two-room-flat", rig="ring-16", seed=3)
    sensors = list(recording.rig.sensors)
    sensors[5] = replace(sensors[5], yaw=sensors[5].yaw + np.pi)
    rig = replace(recording.rig, sensors=tuple(sensors))
    wrong = echoplan.Recording(name="backward", rig=rig, sweeps=tuple(recording))
    quality = echoplan.map(wrong).quality
    assert quality is not None
    assert quality.verdict is not echoplan.Verdict.GOOD
    assert "Sensor 5 seems to look the other way" in quality.reasons[0]


def test_one_sensor_is_taken_from_the_others() -> None:
    silent = of_sensors((14, 16), (0, 3), (7, 16)).of_sensor(1)
    assert (silent.share, silent.weight, len(silent.weights)) == (0.0, 0.0, 1)


def test_nothing_is_strange_about_sensors_that_fit() -> None:
    assert not CONSISTENT.has_odd_sensor
    assert not CONSISTENT.has_unexplained_sensor
    assert of_sensors((14, 16), (2, 14)).has_unexplained_sensor
