"""Readings are stretched as follows from the air and the modules."""

from dataclasses import replace
from math import isnan, nan

import pytest

from echoplan.acoustics import speed_of_sound
from echoplan.preprocessing import expected_scale
from helpers import simulated_worlds

RIG = simulated_worlds.rig()


def test_without_thermometer_and_stated_speed_readings_are_taken_to_be_right() -> None:
    assert expected_scale(RIG, nan) == 0.0
    assert expected_scale(RIG, 20.0) == 0.0


@pytest.mark.parametrize(("speed", "temperature"), [(340.0, nan), (343.0, 31.0), (350.0, 5.0)])
def test_the_scale_is_the_true_speed_over_the_one_that_is_assumed(speed: float, temperature: float) -> None:
    true = float(speed_of_sound(20.0 if isnan(temperature) else temperature))
    scale = expected_scale(replace(RIG, speed_of_sound=speed), temperature)
    # 1 m at the assumed speed is as far as sound really went in that time.
    assert 1.0 + scale == pytest.approx(true / speed)
