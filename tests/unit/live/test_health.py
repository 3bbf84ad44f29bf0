import numpy as np

from echoplan.arrays import FloatArray
from echoplan.live.health import SensorState, sensor_health
from echoplan.model import Sweep
from helpers.fed import RIG, swept


def states(*sweeps: Sweep) -> dict[int, SensorState]:
    return {each.sensor_id: each.state for each in sensor_health(sweeps, RIG)}


def with_readings(sensor: int, readings: float | FloatArray) -> Sweep:
    sweep = swept()
    return swept(ranges=np.where(sweep.sensor_ids == sensor, readings, sweep.ranges))


def test_before_the_first_pings_every_sensor_waits() -> None:
    assert set(states().values()) == {SensorState.WAITING}
    assert set(states(swept()[:40]).values()) == {SensorState.WAITING}


def test_sensors_with_echoes_are_good_and_their_share_is_that_of_valid_readings() -> None:
    half = np.where(np.arange(364) // 4 % 2, np.inf, 1.0 + np.arange(364) / 1000)
    health = {each.sensor_id: each for each in sensor_health([with_readings(2, half)], RIG)}
    assert {each.state for each in health.values()} == {SensorState.GOOD}
    assert health[1].share == 1.0
    assert abs(health[2].share - 0.5) < 0.01


def test_a_silent_sensor_is_found_in_one_sweep() -> None:
    for nothing in (np.inf, np.nan, -np.inf):
        assert states(with_readings(1, nothing))[1] is SensorState.SILENT


def test_a_sensor_that_no_longer_fires_is_silent() -> None:
    sweep = swept()
    found = states(sweep[sweep.sensor_ids != 3], sweep[sweep.sensor_ids != 3])
    assert found[3] is SensorState.SILENT
    assert found[0] is SensorState.GOOD


def test_a_stuck_sensor_is_found_in_one_sweep() -> None:
    assert states(with_readings(0, 0.431))[0] is SensorState.STUCK
