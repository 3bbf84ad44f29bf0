import numpy as np
import pytest

from echoplan.acoustics import Air, directivity, fresnel_tail, plane_echo, signal_excess
from echoplan.model import Transducer
from echoplan.simulation import SimulationSettings
from echoplan.simulation.sonar import build_sonar

SONAR = build_sonar(Transducer(), SimulationSettings())


def test_gain_and_damping_are_the_sonar_equation() -> None:
    length = 3.0
    level = 20 * np.log10(SONAR.gain * np.exp(-SONAR.damping * length) * plane_echo(length / 2))
    assert level == pytest.approx(signal_excess(plane_echo(length / 2), length, transducer=Transducer(), air=Air()))


def test_between_its_nodes_the_beams_table_is_good_to_a_millionth() -> None:
    sines = np.random.default_rng(0).random(1000)
    nodes = np.linspace(0.0, 1.0, len(SONAR.beam))
    ka = SONAR.wavenumber * Transducer().piston_radius
    np.testing.assert_allclose(np.interp(sines, nodes, SONAR.beam), directivity(np.arcsin(sines), ka), atol=1e-6)


def test_between_its_nodes_the_tails_table_is_good_to_a_millionth() -> None:
    shares = np.random.default_rng(0).random(1000)
    nodes = np.linspace(0.0, 1.0, len(SONAR.tail))
    exact = fresnel_tail(shares / (1 - shares))
    np.testing.assert_allclose(np.interp(shares, nodes, SONAR.tail), exact, atol=1e-6)


def test_the_settings_decide_what_is_traced() -> None:
    settings = SimulationSettings(reflection_order=1, diffraction=False, crosstalk=False)
    sonar = build_sonar(Transducer(), settings)
    assert (sonar.order, sonar.diffraction, sonar.crosstalk) == (1, False, False)
    assert (SONAR.order, SONAR.diffraction, SONAR.crosstalk) == (2, True, True)


def test_cold_air_carries_sound_slower() -> None:
    cold = build_sonar(Transducer(), SimulationSettings(air=Air(temperature=0.0)))
    assert cold.speed < SONAR.speed
    assert cold.wavenumber > SONAR.wavenumber


def test_moist_air_swallows_more_and_thin_air_carries_sound_at_nearly_the_same_speed() -> None:
    moist = build_sonar(Transducer(), SimulationSettings(air=Air(relative_humidity=0.6)))
    dry = build_sonar(Transducer(), SimulationSettings(air=Air(relative_humidity=0.2)))
    assert moist.damping > 1.5 * dry.damping
    assert moist.speed > dry.speed
    thin = build_sonar(Transducer(), SimulationSettings(air=Air(pressure=80_000.0)))
    assert thin.damping != pytest.approx(SONAR.damping, rel=0.02)
    assert thin.speed == pytest.approx(SONAR.speed, rel=1e-3)
