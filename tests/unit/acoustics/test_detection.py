import numpy as np
import pytest
from scipy.signal import lfilter

from echoplan.acoustics import (
    Air,
    burst_envelope,
    carrier_delay,
    crossing_delay,
    peak_delay,
    plane_echo,
    range_walk,
    signal_excess,
    time_constant,
    two_way_loss,
)
from echoplan.acoustics.sonar import piston_ka
from echoplan.model import Transducer

HC_SR04 = Transducer()


def walk_at(distance: float, degrees: list[float]) -> list[float]:
    """Extra range [mm] of a plane seen off the axis, against the same plane seen on it."""
    air = Air()
    on_axis = signal_excess(plane_echo(distance), 2 * distance, transducer=HC_SR04, air=air)
    excess = on_axis - two_way_loss(np.radians(degrees), piston_ka(HC_SR04, air))
    walk = range_walk(excess, reference=on_axis, transducer=HC_SR04, speed_of_sound=air.speed_of_sound)
    return [1000 * float(extra) for extra in walk]


def test_a_wall_at_1_m_reads_longer_off_the_axis_by_the_known_amounts() -> None:
    assert walk_at(1.0, [10, 15, 20, 25]) == pytest.approx([1.3, 3.5, 7.7, 17.0], abs=0.3)


def test_a_wall_at_half_a_metre_reads_longer_off_the_axis_by_the_known_amounts() -> None:
    assert walk_at(0.5, [25, 30]) == pytest.approx([9.6, 24.0], abs=0.6)


def test_the_envelope_is_that_of_two_resonators() -> None:
    # In the rotating frame of the carrier each resonator is a low pass of the same time constant.
    step = 1e-7
    tau = time_constant(HC_SR04)
    times = np.arange(0.0, 1.2e-3, step)
    burst = (times < HC_SR04.burst_cycles / HC_SR04.frequency).astype(float)
    once = lfilter([step / tau], [1, step / tau - 1], burst)
    twice = lfilter([step / tau], [1, step / tau - 1], once)
    np.testing.assert_allclose(burst_envelope(times, HC_SR04), twice / twice.max(), atol=2e-3)


def test_the_envelope_is_greatest_at_its_peak_and_one_there() -> None:
    peak = peak_delay(HC_SR04)
    assert burst_envelope(peak, HC_SR04) == pytest.approx(1.0)
    around = burst_envelope(peak + np.array([-1e-6, 1e-6]), HC_SR04)
    assert (around < 1.0).all()


def test_the_crossing_is_where_the_envelope_reaches_the_threshold() -> None:
    excess = np.linspace(0.0, 70.0, 141)
    height = burst_envelope(crossing_delay(excess, HC_SR04), HC_SR04) * 10 ** (excess / 20)
    np.testing.assert_allclose(height, 1.0, rtol=1e-6)


def test_what_stays_below_the_threshold_never_crosses_it() -> None:
    assert crossing_delay([-0.001, -np.inf], HC_SR04).tolist() == [np.inf, np.inf]
    assert carrier_delay([-0.001, -np.inf], HC_SR04).tolist() == [np.inf, np.inf]


@pytest.mark.parametrize("excess", [1.0, 7.3, 18.0, 33.0])
def test_the_carrier_trips_on_the_first_crest_that_is_high_enough(excess: float) -> None:
    times = np.arange(0.0, 4e-4, 2e-8)
    signal = 10 ** (excess / 20) * burst_envelope(times, HC_SR04) * np.cos(2 * np.pi * HC_SR04.frequency * times)
    first = times[np.argmax(signal >= 1)]
    # The closed form takes the envelope at the crest, which it has not quite reached when the carrier trips.
    assert carrier_delay(excess, HC_SR04) == pytest.approx(first, abs=1.2e-6)


def test_with_the_carrier_ranges_jump_by_whole_periods() -> None:
    delays = carrier_delay(np.linspace(5.0, 40.0, 20_001), HC_SR04)
    jumps = -np.diff(delays)
    period = 1 / HC_SR04.frequency
    leaps = jumps[jumps > 0.2 * period]
    assert len(leaps) >= 3
    # A leap begins where the old crest just fails, a quarter of a period at most after the new one is crossed.
    assert ((leaps > 0.7 * period) & (leaps < period)).all()
    assert 0.5 * 343.0 * period == pytest.approx(0.00429, abs=1e-5)


def test_a_sluggish_transducer_walks_farther() -> None:
    slow = Transducer(quality_factor=40.0)
    fast = Transducer(quality_factor=10.0)
    walks = [
        float(range_walk(6.0, reference=20.0, transducer=transducer, speed_of_sound=343.0))
        for transducer in (fast, HC_SR04, slow)
    ]
    assert walks[0] < walks[1] < walks[2]
