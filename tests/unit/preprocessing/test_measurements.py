from dataclasses import replace

import numpy as np
import pytest

from echoplan.acoustics import Air
from echoplan.arrays import FloatArray
from echoplan.geometry import wrap
from echoplan.model import Rig, Sensor, Sweep
from echoplan.preprocessing.measurements import (
    Measurements,
    first_stations,
    independent,
    join_measurements,
    measurements_of,
    select_measurements,
    step_of,
)
from echoplan.preprocessing.servo import ServoError, apply_servo_latency, turned_by
from helpers.expectations import listening
from helpers.scenes import ARM, rig, sweep_of

POSE = (0.7, -0.4, 0.3)
BY_PING = (
    "x", "y", "ux", "uy", "arms_x", "arms_y", "rates", "readings", "stations", "sensors", "crosstalk_delays", "weights",
)  # fmt: skip


def recorded_sweep(*, pose: tuple[float, float, float] = POSE, index: int = 0, **changed: float) -> Sweep:
    """A sweep whose readings grow by 5 mm a degree; ``a7`` replaces that at 7 degrees, and so on."""
    ranges = 0.5 + 0.005 * np.arange(360.0)
    for degrees, value in changed.items():
        ranges[int(degrees[1:])] = value
    return sweep_of(ranges, index=index, pose=pose)


def same(measurements: Measurements, others: Measurements, *, but: tuple[str, ...] = ()) -> bool:
    """Whether pings are alike in all but something."""
    names = [name for name in (*BY_PING, "crosstalk_sources") if name not in but]
    return all(np.allclose(getattr(measurements, name), getattr(others, name), atol=1e-12) for name in names)


def one_sensor(servo_angles: FloatArray, ranges: FloatArray) -> tuple[Sweep, Rig]:
    """A single sensor that turns."""
    count = len(ranges)
    sweep = Sweep(
        index=0,
        stamps_ns=np.arange(count) * 50_000_000,
        sensor_ids=np.zeros(count, dtype=np.int64),
        servo_angles=servo_angles,
        ranges=ranges,
        map_from_base=np.zeros((count, 3)),
    )
    return sweep, rig(sensors=1)


def test_pings_lie_where_the_rig_holds_its_sensors() -> None:
    measurements = measurements_of(recorded_sweep(), rig())
    away = np.column_stack([measurements.x - POSE[0], measurements.y - POSE[1]])
    assert np.hypot(*away.T) == pytest.approx(ARM)
    assert away / ARM == pytest.approx(np.column_stack([measurements.ux, measurements.uy]))
    assert np.column_stack([measurements.arms_x, measurements.arms_y]) == pytest.approx(away)


def test_a_ping_looks_where_the_sensor_looked_halfway_between_sending_and_receiving() -> None:
    measurements = measurements_of(recorded_sweep(a100=np.inf), rig())
    stated = np.radians(-45.0 + np.repeat(np.arange(90.0), 4) + np.tile(90.0 * np.arange(4), 90)) + POSE[2]
    ways = np.where(np.isfinite(measurements.readings), measurements.readings, 1.5)
    turned = wrap(measurements.bearings - stated)
    assert turned == pytest.approx(np.radians(40.0) * ways / Air().speed_of_sound, rel=1e-6)
    assert 0.05 < np.degrees(turned.max()) < 0.3


def test_without_a_servo_sensors_look_where_the_rig_holds_them() -> None:
    measurements = measurements_of(*one_sensor(np.full(5, 0.3), np.ones(5)))
    assert measurements.bearings == pytest.approx(0.3)


def test_the_centre_of_a_station_is_the_mean_of_its_pings() -> None:
    measurements = measurements_of(recorded_sweep(), rig())
    assert measurements.centers == pytest.approx(np.array([POSE[:2]]), abs=1e-9)


def test_a_reading_within_a_step_of_the_reach_means_that_nothing_was_detected() -> None:
    measurements = measurements_of(recorded_sweep(a100=2.99, a101=2.995, a102=3.0, a103=np.inf), rig())
    degrees = np.round(np.degrees(wrap(measurements.bearings - POSE[2])) + 45.0).astype(int) % 360
    order = np.argsort(degrees)
    assert measurements.readings[order][100:104].tolist() == [2.99, np.inf, np.inf, np.inf]
    assert np.isfinite(measurements.readings).sum() == 357


