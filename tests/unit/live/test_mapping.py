import numpy as np
import pytest

from echoplan.live.mapping import sensor_faults
from echoplan.live.survey import Survey
from echoplan.preprocessing import SensorFaultKind
from helpers.fed import RIG, swept


def surveyed(count: int, *, sensor: int, reading: float) -> Survey:
    """Sweeps of a robot that drives and turns, in which one sensor always reads the same."""
    survey, ranges = Survey(name="bench", rig=RIG), swept().ranges
    readings = np.where(swept().sensor_ids == sensor, reading, ranges)
    for number in range(count):
        survey = survey.with_sweep(swept(pose=(float(number), 0.0, 1.5 * number), ranges=readings))
    return survey


@pytest.mark.parametrize("reading", [np.inf, np.nan, -np.inf])
def test_a_silent_sensor_is_found_in_two_sweeps(reading: float) -> None:
    (fault,) = sensor_faults(surveyed(2, sensor=1, reading=reading)).sensors
    assert (fault.sensor_id, fault.kind) == (1, SensorFaultKind.DEAD)
    assert not sensor_faults(surveyed(1, sensor=1, reading=reading)).sensors


def test_a_stuck_sensor_is_found_in_three_sweeps() -> None:
    (fault,) = sensor_faults(surveyed(3, sensor=0, reading=0.431)).sensors
    assert (fault.sensor_id, fault.kind, fault.value) == (0, SensorFaultKind.STUCK, 0.431)


def test_a_survey_without_sweeps_has_no_faults() -> None:
    assert not sensor_faults(Survey(name="bench", rig=RIG)).sensors
