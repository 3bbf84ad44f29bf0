import numpy as np
import pytest
from numpy.typing import ArrayLike

from echoplan.acoustics import burst_envelope, carrier_delay, crossing_delay, peak_delay
from echoplan.arrays import FloatArray
from echoplan.model import Transducer
from echoplan.simulation import SimulationSettings
from echoplan.simulation.detector import Echoes, build_detector
from echoplan.simulation.threshold import first_crossings
from helpers import simulated_worlds, twin

HC_SR04 = Transducer()
TWO_PI_F = 2 * np.pi * HC_SR04.frequency


def crossing(
    times: ArrayLike,
    strengths: ArrayLike,
    *,
    begin: float = 0.0,
    end: float = 0.02,
    settings: SimulationSettings | None = None,
) -> float:
    """When one ping's threshold is first reached; each echo's carrier begins with it."""
    arrivals = np.array(times, dtype=np.float64)
    pressures = np.array(strengths, dtype=np.complex128) * np.exp(-1j * TWO_PI_F * arrivals)
    bounds = np.array([0, len(arrivals)])
    echoes = Echoes(arrivals, pressures, np.zeros(len(arrivals), dtype=np.int64), bounds)
    detector = build_detector(HC_SR04, settings or SimulationSettings())
    return float(first_crossings(detector, echoes, np.array([begin]), np.array([end]))[0])


@pytest.mark.parametrize("excess", [0.01, 1.0, 6.0, 20.0, 40.0])
def test_one_echo_crosses_when_the_closed_form_says(excess: float) -> None:
    expected = 0.005 + float(crossing_delay(excess, HC_SR04))
    assert crossing([0.005], [10 ** (excess / 20)]) == pytest.approx(expected, abs=1e-10)


@pytest.mark.parametrize("excess", [1.0, 7.3, 18.0, 33.0])
def test_one_carrier_trips_when_the_closed_form_says(excess: float) -> None:
    # Both take the crest's height for the whole crest.
    carrier = SimulationSettings(detector="carrier")
    found = crossing([0.005], [10 ** (excess / 20)], settings=carrier)
    assert found == pytest.approx(0.005 + float(carrier_delay(excess, HC_SR04)), abs=1e-9)


def test_an_echo_below_the_threshold_is_not_detected() -> None:
    assert crossing([0.005], [0.999]) == np.inf
    assert crossing([], []) == np.inf


@pytest.mark.parametrize("detector", ["envelope", "carrier"])
@pytest.mark.parametrize("seed", range(8))
def test_many_echoes_cross_when_a_slow_reference_says(detector: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    times = np.sort(rng.uniform(0.001, 0.004, 6))
    strengths = rng.uniform(0.2, 1.1, 6) * np.exp(2j * np.pi * rng.random(6))
    settings = SimulationSettings.model_validate({"detector": detector})
    found = crossing(times, strengths, end=0.006, settings=settings)
    carried = strengths * np.exp(-1j * TWO_PI_F * times)
    patient = twin.first_crossing(times, carried, HC_SR04, begin=0.0, end=0.006, carrier=detector == "carrier")
    assert found == pytest.approx(patient, abs=2e-7 if detector == "envelope" else 1.2e-6)


def test_two_faint_echoes_are_detected_together_and_two_opposite_ones_are_not() -> None:
    apart = 0.5 / HC_SR04.frequency
    assert crossing([0.005], [0.7]) == np.inf
    assert crossing([0.005, 0.005 + 2 * apart], [0.7, 0.7]) < 0.0052
    assert crossing([0.005, 0.005 + apart], [1.3, 1.3]) == np.inf


def test_powers_add_whatever_the_phase() -> None:
    apart = 0.5 / HC_SR04.frequency
    incoherent = SimulationSettings(superposition="incoherent")
    together = [crossing([0.005, 0.005 + apart], [each, 0.8], settings=incoherent) for each in (0.8, -0.8)]
    assert together[0] == together[1] < np.inf
    assert crossing([0.005, 0.005 + apart], [0.6, 0.6], settings=incoherent) == np.inf


def test_an_echo_that_is_loud_when_listening_begins_is_too_close() -> None:
    assert crossing([0.0002], [30.0], begin=0.0006) == -np.inf


def test_an_echo_that_has_died_when_listening_begins_is_missed() -> None:
    assert crossing([0.0002], [30.0], begin=0.006) == np.inf
    later = crossing([0.0002, 0.008], [30.0, 30.0], begin=0.006)
    assert later == pytest.approx(0.008 + float(crossing_delay(20 * np.log10(30.0), HC_SR04)), abs=1e-8)


def test_an_echo_that_still_rises_when_listening_begins_is_read() -> None:
    late = crossing([0.005], [1.05], begin=0.0051)
    assert late == pytest.approx(0.005 + float(crossing_delay(20 * np.log10(1.05), HC_SR04)), abs=1e-10)


def test_nothing_is_detected_after_the_deadline() -> None:
    assert crossing([0.005], [10.0], end=0.00502) == np.inf
    assert crossing([0.005], [1.0001], end=0.005 + peak_delay(HC_SR04) / 2) == np.inf


def test_every_ping_receives_its_own_echoes() -> None:
    times, bounds = np.array([0.002, 0.001, 0.003]), np.array([0, 1, 1, 3])
    echoes = Echoes(times, np.array([5.0, 0.1, 5.0], dtype=complex), np.zeros(3, dtype=np.int64), bounds)
    detector = build_detector(HC_SR04, SimulationSettings())
    found = first_crossings(detector, echoes, np.zeros(3), np.full(3, 0.01))
    assert found == pytest.approx([0.002 + (found[0] - 0.002), np.inf, 0.001 + found[0]], abs=1e-6)
    assert 0.002 < found[0] < 0.0022


def test_the_detectors_envelope_is_that_of_acoustics() -> None:
    detector = build_detector(simulated_worlds.PAPER, SimulationSettings())
    since = np.linspace(1e-6, 2e-3, 50)
    assert detector.peak_delay == peak_delay(simulated_worlds.PAPER)
    np.testing.assert_allclose(
        envelope(since, detector.tau, detector.burst) / detector.peak, burst_envelope(since, simulated_worlds.PAPER)
    )


def envelope(since: FloatArray, tau: float, burst: float) -> FloatArray:
    def step(x: FloatArray) -> FloatArray:
        held: FloatArray = np.maximum(x, 0.0)
        response: FloatArray = 1 - (1 + held) * np.exp(-held)
        return response

    return step(since / tau) - step(since / tau - burst)
