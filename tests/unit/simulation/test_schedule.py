from typing import Any

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.errors import InvalidValueError
from echoplan.geometry import compose
from echoplan.model import Rig, Route
from echoplan.simulation.schedule import Schedule, build_schedule, default_firing
from helpers import simulated_worlds

SECOND = 1_000_000_000
STATIONS = Route(map_from_base=np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 0.5], [3.0, 0.0, -1.0]]))


def driven(seconds: float, *, to: tuple[float, float, float] = (1.0, 0.0, 0.0)) -> Route:
    """A straight way of so many seconds."""
    return Route(map_from_base=np.array([[0.0, 0.0, 0.0], to]), stamps_ns=np.array([0, round(seconds * SECOND)]) + 5)


def sweeps(schedule: Schedule, column: FloatArray) -> list[list[float]]:
    return [column[begin:end].tolist() for begin, end in zip(schedule.bounds[:-1], schedule.bounds[1:], strict=True)]


def two_groups(**changed: Any) -> Rig:
    sensors = [simulated_worlds.sensor(number, yaw=number * 0.5) for number in (7, 3)]
    return simulated_worlds.rig(*sensors, groups=((3,), (7,)), period=0.05, **changed)


def test_the_servo_goes_to_and_fro_from_station_to_station() -> None:
    rig = simulated_worlds.rig(servo=simulated_worlds.turning(-10, 10, 10), period=0.1)
    schedule = build_schedule(rig, STATIONS)
    angles = np.radians([-10.0, 0.0, 10.0])
    assert sweeps(schedule, schedule.servo_angles) == [angles.tolist(), angles[::-1].tolist(), angles.tolist()]


def test_a_route_of_a_whole_day_is_refused_before_it_fills_the_memory() -> None:
    with pytest.raises(InvalidValueError, match="the route must take at most 2000000 pings, not 3456002; shorten it"):
        build_schedule(two_groups(), driven(2 * 86_400.0))


def test_at_a_station_the_robot_stands() -> None:
    rig = simulated_worlds.rig(servo=simulated_worlds.turning(-10, 10, 10), period=0.1)
    schedule = build_schedule(rig, STATIONS)
    np.testing.assert_allclose(schedule.map_from_base, np.repeat(STATIONS.map_from_base, 3, axis=0))
    np.testing.assert_allclose(schedule.map_from_base[schedule.stations], STATIONS.map_from_base)


def test_stations_are_too_far_apart_in_time_for_their_echoes_to_meet() -> None:
    schedule = build_schedule(simulated_worlds.rig(period=0.1), STATIONS)
    assert (np.diff(schedule.stamps_ns) >= SECOND).all()


def test_groups_fire_one_after_the_other_while_the_servo_turns_on() -> None:
    schedule = build_schedule(
        two_groups(servo=simulated_worlds.turning(0, 20, 10)), Route(map_from_base=np.zeros((1, 3)))
    )
    assert schedule.sensors.tolist() == [1, 0] * 3
    assert (schedule.stamps_ns / SECOND).tolist() == pytest.approx([0.0, 0.05, 0.1, 0.15, 0.2, 0.25])
    assert np.degrees(schedule.servo_angles).tolist() == pytest.approx([0, 5, 10, 15, 20, 20])


def test_a_fixed_ring_makes_one_sweep_a_round() -> None:
    schedule = build_schedule(two_groups(), driven(0.35))
    assert np.diff(schedule.bounds).tolist() == [2, 2, 2, 2]
    assert (schedule.servo_angles == 0).all()


