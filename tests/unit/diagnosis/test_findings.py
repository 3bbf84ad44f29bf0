import pytest

from echoplan.diagnosis import faults_in_words
from echoplan.preprocessing import (
    Faults,
    RecordingFault,
    RecordingFaultKind,
    SensorFault,
    SensorFaultKind,
)


def test_nothing_is_said_of_a_sound_recording() -> None:
    assert faults_in_words(Faults()) == ()


@pytest.mark.parametrize("kind", SensorFaultKind)
def test_every_fault_of_a_sensor_names_it_and_says_what_to_do(kind: SensorFaultKind) -> None:
    fault = SensorFault(sensor_id=7, kind=kind, value=2.0, share=0.25)
    (said,) = faults_in_words(Faults(sensors=(fault,)))
    assert said.startswith("Sensor 7 ")
    assert said.endswith(".")
    assert said.count(". ") >= 2
    assert "{" not in said


@pytest.mark.parametrize("kind", RecordingFaultKind)
def test_every_fault_of_a_recording_says_what_to_do(kind: RecordingFaultKind) -> None:
    (said,) = faults_in_words(Faults(recording=(RecordingFault(kind=kind),)))
    assert said.endswith(".")
    assert any(verb in said for verb in ("Record from", "Write where", "--method point-plot draws"))


def test_values_have_their_units() -> None:
    stuck = SensorFault(sensor_id=0, kind=SensorFaultKind.STUCK, value=1.27)
    zero = SensorFault(sensor_id=1, kind=SensorFaultKind.NO_ECHO_VALUE, value=0.0, share=0.568)
    beam = RecordingFault(kind=RecordingFaultKind.NARROW_BEAM, value=0.0)
    whole, first, second = faults_in_words(Faults(sensors=(stuck, zero), recording=(beam,)))
    assert "about 2\N{DEGREE SIGN} in all" in whole
    assert "reads 1.27 m wherever the robot stands and the sensor points" in first
    assert "reads 0 m where it has no echo (57 % of its readings)" in second


def test_sensors_with_the_same_fault_share_a_sentence() -> None:
    faults = tuple(SensorFault(sensor_id=k, kind=SensorFaultKind.HELD) for k in (0, 2, 3))
    (said,) = faults_in_words(Faults(sensors=faults))
    assert said.startswith("Each of the sensors 0, 2 and 3 repeats its last reading")
