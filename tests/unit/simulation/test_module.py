from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from echoplan.acoustics import Air, crossing_delay, plane_echo, signal_excess
from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.model import Transducer
from echoplan.simulation import SimulationSettings
from echoplan.simulation.module import Module, build_module
from helpers import simulated_worlds

RIG = simulated_worlds.rig(
    simulated_worlds.sensor(0, resolution=0.005, max_range=3.0),
    simulated_worlds.sensor(1, min_range=0.2, max_range=4.0),
)


def module(**settings: Any) -> Module:
    return build_module(RIG, Transducer(), SimulationSettings(**({"jitter": 0.0} | settings)))


def read(ranges: list[float], *, sensor: int = 0, seed: int = 0, **settings: Any) -> FloatArray:
    """What the module reads of thresholds reached at these true ranges."""
    made = module(**settings)
    instants = 2 * np.array(ranges) / made.speed_of_sound + made.zero_delay
    return made.readings(instants, np.full(len(ranges), sensor), np.random.default_rng(seed))


def test_readings_come_in_steps_of_the_resolution() -> None:
    assert read([1.0, 1.0024, 1.0026, 2.999]) == pytest.approx([1.0, 1.0, 1.005, 3.0])
    assert read([1.2345], sensor=1) == pytest.approx([1.2345])


def test_the_reading_is_infinite_without_an_echo_and_beyond_reach() -> None:
    assert read([np.inf, 3.004]).tolist() == [np.inf, np.inf]


def test_too_close_stays_too_close() -> None:
    made = module()
    assert made.readings(np.array([-np.inf]), np.array([0]), np.random.default_rng(0)).tolist() == [-np.inf]
    assert read([0.0301, 0.031]).tolist() == pytest.approx([0.03, 0.03])


def test_noise_never_makes_a_reading_shorter_than_the_dead_distance() -> None:
    noisy = read([0.031] * 1000, jitter=0.01)
    assert noisy.min() == pytest.approx(0.03)


def test_the_zero_is_right_for_an_aimed_plane_at_1_m() -> None:
    excess = signal_excess(plane_echo(1.0), 2.0, transducer=Transducer(), air=Air())
    assert module().zero_delay == pytest.approx(float(crossing_delay(excess, Transducer())))
    assert module(zero_distance=2.0).zero_delay > module().zero_delay


def test_a_module_that_was_not_set_right_reads_too_far_by_the_same_everywhere() -> None:
    right, misset = module(), module(zero_error=0.02)
    instants = 2 * np.array([0.5, 1.0, 2.0]) / right.speed_of_sound + right.zero_delay
    far, near = (made.readings(instants, np.ones(3, int), np.random.default_rng(0)) for made in (misset, right))
    assert far - near == pytest.approx([0.02] * 3)


def test_a_zero_distance_out_of_reach_is_refused() -> None:
    with pytest.raises(InvalidValueError, match=r"zero_distance must be within reach, but a plane at 9 m .* dB below"):
        module(zero_distance=9.0)


def test_time_becomes_range_with_the_assumed_temperature() -> None:
    assert module(assumed_temperature=31.0).speed_of_sound == pytest.approx(350.97, abs=0.05)
    assert module(air=Air(temperature=31.0)).speed_of_sound == pytest.approx(343.99, abs=0.01)


def test_the_speed_of_sound_of_the_rig_is_used() -> None:
    rig = replace(RIG, speed_of_sound=340.0)
    assert build_module(rig, Transducer(), SimulationSettings(assumed_temperature=31.0)).speed_of_sound == 340.0


def test_it_listens_from_the_dead_distance_to_half_a_step_beyond_its_reach() -> None:
    made, sensors = module(), np.array([0, 1])
    to_range = 0.5 * made.speed_of_sound
    np.testing.assert_allclose(to_range * (made.openings(sensors) - made.zero_delay), [0.03, 0.2])
    np.testing.assert_allclose(to_range * (made.deadlines(sensors) - made.zero_delay), [3.0025, 4.0])


def test_jitter_has_the_deviation_that_was_asked_for() -> None:
    noisy = read([1.0] * 4000, sensor=1, jitter=0.004)
    assert noisy.std() == pytest.approx(0.004, rel=0.05)
    assert noisy.mean() == pytest.approx(1.0, abs=3e-4)


def test_dropouts_lose_as_many_readings_as_was_asked_for() -> None:
    made = read([1.0] * 4000, dropout=0.08)
    assert np.isinf(made).mean() == pytest.approx(0.08, abs=0.013)


def test_strays_are_anywhere_in_reach_but_read_only_before_the_true_echo() -> None:
    found = read([1.0] * 20_000, sensor=1, stray=0.3)
    strays = found[np.abs(found - 1.0) > 1e-9]
    # Of 3.8 m of reach 0.8 m lie before the echo.
    assert len(strays) / len(found) == pytest.approx(0.3 * 0.8 / 3.8, abs=0.006)
    assert strays.max() < 1.0
    assert strays.mean() == pytest.approx(0.6, abs=0.02)


def test_where_nothing_is_detected_every_stray_is_read() -> None:
    found = read([np.inf] * 4000, sensor=1, stray=0.25)
    assert np.isfinite(found).mean() == pytest.approx(0.25, abs=0.02)


def test_dropouts_do_not_change_the_jitter_of_other_readings() -> None:
    quiet, troubled = read([1.0] * 50, jitter=0.002), read([1.0] * 50, jitter=0.002, dropout=0.5)
    kept = np.isfinite(troubled)
    assert 10 < kept.sum() < 40
    np.testing.assert_array_equal(quiet[kept], troubled[kept])
