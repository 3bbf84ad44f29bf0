import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.preprocessing.health import HealthSettings, healthy
from echoplan.preprocessing.soundings import Soundings
from expectations import ROOM, hearing, listening

SENSORS = 4


@pytest.fixture(scope="module")
def room() -> Soundings:
    """A room as four sensors hear it from four stations: each every fourth ping."""
    soundings = hearing(listening(), ROOM)
    return soundings._replace(sensors=np.arange(len(soundings.readings)) % SENSORS)


def with_sensor(soundings: Soundings, sensor: int, readings: FloatArray | float) -> Soundings:
    """Soundings of which one sensor says something else."""
    changed = soundings.readings.copy()
    changed[soundings.sensors == sensor] = readings
    return soundings._replace(readings=changed)


def ill(soundings: Soundings, **settings: float) -> list[int]:
    """Sensors that are not listened to."""
    listened = healthy(soundings, HealthSettings.model_validate(settings))
    assert all(len(set(listened[soundings.sensors == k])) == 1 for k in set(soundings.sensors))
    return sorted(set(soundings.sensors[~listened].tolist()))


def test_sensors_that_hear_a_room_are_healthy(room: Soundings) -> None:
    assert ill(room) == []


def test_a_sensor_that_hears_nothing_where_others_do_is_found(room: Soundings) -> None:
    assert ill(with_sensor(room, 2, np.inf)) == [2]


def test_a_sensor_that_always_says_the_same_is_found(room: Soundings) -> None:
    jitter = np.random.default_rng(0).uniform(-0.003, 0.003, int((room.sensors == 1).sum()))
    assert ill(with_sensor(room, 1, 0.07 + jitter)) == [1]


def test_a_sensor_that_is_stuck_in_most_of_its_pings_is_found_and_one_that_is_in_few_is_not(room: Soundings) -> None:
    own = room.readings[room.sensors == 3]
    for share, found in [(0.7, [3]), (0.25, [])]:
        stuck = np.random.default_rng(1).random(len(own)) < share
        assert ill(with_sensor(room, 3, np.where(stuck, 0.07, own))) == found


def test_a_dead_and_a_stuck_sensor_are_found_together(room: Soundings) -> None:
    assert ill(with_sensor(with_sensor(room, 0, 0.5), 3, np.inf)) == [0, 3]


def test_a_sensor_that_hears_half_as_much_as_others_is_healthy(room: Soundings) -> None:
    own = room.readings[room.sensors == 2].copy()
    own[::2] = np.inf
    assert ill(with_sensor(room, 2, own)) == []


def test_where_nobody_hears_anything_nobody_is_ill(room: Soundings) -> None:
    assert ill(room._replace(readings=np.full(len(room.readings), np.inf))) == []


def test_a_few_pings_tell_nothing_about_a_sensor(room: Soundings) -> None:
    seldom = room._replace(sensors=np.where(np.arange(len(room.readings)) < 29, 1, 0))
    assert ill(with_sensor(seldom, 1, np.inf)) == []
    assert ill(with_sensor(seldom, 1, np.inf), least_pings=29) == [1]


def test_from_two_stations_the_world_itself_may_look_alike() -> None:
    soundings = hearing(listening([(0.0, 0.0), (0.1, 0.0)]), ROOM)
    assert ill(soundings._replace(readings=np.full(len(soundings.readings), 0.5))) == []


def test_numbers_without_a_sensor_are_passed_over(room: Soundings) -> None:
    gap = room._replace(sensors=np.where(room.sensors == 2, 9, room.sensors))
    assert ill(gap) == []
    assert ill(with_sensor(gap, 9, np.inf)) == [9]


def test_without_pings_there_is_nothing_to_tell(room: Soundings) -> None:
    none = np.zeros(0)
    assert healthy(room._replace(readings=none, sensors=none.astype(int)), HealthSettings()).shape == (0,)
