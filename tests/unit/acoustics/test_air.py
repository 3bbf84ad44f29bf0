import numpy as np
import pytest
from pydantic import ValidationError

from echoplan.acoustics import Air, absorption, speed_of_sound


@pytest.mark.parametrize(
    ("temperature", "humidity", "speed"),
    [(20.0, 0.0, 343.36), (20.0, 0.5, 343.99), (20.0, 1.0, 344.61), (0.0, 0.0, 331.45), (30.0, 0.5, 350.31)],
)
def test_the_speed_of_sound_is_that_of_cramers_polynomial(temperature: float, humidity: float, speed: float) -> None:
    assert speed_of_sound(temperature, relative_humidity=humidity) == pytest.approx(speed, abs=0.006)


def test_the_speed_of_sound_rises_by_a_sixth_of_a_per_cent_a_degree() -> None:
    slope = np.diff(speed_of_sound([19.5, 20.5])) / speed_of_sound(20.0)
    assert slope[0] == pytest.approx(0.0018, abs=1e-4)


def test_humidity_changes_the_speed_by_less_than_half_a_per_cent() -> None:
    warm = speed_of_sound([10.0, 20.0, 30.0], relative_humidity=[[0.0], [1.0]])
    gain = warm[1] / warm[0] - 1
    assert (gain > 0.001).all()
    assert (gain < 0.008).all()
    assert (np.diff(gain) > 0).all()


def test_pressure_hardly_changes_the_speed_of_sound() -> None:
    assert speed_of_sound(20.0, pressure=80_000.0) == pytest.approx(speed_of_sound(20.0), rel=5e-4)


@pytest.mark.parametrize(
    ("temperature", "losses"), [(10.0, (0.43, 0.85, 1.09)), (20.0, (0.78, 1.32, 1.23)), (30.0, (1.37, 1.34, 1.02))]
)
def test_absorption_at_40_khz_is_that_of_iso_9613(temperature: float, losses: tuple[float, ...]) -> None:
    found = absorption(40_000.0, temperature=temperature, relative_humidity=[0.2, 0.5, 0.8])
    np.testing.assert_allclose(found, losses, atol=0.005)


def test_absorption_rises_with_the_frequency_as_in_iso_9613() -> None:
    np.testing.assert_allclose(absorption([25_000.0, 49_400.0, 58_000.0]), [0.73, 1.64, 1.92], atol=0.005)


def test_thin_air_absorbs_by_its_classical_part_at_least() -> None:
    dry = absorption(40_000.0, relative_humidity=0.0, pressure=[50_000.0, 100_000.0])
    assert dry[0] > dry[1] > 8.686 * 40_000.0**2 * 1.84e-11


def test_air_knows_its_own_speed_and_absorption() -> None:
    air = Air(temperature=16.7, relative_humidity=0.32)
    assert air.speed_of_sound == speed_of_sound(16.7, relative_humidity=0.32)
    assert air.absorption(40_000.0) == pytest.approx(0.924, abs=1e-3)


@pytest.mark.parametrize(
    "wrong", [{"relative_humidity": 50.0}, {"temperature": 293.15}, {"pressure": 1.0}, {"wind": 3.0}]
)
def test_air_in_other_units_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(ValidationError):
        Air(**wrong)