@pytest.mark.parametrize("nothing", [np.nan, -np.inf, 0.0, 0.0299])
def test_faulty_readings_and_those_within_the_dead_distance_are_left_out(nothing: float) -> None:
    measurements = measurements_of(recorded_sweep(a7=nothing), rig())
    assert len(measurements.readings) == 359
    assert np.isfinite(measurements.readings).all()


def test_a_reading_at_the_dead_distance_counts() -> None:
    assert 0.03 in measurements_of(recorded_sweep(a7=0.03), rig()).readings


def test_each_sensor_is_held_to_its_own_limits() -> None:
    sensors = tuple(
        Sensor(sensor_id=k, half_aperture=0.6, min_range=low, max_range=high, resolution=0.01)
        for k, (low, high) in enumerate([(0.03, 1.0), (0.3, 4.0)])
    )
    both = Rig(name="unlike", sensors=sensors)
    sweep = Sweep(
        index=0,
        stamps_ns=np.array([0, 1, 2, 3]),
        sensor_ids=np.array([0, 1, 0, 1]),
        servo_angles=np.zeros(4),
        ranges=np.array([0.2, 0.2, 2.0, 2.0]),
        map_from_base=np.zeros((4, 3)),
    )
    measurements = measurements_of(sweep, both)
    assert measurements.readings.tolist() == [0.2, np.inf, 2.0]
    assert measurements.sensors.tolist() == [0, 0, 1]
    assert (measurements.min_range, measurements.max_range) == (0.3, 4.0)


def test_crosstalk_sources_are_the_other_pings_of_the_same_time() -> None:
    measurements = measurements_of(recorded_sweep(), rig())
    volleys = np.repeat(np.arange(90), 4)
    for ping in (0, 5, 359):
        others = np.flatnonzero(volleys == volleys[ping])
        assert sorted([ping, *measurements.crosstalk_sources[ping, :3]]) == others.tolist()
    assert (measurements.crosstalk_delays[:, :3] == 0.0).all()


