from dataclasses import replace

import numpy as np
import pytest

from echoplan.preprocessing import recording_statistics
from helpers import scenes


def test_every_ping_is_counted_once_by_what_came_of_it() -> None:
    ranges = np.full(360, 1.0)
    # Of the first sensor, which looks in the first 90 directions.
    ranges[:6] = [np.inf, -np.inf, np.nan, 0.01, 3.5, 2.5]
    first, *others = recording_statistics([scenes.sweep_of(ranges)], scenes.rig()).sensors
    assert (first.sensor_id, first.pings, first.valid) == (0, 90, 85)
    assert (first.silent, first.too_close, first.faulty) == (2, 2, 1)
    assert (first.shortest, first.longest) == (1.0, 2.5)
    for each in others:
        assert (each.pings, each.valid, each.silent, each.too_close, each.faulty) == (90, 90, 0, 0, 0)


def test_a_sensor_that_never_detected_anything_has_no_extremes() -> None:
    ranges = np.full(360, 1.0)
    ranges[90:180] = np.inf
    deaf = recording_statistics([scenes.sweep_of(ranges)], scenes.rig()).sensors[1]
    assert (deaf.valid, deaf.silent) == (0, 90)
    assert np.isnan([deaf.shortest, deaf.longest]).all()


def test_counts_and_extremes_are_those_of_all_sweeps() -> None:
    sweeps = [scenes.sweep_of(np.full(360, distance), index=index) for index, distance in enumerate((1.0, 0.4, 2.0))]
    found = recording_statistics(iter(sweeps), scenes.rig())
    assert found.sweeps == 3
    assert [each.pings for each in found.sensors] == [270] * 4
    assert [(each.shortest, each.longest) for each in found.sensors] == [(0.4, 2.0)] * 4


def test_time_runs_from_the_first_ping_to_the_last_and_the_way_from_station_to_station() -> None:
    poses = [(0.0, 0.0, 0.0), (3.0, 4.0, 1.0), (3.0, 1.0, 2.0)]
    sweeps = [scenes.sweep_of(np.ones(360), index=index, pose=pose) for index, pose in enumerate(poses)]
    found = recording_statistics(sweeps, scenes.rig())
    assert found.duration == pytest.approx(2 * 10.0 + 89 * 0.025)
    assert found.way == pytest.approx(5.0 + 3.0)
    assert (found.low_xy.tolist(), found.high_xy.tolist()) == ([0.0, 0.0], [3.0, 4.0])


def test_the_air_is_as_warm_as_the_thermometer_says_in_the_median() -> None:
    sweeps = [replace(scenes.sweep_of(np.ones(360)), temperature=each) for each in (18.0, np.nan, 21.0)]
    assert recording_statistics(sweeps, scenes.rig()).temperature == pytest.approx(19.5)
    assert np.isnan(recording_statistics(sweeps[1:2], scenes.rig()).temperature)


def test_the_sensors_stand_in_the_order_of_the_rig() -> None:
    found = recording_statistics([scenes.sweep_of(np.ones(360))], scenes.rig())
    assert [each.sensor_id for each in found.sensors] == scenes.rig().sensor_ids.tolist()
