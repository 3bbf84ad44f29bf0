import numpy as np
import pytest

from echoplan.model import Transducer
from echoplan.simulation import SimulationSettings
from echoplan.simulation.detector import build_detector


def test_the_detector_takes_its_numbers_from_the_transducer() -> None:
    detector = build_detector(
        Transducer(frequency=50_000.0, quality_factor=10.0, burst_cycles=5.0), SimulationSettings()
    )
    assert detector.tau == pytest.approx(10.0 / (np.pi * 50_000.0))
    assert detector.burst * detector.tau == pytest.approx(5.0 / 50_000.0)
    assert detector.omega == pytest.approx(2 * np.pi * 50_000.0)
    assert 0 < detector.peak < 1


def test_the_settings_say_how_echoes_add_and_what_trips() -> None:
    plain = build_detector(Transducer(), SimulationSettings())
    other = build_detector(Transducer(), SimulationSettings(superposition="incoherent", detector="carrier"))
    assert (plain.coherent, plain.carrier) == (True, False)
    assert (other.coherent, other.carrier) == (False, True)