def test_crosstalk_sources_include_the_pings_of_the_previous_firing() -> None:
    measurements = measurements_of(recorded_sweep(), rig())
    assert measurements.crosstalk_sources[:4, 3:].tolist() == [[-1] * 4] * 4
    for ping in (4, 7, 358):
        before = 4 * (ping // 4) - 4
        assert measurements.crosstalk_sources[ping, 3:].tolist() == [before, before + 1, before + 2, before + 3]
    assert measurements.crosstalk_delays[4:, 3:] == pytest.approx(0.025)


def test_a_firing_that_is_too_long_ago_is_forgotten() -> None:
    recorded = recorded_sweep()
    slowly = replace(recorded, stamps_ns=4 * recorded.stamps_ns)
    assert (measurements_of(slowly, rig()).crosstalk_sources[:, 3:] == -1).all()


def test_a_ping_that_is_left_out_is_no_crosstalk_source() -> None:
    measurements = measurements_of(recorded_sweep(a90=np.nan), rig())
    # The sensor at 90 degrees from the first fires in the first volley.
    assert measurements.sensors[:3].tolist() == [0, 2, 3]
    assert [sorted(row) for row in measurements.crosstalk_sources[:3, :3].tolist()] == [
        [-1, 1, 2],
        [-1, 0, 2],
        [-1, 0, 1],
    ]


def test_the_only_crosstalk_source_of_a_single_sensor_is_its_last_ping() -> None:
    measurements = measurements_of(*one_sensor(np.radians(np.arange(10.0)), np.ones(10)))
    assert measurements.crosstalk_sources.shape == (10, 1)
    assert measurements.crosstalk_sources[:, 0].tolist() == list(range(-1, 9))


def test_rates_are_how_fast_the_servo_turned_at_each_time() -> None:
    measurements = measurements_of(recorded_sweep(), rig())
    assert measurements.rates == pytest.approx(np.radians(1.0) / 0.025)
    there_and_back = np.radians([0.0, 1.0, 2.0, 3.0, 2.0, 1.0, 0.0])
    rates = measurements_of(*one_sensor(there_and_back, np.ones(7))).rates
    assert rates == pytest.approx(np.radians(20.0) * np.array([1, 1, 1, 0, -1, -1, -1]), abs=1e-9)


def test_the_rate_of_a_ping_does_not_depend_on_readings_of_its_neighbours() -> None:
    angles, ranges = np.radians([0.0, 1.0, 4.0, 9.0, 16.0]), np.array([1.0, np.nan, 1.0, np.nan, 1.0])
    complete = measurements_of(*one_sensor(angles, np.ones(5)))
    assert measurements_of(*one_sensor(angles, ranges)).rates == pytest.approx(complete.rates[[0, 2, 4]])


def test_ways_count_from_the_pose_of_the_sweep_and_a_turn_of_a_radian_as_a_metre() -> None:
    sweep = recorded_sweep()
    rounded = sweep.map_from_base + np.outer(np.arange(360.0), [1e-16, -1e-16, 1e-16])
    assert not measurements_of(replace(sweep, map_from_base=rounded), rig()).ways.any()
    poses = sweep.map_from_base + np.outer(np.arange(360.0), [3e-4, 4e-4, 0.0])
    poses[200:, 2] += 0.2
    ways = measurements_of(replace(sweep, map_from_base=poses), rig()).ways
    assert ways[[0, 180, 199]] == pytest.approx([-0.09, 0.0, 0.0095])
    assert ways[200] == pytest.approx(0.21)


def test_a_single_ping_does_not_turn() -> None:
    assert measurements_of(*one_sensor(np.zeros(1), np.ones(1))).rates.tolist() == [0.0]


@pytest.mark.parametrize("latency", [0.04, -0.03])
def test_pings_turned_back_are_those_of_a_servo_without_latency(latency: float) -> None:
    recorded = recorded_sweep()
    rate = np.radians(1.0) / 0.025
    truth = measurements_of(replace(recorded, servo_angles=recorded.servo_angles - latency * rate), rig())
    turned = apply_servo_latency(measurements_of(recorded, rig()), latency)
    assert same(turned, truth)
    assert not same(measurements_of(recorded, rig()), truth)


def test_pings_turned_by_gain_and_offset_are_those_of_a_servo_that_was_there() -> None:
    recorded = recorded_sweep()
    error = ServoError(0.95, 0.07)
    truth = measurements_of(replace(recorded, servo_angles=0.95 * recorded.servo_angles + 0.07), rig())
    turned = turned_by(measurements_of(recorded, rig()), error=error, before=ServoError())
    assert turned.bearings == pytest.approx(truth.bearings, abs=2e-3)
    assert turned.x == pytest.approx(truth.x, abs=2e-4)
    back = turned_by(turned, error=ServoError(), before=error)
    assert back.bearings == pytest.approx(measurements_of(recorded, rig()).bearings)
    assert turned_by(turned, error=error, before=error) is turned


def test_without_latency_pings_stay_as_they_are() -> None:
    measurements = measurements_of(recorded_sweep(), rig())
    assert apply_servo_latency(measurements, 0.0) is measurements


def test_a_servo_that_stands_is_never_late() -> None:
    measurements = listening([(0.0, 0.0)])
    assert same(apply_servo_latency(measurements, 0.3), measurements)


def test_pings_closer_than_four_degrees_share_one_vote() -> None:
    weights = [
        measurements_of(*one_sensor(np.radians(step * np.arange(20)), np.ones(20))).weights for step in (1, 3, 9)
    ]
    assert [each[0] for each in weights] == pytest.approx([0.25, 0.75, 1.0])
    assert all((each == each[0]).all() for each in weights)


def test_a_sweep_without_valid_readings_is_a_station_without_pings() -> None:
    measurements = measurements_of(sweep_of(np.full(360, np.nan), pose=POSE), rig())
    assert len(measurements.readings) == len(measurements.crosstalk_sources) == 0
    assert measurements.centers == pytest.approx(np.array([POSE[:2]]))


def test_joined_stations_are_numbered_in_order_and_keep_their_pings() -> None:
    parts = [
        measurements_of(recorded_sweep(pose=(x, 0.0, 0.0), a9=np.nan, index=k), rig())
        for k, x in enumerate([0.0, 1.0, 2.0])
    ]
    joined = join_measurements(parts)
    assert np.bincount(joined.stations).tolist() == [359, 359, 359]
    assert joined.centers[:, 0] == pytest.approx([0.0, 1.0, 2.0], abs=1e-3)
    for number, part in enumerate(parts):
        own = select_measurements(joined, joined.stations == number)
        assert same(own, part, but=("stations",))


def test_crosstalk_sources_in_joined_stations_are_of_the_same_station_and_time() -> None:
    parts = [measurements_of(recorded_sweep(index=k), rig()) for k in range(2)]
    joined = join_measurements([measurements_of(*one_sensor(np.radians(np.arange(5.0)), np.ones(5))), *parts])
    assert joined.crosstalk_sources[:5, 0].tolist() == [-1, 0, 1, 2, 3]
    assert (joined.crosstalk_sources[:5, 1:] == -1).all()
    elsewhere = joined.stations[joined.crosstalk_sources[5:]] != joined.stations[5:, None]
    assert not (elsewhere & (joined.crosstalk_sources[5:] >= 0)).any()
    assert joined.crosstalk_sources[5 + 360, :3].tolist() == [366, 367, 368]


def test_the_limits_of_joined_stations_are_the_widest() -> None:
    near, far = listening([(0.0, 0.0)])._replace(max_range=2.0), listening([(1.0, 0.0)])._replace(min_range=0.1)
    joined = join_measurements([near, far])
    assert (joined.min_range, joined.max_range) == (0.1, 4.0)


def test_selected_pings_keep_the_crosstalk_sources_that_are_selected() -> None:
    measurements = join_measurements([measurements_of(recorded_sweep(index=k), rig()) for k in range(2)])
    kept = np.random.default_rng(3).random(720) < 0.6
    chosen, left = select_measurements(measurements, kept), np.flatnonzero(kept)
    assert len(chosen.readings) == kept.sum()
    for ping, old in enumerate(left):
        now = {int(left[mate]) for mate in chosen.crosstalk_sources[ping] if mate >= 0}
        assert now == {int(mate) for mate in measurements.crosstalk_sources[old] if kept[mate]}


def test_selecting_all_pings_returns_the_same_measurements() -> None:
    measurements = measurements_of(recorded_sweep(), rig())
    assert select_measurements(measurements, np.ones(360, dtype=bool)) is measurements


def test_stations_without_chosen_pings_keep_their_numbers() -> None:
    measurements = listening([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)])
    chosen = select_measurements(measurements, measurements.stations == 2)
    assert set(chosen.stations.tolist()) == {2}
    assert len(chosen.centers) == 3


