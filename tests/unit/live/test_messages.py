import numpy as np

from echoplan.live.messages import faults_message, shares_message
from echoplan.preprocessing import Faults, SensorFault, SensorFaultKind
from helpers.fed import RIG, swept


def test_the_share_of_a_sensor_is_that_of_its_valid_readings() -> None:
    sweep = swept()
    half = np.where(np.arange(364) // 4 % 2, [np.inf, np.nan, -np.inf, 99.0] * 91, sweep.ranges)
    ranges = np.where(sweep.sensor_ids == 2, half, sweep.ranges)
    shown = shares_message([swept(ranges=ranges), swept()[:40]], RIG)
    assert [each["id"] for each in shown] == [0, 1, 2, 3]
    assert [each["pings"] for each in shown] == [101] * 4
    assert [each["share"] for each in shown] == [1.0, 1.0, round(56 / 101, 3), 1.0]


def test_a_sensor_that_does_not_fire_has_no_pings() -> None:
    sweep = swept()
    assert shares_message([sweep[sweep.sensor_ids != 3]], RIG)[3] == {"id": 3, "pings": 0, "share": 0.0}
    assert [each["pings"] for each in shares_message([], RIG)] == [0] * 4


def test_faults_are_sentences_and_the_sensors_that_they_concern() -> None:
    fault = SensorFault(sensor_id=2, kind=SensorFaultKind.DEAD)
    message = faults_message(Faults(sensors=(fault,)))
    assert message["sensors"] == [2]
    assert str(message["sentences"]).startswith("('Sensor 2 has no echo")
