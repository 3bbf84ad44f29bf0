import math
from typing import Any

import pytest
from pydantic import ValidationError

from echoplan.simulation import OdometryNoise, SimulationSettings


@pytest.mark.parametrize(
    "wrong",
    [
        {"reflection_order": 3},
        {"dropout": 1.5},
        {"jitter": -0.001},
        {"detector": "peak"},
        {"superposition": "both"},
        {"zero_distance": 0.0},
        {"servo_gain": 0.0},
        {"servo_gain": 11.0},
        {"servo_gain": math.inf},
        {"servo_gain": math.nan},
        {"servo_offset": 3.2},
        {"servo_offset": -math.inf},
        {"servo_offset": math.nan},
        {"odometry": {"sideways": 0.1}},
        {"air": {"humidity": 0.5}},
        {"temprature": 20.0},
    ],
    ids=str,
)
def test_invalid_values_and_misspelt_keys_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        SimulationSettings(**wrong)


def test_settings_come_from_plain_tables() -> None:
    settings = SimulationSettings.model_validate({"air": {"temperature": 31.0}, "odometry": {"along": 0.02}})
    assert settings.air.temperature == 31.0
    assert settings.odometry == OdometryNoise(along=0.02)
    assert SimulationSettings(**settings.model_dump()) == settings


def test_by_default_all_physics_is_on_and_all_mishaps_are_off() -> None:
    settings = SimulationSettings()
    assert (settings.reflection_order, settings.diffraction) == (2, True)
    assert (settings.crosstalk, settings.second_time_around) == (True, True)
    assert (settings.dropout, settings.stray, settings.servo_latency) == (0.0, 0.0, 0.0)
    assert settings.odometry == OdometryNoise()
    assert settings.air.temperature == settings.assumed_temperature


def test_every_setting_says_what_it_means() -> None:
    for kind in (SimulationSettings, OdometryNoise):
        assert all(field.description for field in kind.model_fields.values())