def test_the_first_stations_are_as_if_the_others_had_not_been() -> None:
    first = first_stations(listening([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]), 2)
    assert set(first.stations.tolist()) == {0, 1}
    assert len(first.centers) == 2


@pytest.mark.parametrize(("degrees", "every"), [(1.0, 4), (2.0, 2), (3.0, 1), (22.5, 1)])
def test_independent_pings_are_four_degrees_apart_as_far_as_whole_steps_allow(degrees: float, every: int) -> None:
    measurements = measurements_of(
        *one_sensor(np.radians(np.arange(0.0, 360.0, degrees)), np.ones(round(360 / degrees)))
    )
    kept = independent(measurements)
    assert kept.sum() == len(kept) / every
    assert np.diff(np.sort(measurements.bearings[kept])) == pytest.approx(np.radians(every * degrees))


def test_independent_pings_surround_every_station() -> None:
    measurements = join_measurements([measurements_of(recorded_sweep(index=k), rig()) for k in range(3)])
    kept = independent(measurements)
    assert np.bincount(measurements.stations[kept]).tolist() == [90, 90, 90]


def test_a_rounding_in_the_step_keeps_no_more_pings() -> None:
    measurements = listening([(0.0, 0.0)], step=np.radians(2.0))
    for weight in (0.5 - 1e-15, 0.5, 0.5 + 1e-15):
        kept = independent(measurements._replace(weights=np.full(len(measurements.weights), weight)))
        assert kept.sum() == len(kept) / 2


@pytest.mark.parametrize("degrees", [1.5, 5.0, 22.5])
def test_a_step_is_from_one_ping_to_the_next_however_far_that_is(degrees: float) -> None:
    assert step_of(listening(step=np.radians(degrees))) == pytest.approx(np.radians(degrees))


def test_a_second_sweep_of_a_ring_at_the_same_station_is_no_step() -> None:
    once = listening([(0.0, 0.0)], step=np.radians(22.5))
    turned = np.exp(1j * np.radians(1.5)) * (once.ux + 1j * once.uy)
    again = join_measurements([once, once._replace(ux=turned.real, uy=turned.imag)])
    together = again._replace(stations=0 * again.stations, centers=once.centers)
    assert step_of(together) == pytest.approx(np.radians(21.0))


def test_without_pings_there_is_no_step() -> None:
    nobody = np.zeros(len(listening().readings), dtype=bool)
    assert step_of(select_measurements(listening(), nobody)) == np.inf
