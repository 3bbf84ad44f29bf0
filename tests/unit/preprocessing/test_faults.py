"""Mistakes of modules and of people, made in recordings of simulated rooms, are found and kept out of maps."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from echoplan.arrays import FloatArray
from echoplan.model import Rig, Sensor, Sweep
from echoplan.preprocessing import (
    Faults,
    RecordingFaultKind,
    SensorFaultKind,
    clean_sweeps,
    find_faults,
)
from echoplan.simulation import SimulationSettings
from echoplan.sources import open_source
from library import ray_cones

Mistake = Callable[[FloatArray], FloatArray]


@cache
def recorded(source: str) -> tuple[Rig, tuple[Sweep, ...]]:
    room = open_source(source)
    return room.rig, tuple(room)


ROOM = "sim:paper-room,rig=hc-sr04-servo,seed=21"


def with_readings(sweeps: tuple[Sweep, ...], mistake: Mistake, *, sensor: int = 0) -> tuple[Sweep, ...]:
    """Sweeps in which one sensor makes a mistake, which may reach over from sweep to sweep."""
    owns = [sweep.sensor_ids == sensor for sweep in sweeps]
    wrong = mistake(np.concatenate([sweep.ranges[own] for sweep, own in zip(sweeps, owns, strict=True)]))
    parts = np.split(wrong, np.cumsum([own.sum() for own in owns])[:-1])
    changed = []
    for sweep, own, part in zip(sweeps, owns, parts, strict=True):
        ranges = sweep.ranges.copy()
        ranges[own] = part
        changed.append(replace(sweep, ranges=ranges))
    return tuple(changed)


def moved(sweeps: tuple[Sweep, ...], poses: FloatArray) -> tuple[Sweep, ...]:
    """Sweeps with other poses, shape (w, 3)."""
    return tuple(
        replace(sweep, map_from_base=np.tile(p, (len(sweep), 1))) for sweep, p in zip(sweeps, poses, strict=True)
    )


def instead_of_no_echo(value: float) -> Mistake:
    return lambda readings: np.where(np.isinf(readings), value, readings)


def holding(readings: FloatArray) -> FloatArray:
    last = np.maximum.accumulate(np.where(np.isfinite(readings), np.arange(len(readings)), 0))
    return readings[last]


def kinds(faults: Faults) -> list[tuple[int, SensorFaultKind]]:
    return [(fault.sensor_id, fault.kind) for fault in faults.sensors]


def all_ranges(sweeps: tuple[Sweep, ...]) -> FloatArray:
    return np.concatenate([sweep.ranges for sweep in sweeps])


@pytest.mark.parametrize("rig", ["hc-sr04-servo", "rotary-array", "ring-16"])
@pytest.mark.parametrize(
    "world", ["square", "hexagon", "paper-room", "cylinders", "corridor", "office", "two-room-flat"]
)
def test_a_sound_recording_has_no_faults_and_stays_as_it_is(world: str, rig: str) -> None:
    used, sweeps = recorded(f"sim:{world},rig={rig},seed=22")
    faults = find_faults(sweeps, used)
    assert faults == Faults()
    assert all(one is other for one, other in zip(clean_sweeps(sweeps, used, faults), sweeps, strict=True))


@pytest.mark.parametrize("step", [0.01, 0.0254, 0.05, 0.1])
@pytest.mark.parametrize("world", ["paper-room", "hexagon", "square", "office"])
def test_readings_in_coarse_steps_are_sound(world: str, step: float) -> None:
    rig, sweeps = recorded(f"sim:{world},rig=rotary-array,seed=23")
    for sensor in range(4):
        sweeps = with_readings(sweeps, lambda readings: np.round(readings / step) * step, sensor=sensor)
    assert find_faults(sweeps, rig).sensors == ()


def test_no_pings_have_no_faults() -> None:
    rig, _ = recorded(ROOM)
    assert find_faults((), rig) == Faults()
    assert clean_sweeps((), rig, Faults()) == ()


@pytest.mark.parametrize("value", [0.0, 0.01, 2.55, 3.9])
def test_a_value_for_no_echo_becomes_no_echo(value: float) -> None:
    rig, sweeps = recorded(ROOM)
    wrong = with_readings(sweeps, instead_of_no_echo(value))
    faults = find_faults(wrong, rig)
    assert kinds(faults) == [(0, SensorFaultKind.NO_ECHO_VALUE)]
    assert faults.sensors[0].value == pytest.approx(value)
    assert faults.sensors[0].share == pytest.approx(np.isinf(all_ranges(sweeps)).mean(), abs=0.01)
    different = all_ranges(clean_sweeps(wrong, rig, faults)) != all_ranges(sweeps)
    assert different.mean() < 0.01


@pytest.mark.parametrize("value", [4.0, 9.99])
def test_a_value_out_of_reach_is_no_echo_anyway(value: float) -> None:
    rig, sweeps = recorded(ROOM)
    assert find_faults(with_readings(sweeps, instead_of_no_echo(value)), rig) == Faults()


def test_a_reading_below_min_range_is_too_close_where_another_value_stands_for_no_echo() -> None:
    rig, sweeps = recorded(ROOM)
    near = with_readings(sweeps, lambda readings: np.where(readings < 1.11, 0.0, readings))
    assert find_faults(near, rig) == Faults()


def test_a_value_for_all_that_is_too_close_says_nothing() -> None:
    rig, sweeps = recorded(ROOM)
    wrong = with_readings(sweeps, lambda readings: np.where(readings < 1.3, 0.22, readings))
    faults = find_faults(wrong, rig)
    assert kinds(faults) == [(0, SensorFaultKind.BLIND_VALUE)]
    assert faults.sensors[0].value == pytest.approx(0.22)
    cleaned = all_ranges(clean_sweeps(wrong, rig, faults))
    assert (np.isnan(cleaned) == (all_ranges(wrong) == 0.22)).all()


def test_a_value_in_between_that_no_distance_explains_says_nothing() -> None:
    rig, sweeps = recorded(ROOM)
    hidden = np.random.default_rng(1).random(len(all_ranges(sweeps))) < 0.3
    wrong = with_readings(sweeps, lambda readings: np.where(hidden, 1.75, readings))
    faults = find_faults(wrong, rig)
    assert kinds(faults) == [(0, SensorFaultKind.FIXED_VALUE)]
    assert (all_ranges(clean_sweeps(wrong, rig, faults)) != 1.75).all()


@pytest.mark.parametrize("jitter", [0.0, 0.003])
def test_a_sensor_that_reads_one_value_at_all_places_is_left_out(jitter: float) -> None:
    rig, sweeps = recorded("sim:paper-room,rig=rotary-array,seed=21")
    rng = np.random.default_rng(0)
    wrong = with_readings(sweeps, lambda readings: 1.27 + rng.uniform(-jitter, jitter, len(readings)), sensor=2)
    faults = find_faults(wrong, rig)
    assert kinds(faults) == [(2, SensorFaultKind.STUCK)]
    assert faults.sensors[0].value == pytest.approx(1.27, abs=0.003)
    cleaned = clean_sweeps(wrong, rig, faults)
    assert np.isnan(np.concatenate([sweep.ranges[sweep.sensor_ids == 2] for sweep in cleaned])).all()
    assert (all_ranges(cleaned) == all_ranges(sweeps)).sum() == (
        np.concatenate([s.sensor_ids for s in sweeps]) != 2
    ).sum()


@pytest.mark.parametrize("heading", [0.0, 17.5, 33.0])
def test_a_side_sonar_that_drives_along_a_wall_is_not_stuck(heading: float) -> None:
    side = Sensor(sensor_id=1, yaw=math.pi / 2, half_aperture=0.52, min_range=0.02, max_range=4.0, resolution=0.003)
    yaw, rng = math.radians(heading), np.random.default_rng(0)
    way = [0.1 * k for k in range(120)]
    sweeps = tuple(
        Sweep(
            index=k,
            stamps_ns=np.array([k * 60_000_000]),
            sensor_ids=np.ones(1, dtype=np.int64),
            servo_angles=np.zeros(1),
            ranges=np.array([0.94 + 0.003 * round(rng.normal(0.0, 0.3))]),
            map_from_base=np.array([[s * math.cos(yaw), s * math.sin(yaw), yaw]]),
        )
        for k, s in enumerate(way)
    )
    assert find_faults(sweeps, Rig(name="car", sensors=(side,))) == Faults()


def test_a_sensor_without_echoes_where_others_have_some_is_dead() -> None:
    rig, sweeps = recorded("sim:paper-room,rig=rotary-array,seed=21")
    deaf = with_readings(sweeps, lambda readings: np.full(len(readings), np.inf), sensor=1)
    assert kinds(find_faults(deaf, rig)) == [(1, SensorFaultKind.DEAD)]
    seldom = with_readings(sweeps, lambda readings: np.where(np.arange(len(readings)) % 3, np.inf, readings), sensor=1)
    assert find_faults(seldom, rig) == Faults()


def test_a_few_pings_show_no_fault() -> None:
    rig, sweeps = recorded("sim:paper-room,rig=ring-16,seed=21")
    assert find_faults(with_readings(sweeps, lambda readings: np.full(len(readings), np.inf)), rig) == Faults()


@pytest.mark.parametrize("step", [0.003, 0.01])
def test_a_held_reading_says_nothing(step: float) -> None:
    rig, sweeps = recorded(ROOM)
    coarse = with_readings(sweeps, lambda readings: np.round(readings / step) * step)
    wrong = with_readings(coarse, holding)
    faults = find_faults(wrong, rig)
    assert kinds(faults) == [(0, SensorFaultKind.HELD)]
    kept = np.isfinite(all_ranges(clean_sweeps(wrong, rig, faults)))
    assert np.isfinite(all_ranges(coarse)[kept]).mean() > 0.99
    assert kept.sum() > 100


def test_a_reading_that_is_logged_several_times_counts_once() -> None:
    rig, sweeps = recorded(ROOM)
    rng = np.random.default_rng(2)

    def logged(readings: FloatArray) -> FloatArray:
        fine = readings + rng.normal(0.0, 0.004, len(readings))
        return np.repeat(fine, rng.integers(5, 9, len(fine)))[: len(readings)]

    wrong = with_readings(sweeps, logged)
    faults = find_faults(wrong, rig)
    assert kinds(faults) == [(0, SensorFaultKind.LOGGED_REPEATEDLY)]
    assert faults.sensors[0].value == pytest.approx(6.5, abs=1.0)
    cleaned = all_ranges(clean_sweeps(wrong, rig, faults))
    finite = cleaned[np.isfinite(cleaned)]
    assert (np.diff(finite) != 0.0).all()


def standing(times: int) -> tuple[Rig, tuple[Sweep, ...]]:
    """What a ring reads that fires several times at each station, in whole centimetres, without noise."""
    room = open_source("sim:two-room-flat,rig=ring-16", simulation=SimulationSettings(jitter=0.0))
    again = [sweep for sweep in room for _ in range(times)]
    return room.rig, tuple(
        replace(
            sweep,
            index=k,
            stamps_ns=sweep.stamps_ns - sweep.stamps_ns[0] + k * 10_000_000_000,
            ranges=np.round(sweep.ranges, 2),
        )
        for k, sweep in enumerate(again)
    )


@pytest.mark.parametrize("times", [4, 8])
def test_a_ring_that_fires_several_times_at_each_place_is_sound(times: int) -> None:
    rig, sweeps = standing(times)
    assert find_faults(sweeps, rig).sensors == ()


def test_a_reading_that_is_logged_several_times_at_one_place_counts_once() -> None:
    rig, sweeps = standing(12)
    rng = np.random.default_rng(4)

    def logged(readings: FloatArray) -> FloatArray:
        return np.repeat(readings[::4] + np.round(rng.normal(0.0, 0.02, len(readings) // 4), 2), 4)

    assert kinds(find_faults(with_readings(sweeps, logged), rig)) == [(0, SensorFaultKind.LOGGED_REPEATEDLY)]


@pytest.mark.parametrize("late", [4, 12])
def test_readings_while_the_servo_flies_back_say_nothing(late: int) -> None:
    rig, sweeps = recorded(ROOM)
    wrong = []
    for sweep in sweeps:
        forth = np.argsort(sweep.servo_angles, kind="stable")
        ranges = sweep.ranges[forth].copy()
        back = np.round(len(ranges) - 1 - (len(ranges) - 1 - late) * np.arange(late) / late).astype(int)
        ranges[:late] = ranges[back]
        wrong.append(replace(sweep, servo_angles=sweep.servo_angles[forth], ranges=ranges))
    faults = find_faults(wrong, rig)
    assert kinds(faults) == [(0, SensorFaultKind.FLYBACK)]
    assert late <= faults.sensors[0].value <= late + 2
    cleaned = clean_sweeps(wrong, rig, faults)
    assert all(np.isnan(sweep.ranges[:late]).all() for sweep in cleaned)
    assert all(np.isnan(sweep.ranges).sum() <= late + 2 for sweep in cleaned)


def test_a_mate_of_a_sensor_that_holds_readings_does_so_besides_its_own_fault() -> None:
    rig, recording = recorded("sim:paper-room,rig=rotary-array,seed=21")
    # The mate has an echo everywhere.
    sweeps = with_readings(with_readings(forth(recording), holding, sensor=2), without_gaps, sensor=3)
    late, wrong = 12, []
    for sweep in sweeps:
        own, ranges = np.flatnonzero(sweep.sensor_ids == 3), sweep.ranges.copy()
        back = np.round(len(own) - 1 - (len(own) - 1 - late) * np.arange(late) / late).astype(int)
        ranges[own[:late]] = ranges[own[back]]
        wrong.append(replace(sweep, ranges=ranges))
    held = [(2, SensorFaultKind.HELD), (3, SensorFaultKind.HELD)]
    assert kinds(find_faults(sweeps, rig)) == held
    assert kinds(find_faults(wrong, rig)) == [held[0], (3, SensorFaultKind.FLYBACK), held[1]]


def without_gaps(readings: FloatArray) -> FloatArray:
    detected = np.isfinite(readings)
    return np.interp(np.arange(len(readings)), np.flatnonzero(detected), readings[detected])


def test_sweeps_in_one_direction_without_flyback_are_sound() -> None:
    rig, sweeps = recorded(ROOM)
    assert find_faults(forth(sweeps), rig) == Faults()


def forth(sweeps: tuple[Sweep, ...]) -> tuple[Sweep, ...]:
    """The same pings in the order of their angles, so that the servo always sweeps the same way."""
    ways = [np.argsort(sweep.servo_angles, kind="stable") for sweep in sweeps]
    return tuple(
        replace(
            sweep,
            sensor_ids=sweep.sensor_ids[way],
            servo_angles=sweep.servo_angles[way],
            ranges=sweep.ranges[way],
        )
        for sweep, way in zip(sweeps, ways, strict=True)
    )


@pytest.mark.parametrize("rig", ["hc-sr04-servo", "rotary-array", "ring-16"])
def test_a_robot_that_moves_and_has_no_positions_is_found(rig: str) -> None:
    used, sweeps = recorded(f"sim:office,rig={rig},seed=21")
    faults = find_faults(moved(sweeps, np.zeros((len(sweeps), 3))), used)
    assert [fault.kind for fault in faults.recording] == [RecordingFaultKind.NO_POSES]
    assert faults.has_no_poses
    assert faults.is_from_one_place


def test_one_place_and_two_places_are_too_few() -> None:
    rig, sweeps = recorded(ROOM)
    again = tuple(
        replace(
            sweeps[0], index=k, stamps_ns=sweeps[0].stamps_ns + k * 20_000_000_000, ranges=sweeps[0].ranges + 0.001 * k
        )
        for k in range(3)
    )
    for chosen, kind in [
        (sweeps[:1], RecordingFaultKind.ONE_PLACE),
        (again, RecordingFaultKind.ONE_PLACE),
        (sweeps[:2], RecordingFaultKind.TWO_PLACES),
    ]:
        assert [fault.kind for fault in find_faults(chosen, rig).recording] == [kind]
    assert find_faults(sweeps[:3], rig).recording == ()


def test_rays_of_a_narrow_beam_are_no_sonar() -> None:
    rig, sweeps = recorded("sim:square,rig=rotary-array,seed=21")
    for degrees, found in [(1.0, [RecordingFaultKind.NARROW_BEAM]), (7.5, []), (15.0, [])]:
        using = ray_cones.with_cones(rig, np.radians(degrees))
        world = open_source("sim:square").world  # type: ignore[attr-defined]
        rays = ray_cones.cast(sweeps, world, using, rays=31, noise=0.002, rng=np.random.default_rng(0))
        assert [fault.kind for fault in find_faults(rays, using).recording] == found
        assert find_faults(rays, replace(using, rays=True)).recording == ()


def test_where_no_sensor_has_an_echo_that_is_said_and_mapped() -> None:
    rig, sweeps = recorded(ROOM)
    silent = with_readings(sweeps, lambda readings: np.full(len(readings), np.inf))
    faults = find_faults(silent, rig)
    assert kinds(faults) == [(0, SensorFaultKind.DEAD)]
    assert all(one is other for one, other in zip(clean_sweeps(silent, rig, faults), silent, strict=True))