def test_on_the_move_sweeps_follow_each_other_until_the_route_ends() -> None:
    rig = simulated_worlds.rig(servo=simulated_worlds.turning(0, 30, 10), period=0.1)
    schedule = build_schedule(rig, driven(1.0))
    assert np.diff(schedule.bounds).tolist() == [4, 4, 3]
    assert np.degrees(schedule.servo_angles).tolist() == pytest.approx([0, 10, 20, 30, 30, 20, 10, 0, 0, 10, 20])
    assert np.diff(schedule.stamps_ns).tolist() == [SECOND // 10] * 10


def test_poses_are_those_of_the_moment_of_each_ping() -> None:
    route = Route(
        map_from_base=np.array([[0.0, 0.0, 3.0], [1.0, 0.0, -3.0], [1.0, 2.0, -3.0]]),
        stamps_ns=np.array([0, SECOND, 2 * SECOND]) + 1_763_000_000 * SECOND,
    )
    schedule = build_schedule(simulated_worlds.rig(period=0.5), route)
    turned = 3.0 + 0.5 * (2 * np.pi - 6.0)  # the short way round
    yaws = [3.0, turned, 2 * np.pi - 3, 2 * np.pi - 3, 2 * np.pi - 3]
    expected = np.column_stack([[0, 0.5, 1, 1, 1], [0, 0, 0, 1, 2], yaws])
    np.testing.assert_allclose(schedule.map_from_base, expected, atol=1e-9)


def test_a_sensor_on_an_arm_goes_round_with_the_servo_on_the_robot() -> None:
    rig = simulated_worlds.rig(
        simulated_worlds.sensor(x=0.3, yaw=0.1), servo=simulated_worlds.turning(0, 90, 90), period=1.0
    )
    schedule = build_schedule(rig, Route(map_from_base=np.array([[1.0, 2.0, 0.4]])))
    np.testing.assert_allclose(schedule.map_from_sensors[1], compose([1.0, 2.0, 0.4], [0.0, 0.3, np.pi / 2 + 0.1]))


def test_velocities_are_those_of_robot_and_servo_together() -> None:
    rig = simulated_worlds.rig(simulated_worlds.sensor(x=0.3), servo=simulated_worlds.turning(0, 90, 1), period=0.025)
    schedule = build_schedule(rig, driven(1.0, to=(0.5, 0.0, 0.2)))
    rate = np.radians(1.0) / 0.025 + 0.2
    np.testing.assert_allclose(schedule.velocities[0], [0.5, 0.3 * rate, rate], rtol=1e-3, atol=2e-3)
    standing = build_schedule(simulated_worlds.rig(), STATIONS)
    assert (standing.velocities == 0).all()


def test_a_late_servo_points_where_it_was_commanded_to_a_moment_ago() -> None:
    rig = simulated_worlds.rig(servo=simulated_worlds.turning(0, 10, 1), period=0.025)
    route = Route(map_from_base=np.zeros((2, 3)))
    late = build_schedule(rig, route, servo_latency=0.05)
    commanded, true = np.degrees(late.servo_angles), np.degrees(late.map_from_sensors[:, 2])
    forward, back = commanded[:11] - true[:11], commanded[11:] - true[11:]
    assert forward.tolist() == pytest.approx([0, 1] + [2] * 9)
    assert back.tolist() == pytest.approx([0, -1] + [-2] * 9, abs=1e-9)


def test_a_servo_of_another_gain_mounted_askew_points_elsewhere_than_recorded() -> None:
    rig = simulated_worlds.rig(servo=simulated_worlds.turning(-10, 10, 10), period=0.025)
    route = Route(map_from_base=np.zeros((1, 3)))
    schedule = build_schedule(rig, route, servo_gain=0.9, servo_offset=np.radians(4.0))
    assert np.degrees(schedule.servo_angles).tolist() == pytest.approx([-10.0, 0.0, 10.0])
    assert np.degrees(schedule.map_from_sensors[:, 2]).tolist() == pytest.approx([-5.0, 4.0, 13.0])


def test_fixed_sensors_are_not_turned_by_the_offset_of_a_servo() -> None:
    rig, route = simulated_worlds.rig(period=0.025), Route(map_from_base=np.zeros((1, 3)))
    schedule = build_schedule(rig, route, servo_gain=0.9, servo_offset=0.1)
    assert schedule.map_from_sensors[:, 2].tolist() == [0.0]


def test_without_an_order_all_sensors_fire_at_once_every_25_ms() -> None:
    plain = Rig(name="plain", sensors=(simulated_worlds.sensor(4), simulated_worlds.sensor(2)))
    firing = default_firing(plain)
    assert (firing.period, firing.groups) == (0.025, ((4, 2),))
    assert default_firing(two_groups()).groups == ((3,), (7,))
